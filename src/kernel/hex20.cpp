#include <impact/element/second_order_products.hpp>
#include <impact/kernel/shape_of.hpp>

namespace impact {

namespace {
constexpr CellShape record = cell_shape<Hex20>();
}
constinit const Shape Shape::hex20{record};

} // namespace impact
