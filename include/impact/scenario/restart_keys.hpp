#pragma once
#include <string>
#include <vector>

/// Which options may differ between the run that wrote a checkpoint and the run that goes on from it.
namespace impact {

enum class RestartKey {
  free,    ///< solvers, output, end time, time step: may change
  guarded, ///< what is computed: changes only with -restart_allow
  frozen   ///< mesh, dimension, units: cannot change
};

/// The kind of an option, by its name without dash, from its row. Names without a row are guarded.
RestartKey restart_key(const std::string& name);

/// Compares both lists. Returns one line per guarded change that `allow` covers: an entry is the name of an
/// option, or its beginning up to an underscore (bc_push for all of -bc_push_*). Throws UserError(usage) that
/// names key, old and new value for a frozen change, for a guarded one that is not allowed, and for an entry
/// of `allow` that fits no option. Values that are paths are compared by their file names.
std::vector<std::string> check_restart_options(const std::string& stored, const std::string& now,
                                               const std::vector<std::string>& allow,
                                               const std::string& checkpoint);

} // namespace impact
