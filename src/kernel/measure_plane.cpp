#include "measure_cell.hpp"

namespace impact {

template void stored_energy<Tri3, Frame::plane_strain>(const PointLaw&, const EnergyInput&, EnergySums&);
template void stored_heat<Tri3, Frame::plane_strain>(const PointLaw&, const EnergyInput&, HeatSums&);
template void plastic_exchange<Tri3, Frame::plane_strain>(const PointLaw&, const ExchangeInput&, Batch*);
template void unilateral_energy<Tri3, Frame::plane_strain>(const PointLaw&, const Batch*, const Batch*,
                                                           const Batch*, const Batch*, const Batch*, Batch&);
template Batch cell_mean<Tri3, Frame::plane_strain>(const Batch*, const Batch*);
template Batch cell_integral<Tri3, Frame::plane_strain>(const Batch*, const Batch*);
template void cell_output<Tri3, Frame::plane_strain>(const PointLaw&, const MotionInput&, CellOutput&);
template void mass_matrix<Tri3, Frame::plane_strain>(const PointLaw&, const Batch*, Batch*);
template Batch cell_size<Tri3>(const Batch*);
template void stored_energy<Tri3, Frame::axisymmetric>(const PointLaw&, const EnergyInput&, EnergySums&);
template void stored_heat<Tri3, Frame::axisymmetric>(const PointLaw&, const EnergyInput&, HeatSums&);
template void plastic_exchange<Tri3, Frame::axisymmetric>(const PointLaw&, const ExchangeInput&, Batch*);
template void unilateral_energy<Tri3, Frame::axisymmetric>(const PointLaw&, const Batch*, const Batch*,
                                                           const Batch*, const Batch*, const Batch*, Batch&);
template Batch cell_mean<Tri3, Frame::axisymmetric>(const Batch*, const Batch*);
template Batch cell_integral<Tri3, Frame::axisymmetric>(const Batch*, const Batch*);
template void cell_output<Tri3, Frame::axisymmetric>(const PointLaw&, const MotionInput&, CellOutput&);
template void mass_matrix<Tri3, Frame::axisymmetric>(const PointLaw&, const Batch*, Batch*);
template void stored_energy<Quad4, Frame::plane_strain>(const PointLaw&, const EnergyInput&, EnergySums&);
template void stored_heat<Quad4, Frame::plane_strain>(const PointLaw&, const EnergyInput&, HeatSums&);
template void plastic_exchange<Quad4, Frame::plane_strain>(const PointLaw&, const ExchangeInput&, Batch*);
template void unilateral_energy<Quad4, Frame::plane_strain>(const PointLaw&, const Batch*, const Batch*,
                                                            const Batch*, const Batch*, const Batch*, Batch&);
template Batch cell_mean<Quad4, Frame::plane_strain>(const Batch*, const Batch*);
template Batch cell_integral<Quad4, Frame::plane_strain>(const Batch*, const Batch*);
template void cell_output<Quad4, Frame::plane_strain>(const PointLaw&, const MotionInput&, CellOutput&);
template void mass_matrix<Quad4, Frame::plane_strain>(const PointLaw&, const Batch*, Batch*);
template Batch cell_size<Quad4>(const Batch*);
template void stored_energy<Quad4, Frame::axisymmetric>(const PointLaw&, const EnergyInput&, EnergySums&);
template void stored_heat<Quad4, Frame::axisymmetric>(const PointLaw&, const EnergyInput&, HeatSums&);
template void plastic_exchange<Quad4, Frame::axisymmetric>(const PointLaw&, const ExchangeInput&, Batch*);
template void unilateral_energy<Quad4, Frame::axisymmetric>(const PointLaw&, const Batch*, const Batch*,
                                                            const Batch*, const Batch*, const Batch*, Batch&);
template Batch cell_mean<Quad4, Frame::axisymmetric>(const Batch*, const Batch*);
template Batch cell_integral<Quad4, Frame::axisymmetric>(const Batch*, const Batch*);
template void cell_output<Quad4, Frame::axisymmetric>(const PointLaw&, const MotionInput&, CellOutput&);
template void mass_matrix<Quad4, Frame::axisymmetric>(const PointLaw&, const Batch*, Batch*);
template void stored_energy<Tri3, Frame::plane_stress>(const PointLaw&, const EnergyInput&, EnergySums&);
template void stored_heat<Tri3, Frame::plane_stress>(const PointLaw&, const EnergyInput&, HeatSums&);
template Batch cell_mean<Tri3, Frame::plane_stress>(const Batch*, const Batch*);
template Batch cell_integral<Tri3, Frame::plane_stress>(const Batch*, const Batch*);
template void plastic_exchange<Tri3, Frame::plane_stress>(const PointLaw&, const ExchangeInput&, Batch*);
template void unilateral_energy<Tri3, Frame::plane_stress>(const PointLaw&, const Batch*, const Batch*,
                                                           const Batch*, const Batch*, const Batch*, Batch&);
template void cell_output<Tri3, Frame::plane_stress>(const PointLaw&, const MotionInput&, CellOutput&);
template void mass_matrix<Tri3, Frame::plane_stress>(const PointLaw&, const Batch*, Batch*);
template void stored_energy<Quad4, Frame::plane_stress>(const PointLaw&, const EnergyInput&, EnergySums&);
template void stored_heat<Quad4, Frame::plane_stress>(const PointLaw&, const EnergyInput&, HeatSums&);
template Batch cell_mean<Quad4, Frame::plane_stress>(const Batch*, const Batch*);
template Batch cell_integral<Quad4, Frame::plane_stress>(const Batch*, const Batch*);
template void plastic_exchange<Quad4, Frame::plane_stress>(const PointLaw&, const ExchangeInput&, Batch*);
template void unilateral_energy<Quad4, Frame::plane_stress>(const PointLaw&, const Batch*, const Batch*,
                                                            const Batch*, const Batch*, const Batch*, Batch&);
template void cell_output<Quad4, Frame::plane_stress>(const PointLaw&, const MotionInput&, CellOutput&);
template void mass_matrix<Quad4, Frame::plane_stress>(const PointLaw&, const Batch*, Batch*);

} // namespace impact
