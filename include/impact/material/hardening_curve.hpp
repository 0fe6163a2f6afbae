#pragma once

namespace impact {

/// A flow stress and its slope along alpha. Where T carries derivatives, those of dk are not kept.
template <class T> struct Hardening { T k, dk; };

} // namespace impact
