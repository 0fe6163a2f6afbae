#include <algorithm>
#include <cmath>
#include <impact/run/crack_tips.hpp>
#include <impact/run/history_observer.hpp>

/// Columns of the history that stand for cracks.
namespace impact {

void HistoryObserver::append_cracks(HistoryFile::Row& row) {
  const Discretisation& d = motion_.discretisation();
  if (!phi_) return;
  if (phi_before_.empty()) phi_before_ = phi_->committed;
  for (const auto& [m, nodes, kept] : cracks_) {
    const MaterialParameters& p = d.materials[m].law.parameters;
    std::vector<Crack> cracks(kept.committed.size() / 4);
    for (std::size_t i = 0; i < cracks.size(); ++i) {
      cracks[i].there = kept.committed[4 * i] != 0;
      std::copy_n(&kept.committed[4 * i + 1], 3, cracks[i].origin.begin());
    }
    std::vector<char> cracked(d.node_values(1), 0);
    for (int node : nodes) cracked[at(node)] = phi_->committed[at(node)] > scenario_.crack_level;
    const int count = follow_cracks(d.mesh, cracked, phi_before_, cracks);
    row.emplace_back("crack_" + d.materials[m].id + "_count", count);
    for (std::size_t i = 0; i < cracks.size(); ++i) {
      const Crack& crack = cracks[i];
      kept.committed[4 * i] = crack.there;
      std::copy_n(crack.origin.begin(), 3, &kept.committed[4 * i + 1]);
      const std::string id = "crack_" + d.materials[m].id + (i > 0 ? "_" + std::to_string(i + 1) : "");
      const Vector3 nowhere{NAN, NAN, NAN};
      add_axes(row, id + "_origin_", (crack.there ? crack.origin : nowhere).data(), at(d.dim()));
      add_axes(row, id + "_tip_", (crack.there && !crack.joined ? crack.tip : nowhere).data(), at(d.dim()));
    }
    kept.trial = kept.committed;
    row.emplace_back("crack_" + d.materials[m].id + "_measure",
                     ledger_.energies().of[m].fracture / (p.Gc * d.thickness));
  }
  phi_before_ = phi_->committed;
}

} // namespace impact
