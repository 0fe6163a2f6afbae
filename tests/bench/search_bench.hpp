#pragma once

namespace impact {

/// Cost of the contact search between two surfaces of 1e4, 1e5 and 1e6 facets each, in the order of rows, one
/// line each: CPU nanoseconds per facet (smallest of the repetitions, all 2 n facets), and over that of 1e4.
void bench_search(int repetitions);

} // namespace impact
