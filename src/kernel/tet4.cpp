#include <impact/kernel/shape_of.hpp>

namespace impact {

namespace {
constexpr CellShape record = cell_shape<Tet4>();
}
constinit const Shape Shape::tet4{record};

} // namespace impact
