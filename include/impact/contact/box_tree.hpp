#pragma once
#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

/// Which of many boxes meet a box: eight in a leaf, eight leaves in a node and so on, in the order of a curve
/// through space (Morton). Building takes O(n); a query compares with eight boxes at once.
namespace impact {

/// Along the axes of space; one that includes nothing is inverted and meets nothing.
struct Box {
  static constexpr double far_away = std::numeric_limits<double>::infinity();
  std::array<double, 3> low = {far_away, far_away, far_away}, high = {-far_away, -far_away, -far_away};

  void include(const double* x) {
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = x[k] < low[k] ? x[k] : low[k];
      high[k] = x[k] > high[k] ? x[k] : high[k];
    }
  }
  void include(const Box& other) {
    if (!(other.low[0] <= other.high[0])) return;
    include(other.low.data());
    include(other.high.data());
  }
  Box grown(double by) const {
    Box box = *this;
    for (std::size_t k = 0; k < 3; ++k) {
      box.low[k] -= by;
      box.high[k] += by;
    }
    return box;
  }
  bool meets(const Box& o) const {
    bool apart = false;
    for (std::size_t k = 0; k < 3; ++k) apart = apart || !(low[k] <= o.high[k] && o.low[k] <= high[k]);
    return !apart;
  }
  double longest() const;
};

class BoxTree {
public:
  explicit BoxTree(std::span<const Box> boxes);

  /// Appends to `leaves` those that hold boxes near this one.
  void find_leaves(const Box& box, std::vector<std::uint32_t>& leaves) const;
  /// Appends to `found` the numbers of the boxes of a leaf that meet this one.
  void find_boxes(const Box& box, std::uint32_t leaf, std::vector<int>& found) const;

private:
  static constexpr std::size_t width = 8;
  struct Eight {
    std::array<std::array<double, width>, 3> low, high; // [axis][box]
    Eight();
    void set(std::size_t i, const Box& box);
    Box all() const;
    unsigned meeting(const Box& box) const; // bit i: the box i does
  };

  std::vector<std::vector<Eight>> level_; // the leaves first
  std::vector<int> number_;               // of a box, [leaf][box]
};

} // namespace impact
