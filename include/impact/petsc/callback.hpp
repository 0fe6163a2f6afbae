#pragma once
#include <impact/petsc/error.hpp>

/// A member function as PETSc calls it back: Callback<&Class::method>::call takes the method's arguments and
/// then the object as its context. The class offers `Mailbox& mailbox()`, where exceptions wait until the
/// solve has returned.
namespace impact {

template <auto method> struct Callback;

template <class Object, class... Arguments, void (Object::*method)(Arguments...)> struct Callback<method> {
  static PetscErrorCode call(Arguments... arguments, void* context) {
    auto& self = *static_cast<Object*>(context);
    return self.mailbox().guarded([&] { (self.*method)(arguments...); });
  }
};

} // namespace impact
