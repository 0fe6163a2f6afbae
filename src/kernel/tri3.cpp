#include <impact/kernel/shape_of.hpp>

namespace impact {

namespace {
constexpr CellShape record = cell_shape<Tri3>();
}
constinit const Shape Shape::tri3{record};

} // namespace impact
