#include "motion_cell.hpp"

namespace impact {

template CellStatus motion_residual<Hex8, Frame::solid>(const PointLaw&, const MotionInput&, Batch*);
template CellStatus motion_tangent<Hex8, Frame::solid>(const PointLaw&, const MotionInput&, Batch*, Batch*);
template CellStatus motion_advance<Hex8, Frame::solid>(const PointLaw&, const MotionInput&, Batch*, Batch*,
                                                       StepSums&, const HeatFeed&);

} // namespace impact
