#pragma once
#include <optional>
#include <string>
#include <string_view>

/// Units of what the user types. Numbers live in the consistent system that `-units` names; only literals
/// with a unit ("72 GPa", "0.5 mm") are converted, once, when they are read. A scale is kept as a power of
/// ten as long as it is one, so that "2810 kg/m^3" becomes exactly the double nearest to 2.81e-9 t/mm^3.
namespace impact {

/// Exponents of mass, length, time and temperature.
struct Dimension {
  int mass = 0, length = 0, time = 0, temperature = 0;
  bool operator==(const Dimension&) const = default;
};

/// A unit: 10^decade * factor SI base units of `dimension`; factor is 1 unless the unit is not decimal (min,
/// h, deg).
struct Unit {
  Dimension dimension;
  int decade = 0;
  double factor = 1;
};

/// A consistent set of units: the powers of ten of its mass, length and time against kg, m and s; kelvin
/// always.
struct UnitSystem {
  std::string name = "SI";
  int mass = 0, length = 0, time = 0;

  /// Power of ten of this system's unit of `dimension` against the SI one.
  int decade(const Dimension& dimension) const;
  bool operator==(const UnitSystem&) const = default;
};

/// The systems of `-units`: SI, mm_t_s_MPa, mm_kg_ms_GPa; empty for any other name.
std::optional<UnitSystem> unit_system(std::string_view name);

/// Reads a unit such as "kg/m^3", "m^2/(N.s)", "N/mm", "%" or "1". Factors are joined by '.', '*' or a blank,
/// `/` divides by the next factor only (a product below the line needs brackets). Throws
/// std::invalid_argument with the reason ("unknown unit 'GPs'").
Unit parse_unit(std::string_view text);

/// Reads one decimal number that fills all of `text`, correctly rounded, times 10^decade. Empty when it is
/// not one, or when it does not fit a double. No inf, nan, hexadecimal or locale.
std::optional<double> parse_number(std::string_view text, int decade = 0);

/// A number and the unit behind it (empty: none); neither is checked beyond the shape of the number.
struct Literal {
  std::string_view number, unit;
};

/// Splits "72 GPa" into number and unit; empty when `text` does not begin with a number.
std::optional<Literal> split_literal(std::string_view text);

/// Reads "72 GPa" or "7.2e10" as a quantity of `dimension` in `system`; a bare number is in `system` already.
/// Throws std::invalid_argument with the reason and what is allowed.
double parse_quantity(std::string_view text, const Dimension& dimension, const UnitSystem& system);

/// As parse_quantity for any dimension (`-param_*`).
double parse_any_quantity(std::string_view text, const UnitSystem& system);

/// Symbol of the unit of `dimension` in `system`: "MPa", "t/mm^3", "1".
std::string unit_symbol(const Dimension& dimension, const UnitSystem& system);

/// Shortest text that reads back as the same double ("inf" and "nan" included).
std::string number_text(double value);

} // namespace impact
