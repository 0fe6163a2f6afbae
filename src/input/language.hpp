#pragma once
#include <muParser.h>
#include <string>
#include <utility>
#include <vector>

/// The language that expressions and conditions share.
namespace impact {

/// Constants and functions without the user's names. muParser's `_pi` and `_e` go, ours have no underscore.
void define_language(mu::Parser& parser);

/// Throws UserError(usage) when the text assigns with a single `=`.
void refuse_assignment(const std::string& key, const std::string& text);

/// `-key "text": reason`, as UserError(usage).
[[noreturn]] void refuse_expression(const std::string& key, const std::string& text,
                                    const std::string& reason);

/// What muParser found wrong, with its place and the known names.
std::string reason_of(const mu::Parser::exception_type& error, const std::string& known_names);

} // namespace impact
