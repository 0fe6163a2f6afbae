#pragma once

namespace impact {

/// PC type: Jacobi and the rigid modes of aggregates of nodes, added up,
///   M^-1 = D^-1 + P (P^T A P)^-1 P^T,
/// where column k of P is a near null vector of A on one aggregate and zero elsewhere (R. Nicolaides, SIAM J.
/// Numer. Anal. 24 (1987) 355; rigid modes: T. Jonsthovel, M. van Gijzen, C. Vuik, A. Scarpas, Comput.
/// Geotech. 36 (2009)). As symmetric as A, which may store its upper blocks alone, and almost without memory.
/// Iterations grow with the nodes along an aggregate, not along the body. `-pc_two_level_nodes`: nodes of an
/// aggregate; the solver of the coarse problem has the prefix `coarse_` (direct, by MUMPS).
inline constexpr const char* two_level_type = "two_level";

/// Makes the type known to PETSc; may be called again.
void register_two_level();

} // namespace impact
