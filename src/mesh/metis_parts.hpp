#pragma once

#include <metis.h>
#include <vector>

namespace impact {

/// Part in [0, parts) of each vertex of a graph in compressed rows (start: vertices + 1 places in neighbour),
/// by METIS's k-way method with edges all alike. weight: one per vertex, or null. Equal input gives equal
/// parts; of fewer vertices than parts each is one. Returns METIS_OK or METIS's error.
int metis_parts(idx_t parts, std::vector<idx_t>& start, std::vector<idx_t>& neighbour, idx_t* weight,
                std::vector<idx_t>& part);

/// The same where parts have equal shares of each of several kinds of weights, [vertex][kind], and not of
/// their sum alone.
int metis_parts(idx_t parts, std::vector<idx_t>& start, std::vector<idx_t>& neighbour,
                std::vector<idx_t>& weight, int kinds, std::vector<idx_t>& part);

/// The largest share of a part over the mean that counts as even: a tenth above it, or what whole units make
/// of it where a part has few of them. `total`: of all parts.
double even_share(double total, double unit, double parts);

} // namespace impact
