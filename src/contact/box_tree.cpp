#include <algorithm>
#include <bit>
#include <cmath>
#include <impact/contact/box_tree.hpp>
#include <impact/math/batch.hpp>
#include <utility>

namespace impact {

namespace {

constexpr int curve_bits = 10; // of the curve, per axis
constexpr double cells = 1 << curve_bits;

// Every third bit.
std::uint32_t spread(std::uint32_t x) {
  x = (x | (x << 16)) & 0x030000FFU;
  x = (x | (x << 8)) & 0x0300F00FU;
  x = (x | (x << 4)) & 0x030C30C3U;
  return (x | (x << 2)) & 0x09249249U;
}

using Keyed = std::pair<std::uint32_t, int>; // place on the curve, number

std::vector<Keyed> along_the_curve(std::span<const Box> boxes) {
  Box all;
  for (const Box& box : boxes) all.include(box);
  const double size = all.longest(), scale = size > 0 ? (cells - 1) / size : 0;
  std::vector<Keyed> keyed(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    std::uint32_t key = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double place = scale * ((boxes[i].low[k] + boxes[i].high[k]) / 2 - all.low[k]);
      key |= spread(static_cast<std::uint32_t>(std::clamp(place, 0.0, cells - 1))) << k;
    }
    keyed[i] = {key, static_cast<int>(i)};
  }
  return keyed;
}

// By the key, stable, digit by digit.
void sort_by_key(std::vector<Keyed>& keyed) {
  constexpr std::uint32_t digit = 10, values = 1U << digit;
  std::vector<Keyed> other(keyed.size());
  for (std::uint32_t shift = 0; shift < 3 * curve_bits; shift += digit) {
    std::vector<std::size_t> start(values + 1, 0);
    const auto value = [&](const Keyed& k) { return (k.first >> shift) & (values - 1); };
    for (const Keyed& k : keyed) ++start[value(k) + 1];
    for (std::size_t v = 0; v < values; ++v) start[v + 1] += start[v];
    for (const Keyed& k : keyed) other[start[value(k)]++] = k;
    keyed.swap(other);
  }
}

} // namespace

double Box::longest() const {
  double size = 0;
  for (std::size_t k = 0; k < 3; ++k) size = std::max(size, high[k] - low[k]);
  return size;
}

BoxTree::Eight::Eight() {
  for (std::size_t i = 0; i < width; ++i) set(i, Box());
}

void BoxTree::Eight::set(std::size_t i, const Box& box) {
  for (std::size_t k = 0; k < 3; ++k) {
    low[k][i] = box.low[k];
    high[k][i] = box.high[k];
  }
}

Box BoxTree::Eight::all() const {
  Box box;
  for (std::size_t k = 0; k < 3; ++k) {
    box.low[k] = *std::min_element(low[k].begin(), low[k].end());
    box.high[k] = *std::max_element(high[k].begin(), high[k].end());
  }
  return box;
}

unsigned BoxTree::Eight::meeting(const Box& box) const {
  unsigned mask = 0;
  for (std::size_t i = 0; i < width; i += lanes) {
    Mask meets = {Mask::Vector{} - 1};
    for (std::size_t k = 0; k < 3; ++k)
      meets = meets & (load(&low[k][i]) <= Batch(box.high[k])) & (Batch(box.low[k]) <= load(&high[k][i]));
    mask |= static_cast<unsigned>(bits(meets)) << i;
  }
  return mask;
}

BoxTree::BoxTree(std::span<const Box> boxes) {
  std::vector<Keyed> keyed = along_the_curve(boxes);
  sort_by_key(keyed);
  const auto eights = [](std::size_t count) { return (count + width - 1) / width; };
  level_.emplace_back(eights(keyed.size()));
  number_.reserve(keyed.size());
  for (std::size_t i = 0; i < keyed.size(); ++i) {
    number_.push_back(keyed[i].second);
    level_[0][i / width].set(i % width, boxes[static_cast<std::size_t>(keyed[i].second)]);
  }
  while (level_.back().size() > 1) {
    const std::vector<Eight>& below = level_.back();
    std::vector<Eight> above(eights(below.size()));
    for (std::size_t i = 0; i < below.size(); ++i) above[i / width].set(i % width, below[i].all());
    level_.push_back(std::move(above));
  }
}

void BoxTree::find_leaves(const Box& box, std::vector<std::uint32_t>& leaves) const {
  if (level_[0].empty()) return;
  // Depth first; a place is a level and a number on it. Never more than seven siblings wait on a level.
  std::array<std::pair<std::uint32_t, std::uint32_t>, 16 * width> stack;
  std::size_t waiting = 0;
  stack[waiting++] = {static_cast<std::uint32_t>(level_.size() - 1), 0};
  while (waiting > 0) {
    const auto [level, i] = stack[--waiting];
    if (level == 0) {
      leaves.push_back(i);
      continue;
    }
    for (unsigned mask = level_[level][i].meeting(box); mask != 0; mask &= mask - 1)
      stack[waiting++] = {level - 1, static_cast<std::uint32_t>(width * i) +
                                         static_cast<std::uint32_t>(std::countr_zero(mask))};
  }
}

void BoxTree::find_boxes(const Box& box, std::uint32_t leaf, std::vector<int>& found) const {
  for (unsigned mask = level_[0][leaf].meeting(box); mask != 0; mask &= mask - 1)
    found.push_back(number_[width * leaf + static_cast<std::size_t>(std::countr_zero(mask))]);
}

} // namespace impact
