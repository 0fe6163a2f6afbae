#include <impact/element/second_order_products.hpp>
#include <impact/kernel/shape_of.hpp>

namespace impact {

namespace {
constexpr CellShape record = cell_shape<Quad9>();
}
constinit const Shape Shape::quad9{record};

} // namespace impact
