#include <impact/element/second_order.hpp>
#include <impact/kernel/shape_of.hpp>

namespace impact {

namespace {
constexpr CellShape record = cell_shape<Tet10>();
}
constinit const Shape Shape::tet10{record};

} // namespace impact
