#include "motion_cell.hpp"

namespace impact {

template CellStatus motion_residual<Quad4, Frame::plane_strain>(const PointLaw&, const MotionInput&, Batch*);
template CellStatus motion_tangent<Quad4, Frame::plane_strain>(const PointLaw&, const MotionInput&, Batch*,
                                                               Batch*);
template CellStatus motion_advance<Quad4, Frame::plane_strain>(const PointLaw&, const MotionInput&, Batch*,
                                                               Batch*, StepSums&, const HeatFeed&);
template CellStatus motion_residual<Quad4, Frame::axisymmetric>(const PointLaw&, const MotionInput&, Batch*);
template CellStatus motion_tangent<Quad4, Frame::axisymmetric>(const PointLaw&, const MotionInput&, Batch*,
                                                               Batch*);
template CellStatus motion_advance<Quad4, Frame::axisymmetric>(const PointLaw&, const MotionInput&, Batch*,
                                                               Batch*, StepSums&, const HeatFeed&);
template CellStatus motion_residual<Quad4, Frame::plane_stress>(const PointLaw&, const MotionInput&, Batch*);
template CellStatus motion_tangent<Quad4, Frame::plane_stress>(const PointLaw&, const MotionInput&, Batch*,
                                                               Batch*);
template CellStatus motion_advance<Quad4, Frame::plane_stress>(const PointLaw&, const MotionInput&, Batch*,
                                                               Batch*, StepSums&, const HeatFeed&);

} // namespace impact
