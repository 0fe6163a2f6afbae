#include "metis_parts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <impact/math/index.hpp>
#include <impact/mesh/two_level.hpp>
#include <impact/petsc/field_solver.hpp>
#include <impact/petsc/handle.hpp>
#include <map>
#include <petsc/private/pcimpl.h>
#include <petscksp.h>
#include <string>
#include <vector>

namespace impact {

namespace {

constexpr int most_modes = 6;
using Modes = std::array<double, most_modes>; // a row of P
using Block = std::array<double, most_modes * most_modes>;

// One row of a matrix while it lives; of one that stores its upper blocks, those.
class MatrixRow {
public:
  MatrixRow(Mat A, PetscInt row) : A_(A), row_(row) {
    check(MatGetRow(A_, row_, &count_, &columns_, &values_));
  }
  MatrixRow(const MatrixRow&) = delete;
  MatrixRow& operator=(const MatrixRow&) = delete;
  ~MatrixRow() { MatRestoreRow(A_, row_, &count_, &columns_, &values_); }
  PetscInt count() const { return count_; }
  PetscInt column(PetscInt k) const { return columns_[k]; }
  double value(PetscInt k) const { return values_[k]; }

private:
  Mat A_;
  PetscInt row_, count_ = 0;
  const PetscInt* columns_ = nullptr;
  const PetscScalar* values_ = nullptr;
};

// Members beyond twelve: what is set up once for a pattern, and what for each matrix.
class TwoLevel {
public:
  void set_options(PC pc, PetscOptionItems* items);
  void set_up(PC pc);
  void apply(Vec r, Vec z);
  void reset() {
    const PetscInt nodes = nodes_;
    *this = TwoLevel{};
    nodes_ = nodes;
  }

private:
  void make_coarse_solver(PC pc);
  void suit_coarse_solver();
  void find_range(Mat A);
  void read_graph(Mat A);
  void make_aggregates(const std::vector<std::vector<idx_t>>& near, MPI_Comm comm);
  void make_prolongator(Mat A);
  void orthonormalise(const std::vector<PetscInt>& rows);
  void fetch_foreign(Mat A);
  void make_coarse_matrix(Mat A);
  const Modes& modes_of(PetscInt row) const {
    return row >= first_ && row < end_ ? prolongator_[at(row - first_)] : foreign_modes_[place_of(row)];
  }
  PetscInt aggregate_of(PetscInt row) const { // global
    return row >= first_ && row < end_ ? first_aggregate_ + aggregate_[at((row - first_) / block_)]
                                       : foreign_aggregate_[place_of(row)];
  }
  std::size_t place_of(PetscInt row) const {
    return at(std::lower_bound(foreign_.begin(), foreign_.end(), row) - foreign_.begin());
  }

  PetscInt nodes_ = 150; // of an aggregate
  bool half_ = false;    // the matrix stores its upper blocks
  PetscInt first_ = 0, end_ = 0, block_ = 1;
  int modes_ = 1;
  PetscInt aggregates_ = 0, first_aggregate_ = 0;
  std::vector<idx_t> aggregate_;     // [node]
  std::vector<char> joined_;         // [row] to any other one, by an entry that is not zero
  std::vector<Modes> prolongator_;   // [row]
  std::vector<PetscInt> foreign_;    // rows of other ranks in the columns of this one, ascending
  std::vector<Modes> foreign_modes_; // of them
  std::vector<PetscInt> foreign_aggregate_;
  Handle<Vec> inverse_, coarse_r_, coarse_z_;
  Handle<Mat> E_;
  Handle<KSP> coarse_;
  bool chosen_ = false; // its preconditioner, by the options
};

void TwoLevel::set_options(PC pc, PetscOptionItems* PetscOptionsObject) {
  check(PetscOptionsBoundedInt("-pc_two_level_nodes", "nodes of an aggregate", "", nodes_, &nodes_, nullptr,
                               1));
  make_coarse_solver(pc);
}

void TwoLevel::make_coarse_solver(PC pc) {
  if (coarse_) return;
  const char* prefix = nullptr;
  check(PCGetOptionsPrefix(pc, &prefix));
  check(KSPCreate(PetscObjectComm(reinterpret_cast<PetscObject>(pc)), coarse_.out()));
  check(KSPSetOptionsPrefix(coarse_, (std::string(prefix ? prefix : "") + "coarse_").c_str()));
  check(KSPSetType(coarse_, KSPPREONLY));
  suit_coarse_solver();
  for (const char* option : {"-pc_type", "-pc_factor_mat_solver_type"}) {
    PetscBool given = PETSC_FALSE;
    check(PetscOptionsHasName(nullptr, Get(KSPGetOptionsPrefix)(coarse_.get()), option, &given));
    chosen_ = chosen_ || given;
  }
  check(KSPSetFromOptions(coarse_));
}

// By MUMPS on all ranks together, or by PETSc's factors of all of it on each rank: 1,250 unknowns take these
// 0.13 ms on one rank and on two, and MUMPS 0.36 and 0.40 ms (1.1 on 16 ranks). To factorise 9,400 takes
// PETSc eight times as long as MUMPS.
void TwoLevel::suit_coarse_solver() {
  constexpr PetscInt most_copied = 3000;
  const PC direct = Get(KSPGetPC)(coarse_.get());
  PetscInt unknowns = 0;
  if (E_) check(MatGetSize(E_, &unknowns, nullptr));
  if (E_ && unknowns <= most_copied) return check(PCSetType(direct, PCREDUNDANT));
  check(PCSetType(direct, PCLU));
  check(PCFactorSetMatSolverType(direct, MATSOLVERMUMPS));
}

void TwoLevel::find_range(Mat A) {
  check(MatGetOwnershipRange(A, &first_, &end_));
  check(MatGetBlockSize(A, &block_));
  half_ = has_type(A, MATSBAIJ, MATSEQSBAIJ, MATMPISBAIJ);
}

// What the pattern and the zeros of the matrix say of the rows of this rank.
void TwoLevel::read_graph(Mat A) {
  const idx_t count = (end_ - first_) / block_;
  joined_.assign(at(end_ - first_), 0);
  foreign_.clear();
  std::vector<std::vector<idx_t>> near(at(count));
  for (PetscInt r = first_; r < end_; ++r) {
    const MatrixRow row(A, r);
    const idx_t i = (r - first_) / block_;
    const bool first_of_node = r % block_ == 0;
    for (PetscInt k = 0; k < row.count(); ++k) {
      const PetscInt c = row.column(k);
      const bool own = c >= first_ && c < end_;
      if (c != r && row.value(k) != 0) {
        joined_[at(r - first_)] = 1;
        if (own) joined_[at(c - first_)] = 1;
      }
      if (!own)
        foreign_.push_back(c);
      else if (const idx_t j = (c - first_) / block_; j != i && first_of_node && c % block_ == 0) {
        near[at(i)].push_back(j);
        if (half_) near[at(j)].push_back(i);
      }
    }
  }
  std::sort(foreign_.begin(), foreign_.end());
  foreign_.erase(std::unique(foreign_.begin(), foreign_.end()), foreign_.end());
  make_aggregates(near, PetscObjectComm(reinterpret_cast<PetscObject>(A)));
}

// Of the nodes of this rank, by its own part of the graph.
void TwoLevel::make_aggregates(const std::vector<std::vector<idx_t>>& near, MPI_Comm comm) {
  std::vector<idx_t> start{0}, neighbour;
  for (const auto& list : near) {
    neighbour.insert(neighbour.end(), list.begin(), list.end());
    start.push_back(static_cast<idx_t>(neighbour.size()));
  }
  const auto nodes = static_cast<idx_t>(near.size());
  aggregates_ = std::max<idx_t>(nodes > 0, (nodes + nodes_ / 2) / nodes_);
  check(metis_parts(aggregates_, start, neighbour, nullptr, aggregate_) == METIS_OK ? 0 : PETSC_ERR_LIB);
  first_aggregate_ = 0;
  MPI_Exscan(&aggregates_, &first_aggregate_, 1, MPIU_INT, MPI_SUM, comm);
}

// Near null vectors, or a constant per component, without the rows that are joined to no other one.
void TwoLevel::make_prolongator(Mat A) {
  MatNullSpace near = nullptr;
  PetscInt count = 0;
  const Vec* vecs = nullptr;
  check(MatGetNearNullSpace(A, &near));
  if (near != nullptr) check(MatNullSpaceGetVecs(near, nullptr, &count, &vecs));
  modes_ = static_cast<int>(count > 0 ? std::min<PetscInt>(count, most_modes) : block_);
  prolongator_.assign(joined_.size(), Modes{});
  for (int m = 0; m < modes_; ++m) {
    if (count > 0) {
      const Entries mode(vecs[m]);
      for (std::size_t r = 0; r < joined_.size(); ++r)
        if (joined_[r]) prolongator_[r][at(m)] = mode[r];
    } else
      for (std::size_t r = at(m); r < joined_.size(); r += at(block_)) prolongator_[r][at(m)] = joined_[r];
  }
  std::vector<std::vector<PetscInt>> rows(at(aggregates_));
  for (std::size_t r = 0; r < joined_.size(); ++r)
    rows[at(aggregate_[r / at(block_)])].push_back(static_cast<PetscInt>(r));
  for (const auto& list : rows) orthonormalise(list);
}

// Gram and Schmidt, twice; what depends on the modes before vanishes.
void TwoLevel::orthonormalise(const std::vector<PetscInt>& rows) {
  const auto dot = [&](int a, int b) {
    double sum = 0;
    for (const PetscInt r : rows) sum += prolongator_[at(r)][at(a)] * prolongator_[at(r)][at(b)];
    return sum;
  };
  for (int m = 0; m < modes_; ++m) {
    const double before = std::sqrt(dot(m, m));
    for (int round = 0; round < 2; ++round)
      for (int b = 0; b < m; ++b) {
        const double part = dot(m, b);
        for (const PetscInt r : rows) prolongator_[at(r)][at(m)] -= part * prolongator_[at(r)][at(b)];
      }
    const double norm = std::sqrt(dot(m, m)), factor = norm > 1e-6 * before ? 1 / norm : 0;
    for (const PetscInt r : rows) prolongator_[at(r)][at(m)] *= factor;
  }
}

void TwoLevel::fetch_foreign(Mat A) {
  Handle<Vec> own, there;
  Handle<IS> rows;
  Handle<PetscSF> scatter;
  const auto count = static_cast<PetscInt>(foreign_.size());
  check(MatCreateVecs(A, own.out(), nullptr));
  check(ISCreateGeneral(PETSC_COMM_SELF, count, foreign_.data(), PETSC_COPY_VALUES, rows.out()));
  check(VecCreateSeq(PETSC_COMM_SELF, count, there.out()));
  check(VecScatterCreate(own, rows, there, nullptr, scatter.out()));
  foreign_modes_.assign(foreign_.size(), Modes{});
  foreign_aggregate_.assign(foreign_.size(), 0);
  const auto fetch = [&](auto mine, auto take) {
    double* values = nullptr;
    check(VecGetArray(own, &values));
    for (std::size_t r = 0; r < prolongator_.size(); ++r) values[r] = mine(r);
    check(VecRestoreArray(own, &values));
    check(VecScatterBegin(scatter, own, there, INSERT_VALUES, SCATTER_FORWARD));
    check(VecScatterEnd(scatter, own, there, INSERT_VALUES, SCATTER_FORWARD));
    const Entries got(there);
    for (std::size_t i = 0; i < foreign_.size(); ++i) take(i, got[i]);
  };
  for (int m = 0; m < modes_; ++m)
    fetch([&](std::size_t r) { return prolongator_[r][at(m)]; },
          [&](std::size_t i, double value) { foreign_modes_[i][at(m)] = value; });
  fetch([&](std::size_t r) { return static_cast<double>(first_aggregate_ + aggregate_[r / at(block_)]); },
        [&](std::size_t i, double value) { foreign_aggregate_[i] = static_cast<PetscInt>(value); });
}

// E = P^T A P, row by row of A.
void TwoLevel::make_coarse_matrix(Mat A) {
  std::map<std::pair<PetscInt, PetscInt>, Block> blocks;
  struct Sum {
    PetscInt aggregate;
    Modes all, above; // above: of blocks that stand for those below the diagonal too
  };
  std::vector<Sum> sums;
  const auto n = at(modes_);
  for (PetscInt r = first_; r < end_; ++r) {
    const MatrixRow row(A, r);
    sums.clear();
    for (PetscInt k = 0; k < row.count(); ++k) {
      const PetscInt c = row.column(k), to = aggregate_of(c);
      const double value = row.value(k);
      if (value == 0) continue;
      auto sum = std::find_if(sums.begin(), sums.end(), [&](const Sum& s) { return s.aggregate == to; });
      if (sum == sums.end()) sum = sums.insert(sums.end(), Sum{to, {}, {}});
      const Modes& p = modes_of(c);
      const bool above = half_ && c / block_ != r / block_;
      for (std::size_t m = 0; m < n; ++m) sum->all[m] += value * p[m];
      if (above)
        for (std::size_t m = 0; m < n; ++m) sum->above[m] += value * p[m];
    }
    const PetscInt from = aggregate_of(r);
    const Modes& p = prolongator_[at(r - first_)];
    for (const Sum& sum : sums) {
      Block& block = blocks[{from, sum.aggregate}];
      for (std::size_t a = 0; a < n; ++a)
        for (std::size_t b = 0; b < n; ++b) block[a * n + b] += p[a] * sum.all[b];
      if (!half_) continue;
      Block& other = blocks[{sum.aggregate, from}];
      for (std::size_t a = 0; a < n; ++a)
        for (std::size_t b = 0; b < n; ++b) other[a * n + b] += sum.above[a] * p[b];
    }
  }
  const PetscInt size = aggregates_ * modes_, first = first_aggregate_, end = first + aggregates_;
  std::vector<PetscInt> own(at(aggregates_), 1), rest(at(aggregates_), 8);
  for (const auto& [place, block] : blocks)
    if (place.first >= first && place.first < end)
      ++(place.second >= first && place.second < end ? own : rest)[at(place.first - first)];
  check(KSPReset(coarse_));
  check(MatCreate(PetscObjectComm(reinterpret_cast<PetscObject>(A)), E_.out()));
  check(MatSetSizes(E_, size, size, PETSC_DETERMINE, PETSC_DETERMINE));
  check(MatSetBlockSize(E_, modes_));
  check(MatSetType(E_, MATAIJ));
  check(MatXAIJSetPreallocation(E_, modes_, own.data(), rest.data(), nullptr, nullptr));
  check(MatSetOption(E_, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE));
  for (auto& [place, block] : blocks) {
    if (place.first == place.second && place.first >= first && place.first < end)
      for (std::size_t m = 0; m < n; ++m)
        if (block[m * n + m] == 0) block[m * n + m] = 1; // a mode that vanished
    check(MatSetValuesBlocked(E_, 1, &place.first, 1, &place.second, block.data(), ADD_VALUES));
  }
  check(MatAssemblyBegin(E_, MAT_FINAL_ASSEMBLY));
  check(MatAssemblyEnd(E_, MAT_FINAL_ASSEMBLY));
  check(MatCreateVecs(E_, coarse_z_.out(), coarse_r_.out()));
  if (!chosen_) suit_coarse_solver();
  check(KSPSetOperators(coarse_, E_, E_));
  check(KSPSetUp(coarse_));
}

void TwoLevel::set_up(PC pc) {
  const Mat A = pc->pmat;
  make_coarse_solver(pc);
  const bool first = !E_ || pc->flag == DIFFERENT_NONZERO_PATTERN;
  if (first) find_range(A);
  if (half_) check(MatGetRowUpperTriangular(A));
  if (first) {
    read_graph(A);
    make_prolongator(A);
    fetch_foreign(A);
    check(MatCreateVecs(A, inverse_.out(), nullptr));
  }
  make_coarse_matrix(A);
  if (half_) check(MatRestoreRowUpperTriangular(A));
  check(MatGetDiagonal(A, inverse_));
  check(VecReciprocal(inverse_));
}

void TwoLevel::apply(Vec r, Vec z) {
  const auto n = at(modes_), block = at(block_);
  {
    double* coarse = nullptr;
    check(VecSet(coarse_r_, 0));
    check(VecGetArray(coarse_r_, &coarse));
    const Entries fine(r);
    for (std::size_t i = 0; i < prolongator_.size(); ++i) {
      double* to = coarse + at(aggregate_[i / block]) * n;
      for (std::size_t m = 0; m < n; ++m) to[m] += prolongator_[i][m] * fine[i];
    }
    check(VecRestoreArray(coarse_r_, &coarse));
  }
  check(KSPSolve(coarse_, coarse_r_, coarse_z_));
  check(VecPointwiseMult(z, inverse_, r));
  double* fine = nullptr;
  check(VecGetArray(z, &fine));
  const Entries coarse(coarse_z_);
  for (std::size_t i = 0; i < prolongator_.size(); ++i) {
    const std::size_t from = at(aggregate_[i / block]) * n;
    double sum = 0;
    for (std::size_t m = 0; m < n; ++m) sum += prolongator_[i][m] * coarse[from + m];
    fine[i] += sum;
  }
  check(VecRestoreArray(z, &fine));
}

TwoLevel& data(PC pc) { return *static_cast<TwoLevel*>(pc->data); }

PetscErrorCode create(PC pc) {
  pc->data = new TwoLevel;
  pc->ops->setup = [](PC made) { return guarded([&] { data(made).set_up(made); }); };
  pc->ops->apply = [](PC made, Vec r, Vec z) { return guarded([&] { data(made).apply(r, z); }); };
  pc->ops->setfromoptions = [](PC made, PetscOptionItems* items) {
    return guarded([&] { data(made).set_options(made, items); });
  };
  pc->ops->reset = [](PC made) -> PetscErrorCode {
    data(made).reset();
    return 0;
  };
  pc->ops->destroy = [](PC made) -> PetscErrorCode {
    delete &data(made);
    made->data = nullptr;
    return 0;
  };
  return 0;
}

} // namespace

void register_two_level() { check(PCRegister(two_level_type, create)); }

} // namespace impact
