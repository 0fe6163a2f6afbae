#pragma once
#include <impact/problem/discretisation.hpp>
#include <impact/scenario/scenario.hpp>
#include <string>
#include <vector>

/// The head of the log: the run before its first step.
namespace impact {

/// Mesh, groups, materials. Collective.
void report_setup(const Scenario& scenario, const Discretisation& discretisation);

/// A line for each solver, and the memory; `factors`: the motion is solved by factors, whose size is
/// estimated. Collective.
void report_solvers(const Discretisation& discretisation, const std::vector<std::string>& solvers,
                    bool factors);

} // namespace impact
