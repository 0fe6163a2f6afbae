#include "motion_cell.hpp"

namespace impact {

template CellStatus motion_residual<Tet4, Frame::solid>(const PointLaw&, const MotionInput&, Batch*);
template CellStatus motion_tangent<Tet4, Frame::solid>(const PointLaw&, const MotionInput&, Batch*, Batch*);
template CellStatus motion_advance<Tet4, Frame::solid>(const PointLaw&, const MotionInput&, Batch*, Batch*,
                                                       StepSums&, const HeatFeed&);

} // namespace impact
