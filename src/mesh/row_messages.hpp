#pragma once
#include <impact/mesh/node_graph.hpp>
#include <impact/petsc/error.hpp>
#include <petscmat.h>

/// Matrix rows that belong to other ranks, sent once per assembly.
namespace impact {

/// The rows for one neighbour stand side by side in the caller's buffer, so that it is the message. Not to be
/// copied: MPI keeps the addresses.
class RowMessages {
public:
  /// `matrix` gives the communicator with a tag of its own. `ghost`: values of the ghost rows, which must
  /// outlive this and stay in place. `ghost_base` and `received_base`: first value of each ghost row and of
  /// each received row, and one past the last. Collective.
  RowMessages(const NodeGraph& graph, Mat matrix, double* ghost, const std::vector<std::size_t>& ghost_base,
              const std::vector<std::size_t>& received_base)
      : received_(received_base.back()) {
    const auto at = [](const std::vector<std::size_t>& base, int k) {
      return base[static_cast<std::size_t>(k)];
    };
    const auto object = reinterpret_cast<PetscObject>(matrix);
    const MPI_Comm comm = PetscObjectComm(object);
    PetscMPIInt tag = 0;
    check(PetscObjectGetNewTag(object, &tag));
    for (const auto& from : graph.receive()) {
      const std::size_t first = at(received_base, from.first_row);
      MPI_Recv_init(received_.data() + first, static_cast<int>(at(received_base, from.end_row) - first),
                    MPI_DOUBLE, from.rank, tag, comm, &requests_.emplace_back());
    }
    for (const auto& to : graph.send()) {
      const std::size_t first = at(ghost_base, to.first_row);
      MPI_Send_init(ghost + first, static_cast<int>(at(ghost_base, to.end_row) - first), MPI_DOUBLE, to.rank,
                    tag, comm, &requests_.emplace_back());
    }
  }
  RowMessages(const RowMessages&) = delete;
  RowMessages& operator=(const RowMessages&) = delete;
  ~RowMessages() {
    int finalized = 0;
    MPI_Finalized(&finalized);
    if (!finalized)
      for (MPI_Request& request : requests_) MPI_Request_free(&request);
  }

  /// False where there is nobody to exchange rows with.
  bool any() const { return !requests_.empty(); }
  /// Sends the ghost rows; the received ones, in the order of the graph's received rows. Collective.
  const std::vector<double>& exchange() {
    MPI_Startall(static_cast<int>(requests_.size()), requests_.data());
    MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE);
    return received_;
  }

private:
  std::vector<double> received_;
  std::vector<MPI_Request> requests_; // persistent: receives, then sends
};

} // namespace impact
