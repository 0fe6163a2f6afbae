#pragma once
#include <impact/run/stage.hpp>

namespace impact {

/// Tells what may be the matter where no step of a static run, however short, found an equilibrium for the
/// `cause` that refused the last one; u: the displacement of the last accepted step. Collective.
void tell_of_limits(RunStage& stage, const std::string& cause, Vec u);

} // namespace impact
