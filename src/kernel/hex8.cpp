#include <impact/kernel/shape_of.hpp>

namespace impact {

namespace {
constexpr CellShape record = cell_shape<Hex8>();
}
constinit const Shape Shape::hex8{record};

} // namespace impact
