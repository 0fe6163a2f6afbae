#pragma once
#include <iterator>
#include <mpi.h>
#include <type_traits>

/// Sums, largest and smallest values over the ranks of a communicator: of a number as the result, of an array
/// in its place. Collective.
namespace impact {

namespace detail {
template <class Value> MPI_Datatype mpi_type() {
  static_assert(std::is_same_v<Value, double> || std::is_same_v<Value, int> || std::is_same_v<Value, long>);
  return std::is_same_v<Value, double> ? MPI_DOUBLE : std::is_same_v<Value, int> ? MPI_INT : MPI_LONG;
}

template <class Value>
Value reduce(MPI_Comm comm, Value value, MPI_Op operation) requires std::is_arithmetic_v<Value> {
  MPI_Allreduce(MPI_IN_PLACE, &value, 1, mpi_type<Value>(), operation, comm);
  return value;
}
template <class Array> void reduce(MPI_Comm comm, Array& values, MPI_Op operation) requires requires {
  std::data(values);
}
{
  using Value = std::remove_reference_t<decltype(*std::data(values))>;
  MPI_Allreduce(MPI_IN_PLACE, std::data(values), static_cast<int>(std::size(values)), mpi_type<Value>(),
                operation, comm);
}
} // namespace detail

template <class Values> auto sum_over_ranks(MPI_Comm comm, Values&& values) {
  return detail::reduce(comm, values, MPI_SUM);
}
template <class Values> auto max_over_ranks(MPI_Comm comm, Values&& values) {
  return detail::reduce(comm, values, MPI_MAX);
}
template <class Values> auto min_over_ranks(MPI_Comm comm, Values&& values) {
  return detail::reduce(comm, values, MPI_MIN);
}

/// What the rank with the smallest key has, of several the first one: plain data. Collective.
template <class Data> Data of_least(MPI_Comm comm, double key, Data data) {
  static_assert(std::is_trivially_copyable_v<Data>);
  struct {
    double key;
    int rank;
  } least = {key, 0};
  MPI_Comm_rank(comm, &least.rank);
  MPI_Allreduce(MPI_IN_PLACE, &least, 1, MPI_DOUBLE_INT, MPI_MINLOC, comm);
  MPI_Bcast(&data, sizeof data, MPI_BYTE, least.rank, comm);
  return data;
}

} // namespace impact
