#pragma once
#include <impact/contact/settings.hpp>
#include <impact/contact/surface.hpp>
#include <string>
#include <vector>

/// What the user left to the program: automatic values become numbers, wrong ones are refused.
namespace impact {

struct ResolvedSettings {
  ContactSettings settings;
  double mean_length = 0;     ///< of the secondary facets
  double inertia_penalty = 0; ///< least automatic penalty beside multipliers, over the mass shift
  std::vector<std::string> warnings;
};
/// `primary`: empty for a rigid body. Throws UserError(usage), the same on all ranks. Collective.
ResolvedSettings resolve_settings(const Mesh& mesh, const ContactSettings& settings,
                                  const ContactEnvironment& environment, const ContactSurface& secondary,
                                  const ContactSurface& primary);
/// A number in a message.
std::string contact_number(double value);

} // namespace impact
