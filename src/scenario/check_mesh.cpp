#include "classes.hpp"
#include <algorithm>
#include <impact/petsc/error.hpp>
#include <impact/problem/boundary_data.hpp>

/// What the rows of the option tables demand of the mesh: that groups are there and of the right dimension.
namespace impact {

namespace {

/// `dim`: that the group must have, 0 for any.
void check_group(const std::string& option, const std::string& name, int dim,
                 const std::vector<Group>& groups) {
  const auto found = std::ranges::find_if(groups, [&](const Group& g) { return g.name == name; });
  const std::string has = "; mesh has: " + groups_text(groups);
  if (found == groups.end())
    throw UserError(ExitCode::data, option + " \"" + name + "\": no such physical group" + has +
                                        (option.ends_with("_primary")
                                             ? "; rigid bodies are plane, rigid_sphere and rigid_cylinder"
                                             : ""));
  if (dim != 0 && found->dim != dim)
    throw UserError(ExitCode::data, option + " \"" + name + "\": is a group of dimension " +
                                        std::to_string(found->dim) + "; allowed: dimension " +
                                        std::to_string(dim) + has);
}

template <class Struct>
void check_on_mesh(const std::vector<OptionRow<Struct>>& rows, const Struct& target,
                   const std::string& prefix, const std::vector<Group>& groups, int dim) {
  for (const OptionRow<Struct>& row : rows) {
    const std::string option = "-" + prefix + row.name, text = row.text(target);
    if (row.group_dimension && !text.empty())
      if (const int wanted = row.group_dimension(target, dim); wanted >= 0)
        for (const std::string& name : split_list(text)) check_group(option, name, wanted, groups);
    if (row.misfit && row.given(target))
      if (const std::string why = row.misfit(target, dim); !why.empty())
        throw UserError(ExitCode::data, option + " \"" + text + "\": " + why);
  }
}

} // namespace

void check_groups(const Scenario& scenario, const std::vector<Group>& groups, int dim) {
  check_on_mesh(global_rows(), scenario, "", groups, dim);
  for_each_class([&](const auto& table) {
    for (const auto& one : scenario.*table.member)
      check_on_mesh(table.rows, one, table.word + "_" + one.id + "_", groups, dim);
  });
  check_obstacle_motion(scenario, dim);
}

} // namespace impact
