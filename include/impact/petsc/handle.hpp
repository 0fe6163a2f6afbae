#pragma once
#include <cassert>
#include <petscdmplex.h>
#include <petscsf.h>
#include <petscsnes.h>
#include <petscts.h>
#include <utility>

namespace impact {

namespace detail {
template <class Raw> struct Destroy;
template <> struct Destroy<Vec> { static constexpr auto call = VecDestroy; };
template <> struct Destroy<Mat> { static constexpr auto call = MatDestroy; };
template <> struct Destroy<KSP> { static constexpr auto call = KSPDestroy; };
template <> struct Destroy<SNES> { static constexpr auto call = SNESDestroy; };
template <> struct Destroy<TS> { static constexpr auto call = TSDestroy; };
template <> struct Destroy<DM> { static constexpr auto call = DMDestroy; };
template <> struct Destroy<IS> { static constexpr auto call = ISDestroy; };
template <> struct Destroy<PetscSF> { static constexpr auto call = PetscSFDestroy; };
template <> struct Destroy<PetscSection> { static constexpr auto call = PetscSectionDestroy; };
template <> struct Destroy<PetscViewer> { static constexpr auto call = PetscViewerDestroy; };
template <> struct Destroy<MatNullSpace> { static constexpr auto call = MatNullSpaceDestroy; };
} // namespace detail

/// Owns one PETSc object and destroys it; otherwise it is the bare object. Move only.
/// Destroying is collective, as the PETSc calls are: owners must go out of scope in the same order on all
/// ranks.
template <class Raw> class Handle {
public:
  Handle() = default;
  explicit Handle(Raw raw) : raw_(raw) {}
  Handle(Handle&& other) noexcept : raw_(std::exchange(other.raw_, nullptr)) {}
  Handle& operator=(Handle&& other) noexcept {
    if (this != &other) {
      reset();
      raw_ = std::exchange(other.raw_, nullptr);
    }
    return *this;
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() { reset(); }

  /// The bare object; never null (PETSc's optimised build would crash on a null without a message).
  Raw get() const {
    assert(raw_ != nullptr);
    return raw_;
  }
  operator Raw() const { return get(); }
  explicit operator bool() const { return raw_ != nullptr; }

  /// For PETSc's creation calls: `check(VecDuplicate(x, y.out()))`. Releases what was held before.
  Raw* out() {
    reset();
    return &raw_;
  }
  void reset() {
    if (raw_ != nullptr) detail::Destroy<Raw>::call(&raw_);
    raw_ = nullptr;
  }

private:
  Raw raw_ = nullptr;
};

} // namespace impact
