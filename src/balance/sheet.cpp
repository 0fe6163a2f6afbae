#include <impact/balance/ledger.hpp>

// The ledger as columns of the history, and as the sheet at the end of the log.
namespace impact {

// Contacts of before a restart may be gone: what they took and lost remains.
bool Ledger::has_contact() const { return !motion_.contacts().empty() || sum(contact_work) != 0; }
bool Ledger::has_friction() const { return motion_.contacts().demands().frictional || sum(friction) != 0; }

void Ledger::append(HistoryFile::Row& row) const {
  const Discretisation& d = motion_.discretisation();
  const bool contact = has_contact(), heat = d.has_heat();
  const bool damped = motion_.foundations().damps() || of_foundations(FoundationSum::loss) != 0;
  const MaterialEnergies& total = energies_.total;
  struct Column {
    const char* name;
    bool there;
    double value;
  };
  const Column columns[] = {
      {"energy_kinetic", moves_, total.kinetic},
      {"energy_elastic", moves_ || d.has_damage(), total.elastic},
      {"energy_plastic", d.has_plasticity(), total.plastic},
      {"energy_fracture", d.has_damage(), total.fracture},
      {"energy_fatigue", d.has_fatigue(), total.fatigue},
      {"energy_thermal", heat, total.thermal},
      {"dissipated_viscous", loses_by_viscosity(), sum(viscous)},
      {"dissipated_damage", d.has_damage(), sum(damage)},
      {"dissipated_plastic", d.has_plasticity(), sum(plastic_dissipation)},
      {"dissipated_friction", has_friction(), sum(friction)},
      {"dissipated_fatigue", d.has_fatigue(), sum(fatigue_loss)},
      {"energy_contact", contact, sum(contact_store)},
      {"energy_foundation", !motion_.foundations().empty(), of_foundations(FoundationSum::store)},
      {"dissipated_contact", contact && inertia_, sum(contact_loss)},
      {"dissipated_closing", choice_.unilateral, sum(closing)},
      {"dissipated_erosion", d.erodes(), eroded(ErosionTotals::energy)},
      {"dissipated_foundation", damped, of_foundations(FoundationSum::loss)},
      {"energy_numerical", inertia_, sum(kept)},
      {"dissipated_numerical", moves_, sum(numerical)},
      {"exchange_numerical", inertia_, sum(exchange)},
      {"gain", inertia_, gain()},
      {"work_external", moves_, sum(external)},
      {"work_damage", prescribes_damage_, sum(damage_work)},
      {"work_contact", contact, sum(contact_work)},
      {"heat_supplied", heat, heat_supplied()},
      {"entropy_produced", heat, heat ? heat_->entropy_produced(total.entropy) : 0},
      {"balance", moves_, balance()},
      {"balance_first_law", true, balance_first_law()},
      {"coupling_error", choice_.coupling_error, coupling_error_},
      {"phi_max", d.has_damage(), energies_.phi_max},
      {"alpha_max", d.has_plasticity(), energies_.alpha_max},
      {"theta_max", heat, energies_.theta_max},
      {"theta_min", heat, energies_.theta_min},
      {"fatigue_max", d.has_fatigue(), energies_.fatigue_max},
      {"jc_failure_max", d.has_failure(), energies_.failure_max},
      {"eroded_cells", d.erodes(), eroded(ErosionTotals::cells)},
      {"eroded_mass", d.erodes(), eroded(ErosionTotals::mass)},
      {"eroded_momentum_x", d.sheds_mass(), eroded(ErosionTotals::momentum)},
      {"eroded_momentum_y", d.sheds_mass(), eroded(ErosionTotals::momentum + 1)},
      {"eroded_momentum_z", d.sheds_mass() && d.dim() == 3, eroded(ErosionTotals::momentum + 2)}};
  for (const Column& column : columns)
    if (column.there) row.emplace_back(column.name, column.value);
  reactions_.append(row, [&](std::size_t condition) { return heat_->supplied_by(condition); });
}

void Ledger::append_contact_heat(HistoryFile::Row& row) const {
  for (std::size_t c = 0; heat_ && c < heat_->contacts().size(); ++c)
    row.emplace_back("heat_contact_" + heat_->contacts()[c], heat_->conducted(c));
}

void Ledger::append_materials(HistoryFile::Row& row) const {
  static constexpr const char* axis[3] = {"x", "y", "z"};
  const Discretisation& d = motion_.discretisation();
  for (std::size_t m = 0; m < energies_.of.size(); ++m) {
    const std::string& id = d.materials[m].id;
    const MaterialEnergies& part = energies_.of[m];
    if (d.has_heat()) row.emplace_back("energy_thermal_" + id, part.thermal);
    if (!moves_) continue;
    for (int k = 0; k < d.dim(); ++k) row.emplace_back("momentum_" + id + "_" + axis[k], part.momentum[k]);
    for (int k = d.dim() == 3 ? 0 : 2; inertia_ && d.frame != Frame::axisymmetric && k < 3; ++k)
      row.emplace_back("spin_" + id + "_" + axis[k], part.spin[k]);
    row.emplace_back("energy_kinetic_" + id, part.kinetic);
    row.emplace_back("energy_elastic_" + id, part.elastic);
    if (d.has_plasticity()) row.emplace_back("energy_plastic_" + id, part.plastic);
    if (!choice_.materials) continue;
    if (d.has_damage()) row.emplace_back("energy_fracture_" + id, part.fracture);
    if (d.has_fatigue()) row.emplace_back("energy_fatigue_" + id, part.fatigue);
    if (loses_by_viscosity()) row.emplace_back("dissipated_viscous_" + id, lost_in(m, viscous_loss));
    if (d.has_damage()) row.emplace_back("dissipated_damage_" + id, lost_in(m, damage_loss));
    if (d.has_plasticity()) row.emplace_back("dissipated_plastic_" + id, lost_in(m, plastic_loss));
    if (d.has_fatigue()) row.emplace_back("dissipated_fatigue_" + id, lost_in(m, fatigue_part));
  }
}

struct Ledger::Line {
  std::string name;
  bool there;
  double total;
  std::function<double(std::size_t)> of = {}; // of a material; empty: none of it
};

std::vector<Ledger::Line> Ledger::sheet() const {
  const Discretisation& d = motion_.discretisation();
  const bool contact = has_contact();
  const std::string became = heat_ ? " (heat)" : "";
  const auto stored = [&](const char* name, bool there, double MaterialEnergies::*member) -> Line {
    return {name, there, energies_.total.*member,
            [this, member](std::size_t m) { return energies_.of[m].*member; }};
  };
  const auto lost = [&](const char* name, bool there, Total total, Loss which) -> Line {
    return {name + became, there, sum(total), [this, which](std::size_t m) { return lost_in(m, which); }};
  };
  return {{"work of loads and supports", moves_, sum(external)},
          {"of that of prescribed phi", prescribes_damage_, sum(damage_work)},
          {"heat supplied", heat_.has_value(), heat_supplied()},
          {"at the start", true, sum(start_energy)},
          stored("stored: kinetic", inertia_, &MaterialEnergies::kinetic),
          stored("stored: elastic", moves_, &MaterialEnergies::elastic),
          stored("stored: plastic", d.has_plasticity(), &MaterialEnergies::plastic),
          stored("stored: fracture", d.has_damage(), &MaterialEnergies::fracture),
          stored("stored: fatigue", d.has_fatigue(), &MaterialEnergies::fatigue),
          stored("stored: thermal", heat_.has_value(), &MaterialEnergies::thermal),
          {"stored: contact", contact, sum(contact_store)},
          {"stored: foundations", !motion_.foundations().empty(), of_foundations(FoundationSum::store)},
          {"stored: integrator", inertia_, sum(kept)},
          lost("dissipated: viscous", loses_by_viscosity(), viscous, viscous_loss),
          lost("dissipated: damage", d.has_damage(), damage, damage_loss),
          lost("dissipated: plastic", d.has_plasticity(), plastic_dissipation, plastic_loss),
          lost("dissipated: fatigue", d.has_fatigue(), fatigue_loss, fatigue_part),
          {"dissipated: friction", has_friction(), sum(friction)},
          {"dissipated: contact", contact && inertia_, sum(contact_loss)},
          {"dissipated: closing cracks" + (state_.find("stress") ? became : ""), choice_.unilateral,
           sum(closing)},
          {"dissipated: foundations", of_foundations(FoundationSum::loss) != 0,
           of_foundations(FoundationSum::loss)},
          {"left with eroded cells", d.erodes(), eroded(ErosionTotals::energy)},
          {"dissipated: integrator", moves_, sum(numerical)},
          {"work of unbalanced forces", moves_, sum(unbalanced)},
          {"first-law residual", true, balance_first_law() * energy_scale()},
          {"smallest dissipation at a point", true, sum(least)}};
}

std::string Ledger::report() const {
  const auto& materials = motion_.discretisation().materials;
  const std::size_t columns = materials.size() > 1 ? materials.size() : 0;
  std::string text = text_of("%-32s %12s", "energy since t = 0", "total");
  for (std::size_t m = 0; m < columns; ++m) text += text_of(" %12.12s", materials[m].id.c_str());
  for (const Line& line : sheet()) {
    if (!line.there) continue;
    text += text_of("\n  %-30s %12.5g", line.name.c_str(), line.total);
    for (std::size_t m = 0; line.of && m < columns; ++m) text += text_of(" %12.5g", line.of(m));
  }
  return text + "\n";
}

} // namespace impact
