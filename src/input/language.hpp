#pragma once
#include <impact/input/database.hpp>
#include <muParser.h>
#include <utility>

/// The language that expressions and conditions share.
namespace impact {

/// Constants and functions without the user's names. muParser's `_pi` and `_e` go, ours have no underscore.
void define_language(mu::Parser& parser);

/// Makes the parser read `part`, all or a part of an option's text, which may use `parameters` and what the
/// parser knows already; `known` lists the names for messages. Throws UserError(usage) with the place of what
/// is wrong.
void parse(mu::Parser& parser, const GivenOption& option, const std::string& part,
           const std::vector<std::pair<std::string, double>>& parameters, const std::string& known);

/// Throws UserError(usage) when the text assigns with a single `=`.
void refuse_assignment(const GivenOption& option);

} // namespace impact
