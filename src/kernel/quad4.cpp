#include <impact/kernel/shape_of.hpp>

namespace impact {

namespace {
constexpr CellShape record = cell_shape<Quad4>();
}
constinit const Shape Shape::quad4{record};

} // namespace impact
