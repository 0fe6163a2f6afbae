#pragma once
#include <impact/math/index.hpp>
#include <mpi.h>
#include <numeric>
#include <vector>

namespace impact {

/// One message to each rank, one from each: [rank] numbers. A step of a set-up, so that the dense exchange
/// does not matter. Collective.
template <class Number>
std::vector<std::vector<Number>> all_to_all(MPI_Comm comm, const std::vector<std::vector<Number>>& out) {
  const std::size_t ranks = out.size();
  std::vector<int> sendcount(ranks), receivecount(ranks), sendat(ranks + 1), receiveat(ranks + 1);
  for (std::size_t r = 0; r < ranks; ++r) sendcount[r] = static_cast<int>(out[r].size());
  MPI_Alltoall(sendcount.data(), 1, MPI_INT, receivecount.data(), 1, MPI_INT, comm);
  std::partial_sum(sendcount.begin(), sendcount.end(), sendat.begin() + 1);
  std::partial_sum(receivecount.begin(), receivecount.end(), receiveat.begin() + 1);
  std::vector<Number> packed, received(at(receiveat.back()));
  packed.reserve(at(sendat.back()));
  for (const auto& message : out) packed.insert(packed.end(), message.begin(), message.end());
  MPI_Datatype number = MPI_DATATYPE_NULL;
  MPI_Type_contiguous(sizeof(Number), MPI_BYTE, &number);
  MPI_Type_commit(&number);
  MPI_Alltoallv(packed.data(), sendcount.data(), sendat.data(), number, received.data(), receivecount.data(),
                receiveat.data(), number, comm);
  MPI_Type_free(&number);
  std::vector<std::vector<Number>> in(ranks);
  for (std::size_t r = 0; r < ranks; ++r)
    in[r].assign(received.begin() + receiveat[r], received.begin() + receiveat[r + 1]);
  return in;
}

} // namespace impact
