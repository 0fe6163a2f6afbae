#include "metis_parts.hpp"

#include <algorithm>
#include <cmath>
#include <impact/math/index.hpp>
#include <numeric>
#include <utility>

namespace impact {

namespace {

// Weights of several kinds, [vertex][kind], what METIS tolerates of each (null: its own choice), and where
// its random choices start.
struct Balance {
  idx_t* weight = nullptr;
  idx_t kinds = 1;
  real_t* tolerance = nullptr;
  idx_t seed = 1;
  bool bisect = false; // again and again; else all parts at once
};

// `cut` becomes the number of edges between parts.
int divide(idx_t parts, std::vector<idx_t>& start, std::vector<idx_t>& neighbour, Balance balance,
           std::vector<idx_t>& part, idx_t& cut) {
  idx_t vertices = static_cast<idx_t>(start.size()) - 1;
  part.assign(start.size() - 1, 0);
  cut = 0;
  if (parts <= 1) return METIS_OK;
  if (vertices <= parts) { // METIS itself is not made for as many parts as vertices
    std::iota(part.begin(), part.end(), idx_t{0});
    return METIS_OK;
  }
  idx_t options[METIS_NOPTIONS];
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_NUMBERING] = 0;
  options[METIS_OPTION_SEED] = balance.seed;
  const auto method = balance.bisect ? METIS_PartGraphRecursive : METIS_PartGraphKway;
  return method(&vertices, &balance.kinds, start.data(), neighbour.data(), balance.weight, nullptr, nullptr,
                &parts, nullptr, balance.tolerance, options, &cut, part.data());
}

// One kind of weight: its sum, and the smallest one that a vertex has.
struct Amount {
  double total = 0, unit = HUGE_VAL;
};

std::vector<Amount> amounts(const std::vector<idx_t>& weight, int kinds) {
  std::vector<Amount> of(at(kinds));
  for (std::size_t i = 0; i < weight.size(); ++i) {
    Amount& amount = of[i % at(kinds)];
    amount.total += weight[i];
    if (weight[i] > 0) amount.unit = std::min(amount.unit, static_cast<double>(weight[i]));
  }
  return of;
}

// How far the worst kind of weight is from an even one: 1 where all are even.
double unevenness(const std::vector<idx_t>& part, idx_t parts, const std::vector<idx_t>& weight,
                  const std::vector<Amount>& all) {
  double worst = 1;
  for (std::size_t k = 0; k < all.size(); ++k) {
    std::vector<double> sum(at(parts), 0.0);
    for (std::size_t v = 0; v < part.size(); ++v) sum[at(part[v])] += weight[v * all.size() + k];
    const double share = *std::ranges::max_element(sum) * parts / all[k].total;
    worst = std::max(worst, share / even_share(all[k].total, all[k].unit, parts));
  }
  return worst;
}

// What the fullest part has over the mean where units are dealt out one by one.
double least_share(double total, double unit, double parts) {
  const double units = total / unit / parts;
  return 1.000001 * std::ceil(units) / units;
}

} // namespace

double even_share(double total, double unit, double parts) {
  return total > 0 ? std::max(1.1, least_share(total, unit, parts)) : 1;
}

int metis_parts(idx_t parts, std::vector<idx_t>& start, std::vector<idx_t>& neighbour, idx_t* weight,
                std::vector<idx_t>& part) {
  idx_t cut = 0;
  return divide(parts, start, neighbour, {.weight = weight}, part, cut);
}

int metis_parts(idx_t parts, std::vector<idx_t>& start, std::vector<idx_t>& neighbour,
                std::vector<idx_t>& weight, int kinds, std::vector<idx_t>& part) {
  if (kinds == 1) return metis_parts(parts, start, neighbour, weight.data(), part);
  const std::vector<Amount> all = amounts(weight, kinds);
  // Tighter than even: METIS may miss them. What halves miss multiplies.
  const double halvings = std::max(1.0, std::ceil(std::log2(parts)));
  std::vector<real_t> tolerance,
      of_halves(at(kinds), static_cast<real_t>(1 + std::min(0.02, 0.08 / halvings)));
  for (const Amount& amount : all)
    tolerance.push_back(static_cast<real_t>(std::max(1.05, least_share(amount.total, amount.unit, parts))));
  // Bisection first: of a million cells METIS cuts up to twice the edges that one kind of weight needs when
  // it makes all parts at once, and an eighth more by bisection. In small graphs either may be better, and
  // random choices decide whether all kinds come out even and how many edges are cut: the best of some tries.
  constexpr idx_t most_tries = 16;
  constexpr double vertices_of_all_tries = 1e5;
  std::pair<double, idx_t> best{HUGE_VAL, 0}; // unevenness, cut
  std::vector<idx_t> found;
  for (idx_t k = 0; k < most_tries; ++k) {
    if (best.first <= 1 && k * static_cast<double>(start.size()) > vertices_of_all_tries) break;
    const bool bisect = k % 2 == 0;
    idx_t cut = 0;
    const int code = divide(
        parts, start, neighbour,
        {weight.data(), kinds, bisect ? of_halves.data() : tolerance.data(), 1 + k / 2, bisect}, found, cut);
    if (code != METIS_OK) return code;
    const std::pair quality{unevenness(found, parts, weight, all), cut};
    if (quality >= best) continue;
    best = quality;
    part = found;
  }
  return METIS_OK;
}

} // namespace impact
