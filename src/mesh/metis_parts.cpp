#include "metis_parts.hpp"

#include <numeric>

namespace impact {

int metis_parts(idx_t parts, std::vector<idx_t>& start, std::vector<idx_t>& neighbour, idx_t* weight,
                std::vector<idx_t>& part) {
  idx_t vertices = static_cast<idx_t>(start.size()) - 1, constraints = 1, cut = 0;
  part.assign(start.size() - 1, 0);
  if (parts <= 1) return METIS_OK;
  if (vertices <= parts) { // METIS itself is not made for as many parts as vertices
    std::iota(part.begin(), part.end(), idx_t{0});
    return METIS_OK;
  }
  idx_t options[METIS_NOPTIONS];
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_NUMBERING] = 0;
  options[METIS_OPTION_SEED] = 1;
  return METIS_PartGraphKway(&vertices, &constraints, start.data(), neighbour.data(), weight, nullptr,
                             nullptr, &parts, nullptr, nullptr, options, &cut, part.data());
}

} // namespace impact
