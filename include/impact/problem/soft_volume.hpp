#pragma once
#include <impact/problem/volume_patches.hpp>
#include <vector>

/// Newton's method of the mixed form, in displacement and pressure, for bodies that hardly change their
/// volume, without unknowns for the pressure (theory.md, 7): forces stay those of the displacement, while
/// tangents take pressures that the linear solve before foretold (N4), and bulk moduli grow by stages.
namespace impact {

struct CellBatch;
struct PointLaw;
template <int capacity> struct BatchArray;

class SoftVolume {
public:
  explicit SoftVolume(const Discretisation& d);

  /// How many times as large as in the first stage K is in the end, of the laws that it works for: those of
  /// cells with a mean volume and one pressure, no split by principal stretches, no equation of state, no
  /// erosion; 1 without any.
  struct Growth {
    double elastic = 1, flowing = 1; ///< bodies that flow and break are none of the second
  };
  const Growth& growth() const { return growth_; }
  /// The law of the cells, with its present K.
  const PointLaw& law(const CellBatch& batch) const;
  /// K is that of the first stage from now on, and pressures are those of the displacement.
  void soften();
  /// K goes on the part of the way, in logarithms, and pressures stay what they are at `fields`. At 1 it has
  /// arrived.
  void stiffen(const PatchFields& fields, double part);
  /// Pressures follow a step from `fields` to the displacement `to`, as the slope of the volume tells; where
  /// none are kept nothing happens.
  void foretell(const PatchFields& fields, const std::vector<double>& to);
  /// Laws and pressures as the materials have them.
  void reset();

  bool keeps_pressures() const { return kept_; } ///< alike on all ranks
  /// p and dp/dJ of the cells for a tangent; null where the displacement tells them.
  const Batch* pressure(const CellBatch& batch, BatchArray<2>& values) const;
  /// Puts dp/dJ of the patches into the state of a tangent.
  void put_slopes(PatchState& patches) const;

private:
  void find(const PatchFields& fields, const std::vector<double>* to, const std::vector<PointLaw>& of,
            const std::vector<double>& growth);
  std::vector<PointLaw> laws_at(double part) const;

  const Discretisation& d_;
  Growth growth_;
  std::vector<PointLaw> laws_;      // as Discretisation::laws; empty: these
  bool kept_ = false;               // pressures, which are
  std::vector<double> pressure_;    // [group][batch][p, dp/dJ][lane]
  std::vector<double> patch_slope_; // [patch] dp/dJ
};

} // namespace impact
