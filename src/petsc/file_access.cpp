#include <cstdlib>
#include <impact/petsc/file_access.hpp>

namespace impact {

void choose_file_access() { setenv("OMPI_MCA_io", "^ompio", 0); }

} // namespace impact
