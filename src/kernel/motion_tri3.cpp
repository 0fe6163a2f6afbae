#include "motion_cell.hpp"

namespace impact {

template CellStatus motion_residual<Tri3, Frame::plane_strain>(const PointLaw&, const MotionInput&, Batch*);
template CellStatus motion_tangent<Tri3, Frame::plane_strain>(const PointLaw&, const MotionInput&, Batch*,
                                                              Batch*);
template CellStatus motion_advance<Tri3, Frame::plane_strain>(const PointLaw&, const MotionInput&, Batch*,
                                                              Batch*, StepSums&, const HeatFeed&);
template CellStatus motion_residual<Tri3, Frame::axisymmetric>(const PointLaw&, const MotionInput&, Batch*);
template CellStatus motion_tangent<Tri3, Frame::axisymmetric>(const PointLaw&, const MotionInput&, Batch*,
                                                              Batch*);
template CellStatus motion_advance<Tri3, Frame::axisymmetric>(const PointLaw&, const MotionInput&, Batch*,
                                                              Batch*, StepSums&, const HeatFeed&);
template CellStatus motion_residual<Tri3, Frame::plane_stress>(const PointLaw&, const MotionInput&, Batch*);
template CellStatus motion_tangent<Tri3, Frame::plane_stress>(const PointLaw&, const MotionInput&, Batch*,
                                                              Batch*);
template CellStatus motion_advance<Tri3, Frame::plane_stress>(const PointLaw&, const MotionInput&, Batch*,
                                                              Batch*, StepSums&, const HeatFeed&);

} // namespace impact
