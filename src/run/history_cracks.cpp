#include <algorithm>
#include <cmath>
#include <impact/run/crack_tips.hpp>
#include <impact/run/history_observer.hpp>

/// Columns of the history that stand for cracks.
namespace impact {

namespace {

// A crack as its row keeps it.
constexpr std::size_t numbers = HistoryObserver::numbers_of_crack;

Crack read(const double* kept) {
  Crack crack;
  if (kept[0] == 0) return crack;
  crack.there = true;
  std::copy_n(kept + 1, 3, crack.origin.begin());
  std::copy_n(kept + 4, 3, crack.from.begin());
  crack.since = kept[7];
  crack.speed = kept[8];
  return crack;
}

void write(const Crack& crack, double* kept) {
  kept[0] = crack.there;
  std::ranges::copy(crack.origin, kept + 1);
  std::ranges::copy(crack.from, kept + 4);
  kept[7] = crack.since;
  kept[8] = crack.speed;
}

} // namespace

void HistoryObserver::append_cracks(HistoryFile::Row& row, double time) {
  const Discretisation& d = motion_.discretisation();
  if (!phi_) return;
  if (phi_before_.empty()) phi_before_ = phi_->committed;
  for (const auto& [m, nodes, kept] : cracks_) {
    const MaterialParameters& p = d.materials[m].law.parameters;
    std::vector<Crack> cracks;
    for (std::size_t i = 0; i < kept.committed.size(); i += numbers)
      cracks.push_back(read(&kept.committed[i]));
    std::vector<char> cracked(d.node_values(1), 0);
    for (int node : nodes) cracked[at(node)] = phi_->committed[at(node)] > scenario_.crack_level;
    const int count = follow_cracks(d.mesh, cracked, phi_before_, cracks);
    row.emplace_back("crack_" + d.materials[m].id + "_count", count);
    for (std::size_t i = 0; i < cracks.size(); ++i) {
      Crack& crack = cracks[i];
      const bool has_tip = crack.there && !crack.joined;
      if (has_tip) follow_speed(crack, time, 2 * p.gamma);
      write(crack, &kept.committed[numbers * i]);
      const std::string id = "crack_" + d.materials[m].id + (i > 0 ? "_" + std::to_string(i + 1) : "");
      const Vector3 nowhere{NAN, NAN, NAN};
      add_axes(row, id + "_origin_", (crack.there ? crack.origin : nowhere).data(), at(d.dim()));
      add_axes(row, id + "_tip_", (has_tip ? crack.tip : nowhere).data(), at(d.dim()));
      row.emplace_back(id + "_speed", has_tip ? crack.speed : NAN);
    }
    kept.trial = kept.committed;
    row.emplace_back("crack_" + d.materials[m].id + "_measure",
                     ledger_.energies().of[m].fracture / (p.Gc * d.thickness));
  }
  phi_before_ = phi_->committed;
}

} // namespace impact
