#pragma once
#include <impact/problem/discretisation.hpp>
#include <petscvec.h>
#include <string>

namespace impact {

/// A warning about linear quadrilaterals and hexahedra that a displacement turned inside out at a corner,
/// where no point of theirs sees it: the mean volume of a cell (`-material_<id>_locking mean`) does not
/// resist modes that leave it as it is, once the cell flows. Empty where there are none. Collective.
std::string tell_of_inside_out(const Discretisation& discretisation, Vec u);

} // namespace impact
