#include <impact/element/second_order.hpp>
#include <impact/kernel/shape_of.hpp>

namespace impact {

namespace {
constexpr CellShape record = cell_shape<Tri6>();
}
constinit const Shape Shape::tri6{record};

} // namespace impact
