#pragma once
#include <petscdmplex.h>

namespace impact {

/// Makes the partitioner type `metis` known to PETSc (Debian's PETSc is built without METIS); done once, by
/// the first call. It takes vertex weights from the DM's local section and needs the whole graph on one rank,
/// which is where a file has been read; any other graph is refused with advice to take ptscotch. Equal input
/// gives equal parts.
void register_metis_partitioner();

} // namespace impact
