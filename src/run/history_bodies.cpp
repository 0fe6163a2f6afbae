#include <impact/run/history_observer.hpp>

/// Columns of the history that stand for contacts and rigid bodies.
namespace impact {

void add_axes(HistoryFile::Row& row, const std::string& name, const double* values, std::size_t end,
              std::size_t first) {
  for (std::size_t k = first; k < end; ++k) row.emplace_back(name + "xyz"[k], values[k]);
}

void HistoryObserver::append_contacts(HistoryFile::Row& row, const Snapshot& snapshot) const {
  for (ContactInterface& contact : motion_.contacts()) {
    const ContactMeasures m = contact.measures(snapshot.u);
    const std::string id = "contact_" + contact.id() + "_";
    const std::size_t dim = at(motion_.discretisation().dim());
    add_axes(row, id + "force_", m.force.data(), dim);
    row.emplace_back(id + "gap_min", m.gap_min);
    row.emplace_back(id + "pressure_max", m.pressure_max);
    row.emplace_back(id + "pressure_min", m.pressure_min);
    row.emplace_back(id + "active", m.active);
    row.emplace_back(id + "length", m.length);
    row.emplace_back(id + "work", m.work);
    if (contact.frictional()) {
      row.emplace_back(id + "sliding", m.sliding);
      row.emplace_back(id + "dissipated", m.dissipated);
    }
    add_axes(row, "impulse_" + contact.id() + "_", m.impulse.data(), dim);
  }
}

void HistoryObserver::append_rigid_bodies(HistoryFile::Row& row, const Snapshot& snapshot) const {
  const RigidBodies& rigid = motion_.rigid();
  if (rigid.empty()) return;
  const Discretisation& d = motion_.discretisation();
  const std::size_t dim = at(d.dim()), first_turn = dim == 2 ? 2 : 0;
  const Handle<Vec> v = d.displacement.make_global();
  d.displacement.to_global(v_.committed, v);
  const std::vector<RigidMotionState> motion = rigid.motion(snapshot.u, v);
  for (std::size_t b = 0; b < motion.size(); ++b) {
    const std::string id = "rigid_" + rigid.bodies()[b].name + "_";
    Vector3 turned = rotation_vector(motion[b].pose.turned), spin = motion[b].spin;
    if (dim == 2) turned[2] = rigid.angle(static_cast<int>(b));
    for (double& component : spin) component = d.thickness * component;
    add_axes(row, id + "u", motion[b].pose.moved.data(), dim);
    add_axes(row, id + "r", turned.data(), 3, first_turn);
    add_axes(row, id + "v", motion[b].velocity.data(), dim);
    add_axes(row, id + "w", motion[b].velocity.data() + 3, 3, first_turn);
    add_axes(row, id + "l", spin.data(), 3, first_turn);
  }
}

} // namespace impact
