#include <algorithm>
#include <impact/petsc/ranks.hpp>
#include <map>
#include <petscsys.h> // counts what is reduced

namespace impact {

namespace {

// MPI may cut an array anywhere, but not an entry of a type: the whole array is one entry.
void add_and_compare(void* in, void* in_out, int* entries, MPI_Datatype* type) {
  int bytes = 0;
  MPI_Type_size(*type, &bytes);
  const int size = bytes / static_cast<int>(sizeof(double));
  const double* from = static_cast<const double*>(in);
  double* to = static_cast<double*>(in_out);
  for (int entry = 0; entry < *entries; ++entry, from += size, to += size) {
    for (int i = 0; i + 1 < size; ++i) to[i] += from[i];
    to[size - 1] = std::min(to[size - 1], from[size - 1]);
  }
}

MPI_Op operation() {
  static const MPI_Op made = [] {
    MPI_Op op = MPI_OP_NULL;
    MPI_Op_create(add_and_compare, 1, &op);
    return op;
  }();
  return made;
}

// For as long as the program runs.
MPI_Datatype array_of(int size) {
  static std::map<int, MPI_Datatype> types;
  const auto [found, is_new] = types.emplace(size, MPI_DATATYPE_NULL);
  if (is_new) {
    MPI_Type_contiguous(size, MPI_DOUBLE, &found->second);
    MPI_Type_commit(&found->second);
  }
  return found->second;
}

} // namespace

void sum_and_min_over_ranks(MPI_Comm comm, std::span<double> values) {
  MPI_Allreduce(MPI_IN_PLACE, values.data(), 1, array_of(static_cast<int>(values.size())), operation(), comm);
}

} // namespace impact
