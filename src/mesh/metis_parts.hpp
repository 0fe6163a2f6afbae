#pragma once

#include <metis.h>
#include <vector>

namespace impact {

/// Part in [0, parts) of each vertex of a graph in compressed rows (start: vertices + 1 places in neighbour),
/// by METIS's k-way method with edges all alike. weight: one per vertex, or null. Equal input gives equal
/// parts; of fewer vertices than parts each is one. Returns METIS_OK or METIS's error.
int metis_parts(idx_t parts, std::vector<idx_t>& start, std::vector<idx_t>& neighbour, idx_t* weight,
                std::vector<idx_t>& part);

} // namespace impact
