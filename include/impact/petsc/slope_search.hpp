#pragma once

namespace impact {

/// SNESLineSearch type: along Newton's step d = -K^-1 f to where the slope f.d of the energy has fallen to
/// half of that at the start (H. Matthies, G. Strang, Int. J. Numer. Methods Eng. 14 (1979) 1613), or the
/// residual norm to half of the smallest of the solve. Where neither is near and the energy rises along d,
/// because the tangent is indefinite, it goes the other way. The norm alone has minima where no residual is
/// zero: stiff cells beside broken ones, of which some open and some close. A step below the shortest one of
/// SNESLineSearchSetTolerances ends the search, and is taken.
inline constexpr const char* slope_search_type = "slope";

/// Makes the type known to PETSc; may be called again.
void register_slope_search();

} // namespace impact
