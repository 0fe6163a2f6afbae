#include <filesystem>
#include <impact/input/database.hpp>
#include <impact/input/option_text.hpp>
#include <impact/input/spelling.hpp>
#include <impact/io/durable_file.hpp>
#include <impact/petsc/error.hpp>
#include <impact/run/restart_options.hpp>

namespace impact {

namespace {

/// The line of the checksum of a file on rank 0; none for one that is not there.
std::string content_line(MPI_Comm comm, const std::string& key, const std::string& file) {
  std::string sum;
  on_rank_zero(comm, [&] {
    std::uintmax_t size = 0;
    std::error_code none;
    if (std::filesystem::exists(file, none)) sum = to_hex(file_checksum(file, size));
  });
  sum = broadcast(comm, sum);
  return sum.empty() ? "" : option_line(key, sum);
}

} // namespace

std::string restart_options(MPI_Comm comm, const Scenario& scenario) {
  std::string lines = print_scenario(scenario);
  for (const std::string& typed : option_names()) {
    const std::string name = lower_case(typed);
    const bool chooses_scheme = name.starts_with("ts_newmark_") || name.starts_with("damage_ts_");
    if (const auto text = chooses_scheme ? option_text(typed) : std::nullopt)
      lines += option_line(name, *text);
  }
  lines += content_line(comm, "mesh_content", scenario.mesh.file);
  for (const FunctionScenario& function : scenario.functions)
    lines += content_line(comm, "function_" + function.id + "_content", function.file);
  for (const MaterialScenario& material : scenario.materials)
    if (const std::string& table = material.hardening_table; !table.empty())
      lines += content_line(comm, "material_" + material.id + "_hardening_content", table);
  return lines;
}

} // namespace impact
