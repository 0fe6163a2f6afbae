#include <algorithm>
#include <impact/petsc/tally.hpp>
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
    const int sums = static_cast<int>(from[0]);
    for (int i = 1; i <= sums; ++i) to[i] += from[i];
    for (int i = sums + 1; i < size; ++i) to[i] = std::max(to[i], from[i]);
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

void Tally::reduce() {
  if (sums_.empty() && largest_.empty()) return;
  all_.assign(1, 0.0);
  for (const std::span<double> numbers : sums_) all_.insert(all_.end(), numbers.begin(), numbers.end());
  all_[0] = static_cast<double>(all_.size() - 1);
  for (const std::span<double> numbers : largest_) all_.insert(all_.end(), numbers.begin(), numbers.end());
  MPI_Allreduce(MPI_IN_PLACE, all_.data(), 1, array_of(static_cast<int>(all_.size())), operation(), comm_);
  auto next = all_.begin() + 1;
  for (const auto* parts : {&sums_, &largest_})
    for (const std::span<double> numbers : *parts) {
      std::copy_n(next, numbers.size(), numbers.begin());
      next += static_cast<std::ptrdiff_t>(numbers.size());
    }
  forget();
}

} // namespace impact
