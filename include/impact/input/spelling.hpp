#pragma once
#include <string>
#include <string_view>
#include <vector>

/// Suggestions for misspelled names.
namespace impact {

/// Lower-case copy (PETSc's option names do not tell case apart).
std::string lower_case(std::string_view text);

/// Number of single-letter changes, insertions, deletions and swaps of neighbours between two names, ignoring
/// case.
int edit_distance(std::string_view a, std::string_view b);

/// The candidate nearest to `name` within `limit` edits, among equals the one with the longest common
/// beginning; empty when there is none.
std::string nearest_name(std::string_view name, const std::vector<std::string>& candidates, int limit);

/// Names with `between` between them.
std::string join(const std::vector<std::string>& names, const std::string& between = ", ");

/// `text` with all `from` replaced.
std::string replaced(std::string text, const std::string& from, const std::string& to);

/// Parts between commas without blanks around them; none for a blank text.
std::vector<std::string> split_list(std::string_view text);

/// Without the blanks around it.
std::string_view trim(std::string_view text);

/// Where `word` stands by itself, with no letter, digit or underscore beside it, from `from` on; npos where
/// it does not.
std::size_t find_word(std::string_view text, std::string_view word, std::size_t from = 0);

} // namespace impact
