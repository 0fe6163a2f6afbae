#include "measure_cell.hpp"

namespace impact {

template void stored_energy<Tet4, Frame::solid>(const PointLaw&, const EnergyInput&, EnergySums&);
template void stored_heat<Tet4, Frame::solid>(const PointLaw&, const EnergyInput&, HeatSums&);
template void plastic_exchange<Tet4, Frame::solid>(const PointLaw&, const ExchangeInput&, Batch*);
template void unilateral_energy<Tet4, Frame::solid>(const PointLaw&, const Batch*, const Batch*, const Batch*,
                                                    const Batch*, const Batch*, Batch&);
template Batch cell_mean<Tet4, Frame::solid>(const Batch*, const Batch*);
template Batch cell_integral<Tet4, Frame::solid>(const Batch*, const Batch*);
template void cell_output<Tet4, Frame::solid>(const PointLaw&, const MotionInput&, CellOutput&);
template void mass_matrix<Tet4, Frame::solid>(const PointLaw&, const Batch*, Batch*);
template Batch cell_size<Tet4>(const Batch*);
template void stored_energy<Hex8, Frame::solid>(const PointLaw&, const EnergyInput&, EnergySums&);
template void stored_heat<Hex8, Frame::solid>(const PointLaw&, const EnergyInput&, HeatSums&);
template void plastic_exchange<Hex8, Frame::solid>(const PointLaw&, const ExchangeInput&, Batch*);
template void unilateral_energy<Hex8, Frame::solid>(const PointLaw&, const Batch*, const Batch*, const Batch*,
                                                    const Batch*, const Batch*, Batch&);
template Batch cell_mean<Hex8, Frame::solid>(const Batch*, const Batch*);
template Batch cell_integral<Hex8, Frame::solid>(const Batch*, const Batch*);
template void cell_output<Hex8, Frame::solid>(const PointLaw&, const MotionInput&, CellOutput&);
template void mass_matrix<Hex8, Frame::solid>(const PointLaw&, const Batch*, Batch*);
template Batch cell_size<Hex8>(const Batch*);

} // namespace impact
