#include "scenario_options.hpp"
#include <gtest/gtest.h>
#include <sstream>

// What is said here of every option is tested on the list that the program itself prints.
namespace {

using namespace scenario_options;
using impact::ExitCode;

/// An option of the reference page, its ids replaced by those of base().
struct Documented {
  std::string key, allowed, unit;
};

std::vector<Documented> documented() {
  const std::pair<std::string, std::string> ids[] = {
      {"-param_", "v0"},     {"-function_", "load"}, {"-material_", "beam"}, {"-bc_", "push"},
      {"-ic_", "fly"},       {"-contact_", "tip"},   {"-output_", "vis"},    {"-probe_", "p1"},
      {"-measure_", "tail"}, {"-release_", "ring"},  {"-stop_", "end"}};
  std::vector<Documented> all;
  std::istringstream lines(impact::option_reference());
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("| `-")) continue;
    const auto parts = table_cells(line);
    std::string key = parts[0].substr(1, parts[0].size() - 2);
    for (const auto& [prefix, id] : ids)
      if (key.starts_with(prefix + "<id>")) key.replace(prefix.size(), 4, id);
    all.push_back({key, parts[2], parts[3]});
  }
  return all;
}

TEST(ScenarioKeys, TheReferenceListsTheOptions) { EXPECT_GT(documented().size(), 110U); }

TEST(ScenarioKeys, EveryKeyWithALetterTooMuchIsRefusedWithItsSpelling) {
  for (const Documented& option : documented()) {
    const Outcome result = outcome(with({{option.key + "x", "1"}}));
    EXPECT_EQ(result.code, ExitCode::usage) << option.key;
    EXPECT_TRUE(
        result.message.starts_with("unknown option " + option.key + "x; did you mean " + option.key + "?"))
        << result.message;
  }
}

TEST(ScenarioKeys, EveryKeyWithSwappedLettersIsRefusedWithItsSpelling) {
  for (const Documented& option : documented()) {
    std::string wrong = option.key;
    const std::size_t end = wrong.size();
    if (wrong[end - 1] == wrong[end - 2] || wrong[end - 2] == '_') continue;
    std::swap(wrong[end - 1], wrong[end - 2]);
    if (wrong == "-material_beam_cG") wrong = "-material_beam_Gcc";
    const Outcome result = outcome(with({{wrong, "1"}}));
    EXPECT_EQ(result.code, ExitCode::usage) << wrong;
    EXPECT_TRUE(result.message.starts_with("unknown option " + wrong + "; did you mean -")) << result.message;
  }
}

TEST(ScenarioKeys, EveryNumberRefusesAWrongDimensionAndJunk) {
  int numbers = 0;
  for (const Documented& option : documented()) {
    const bool text = option.allowed.find("name") != std::string::npos ||
                      option.allowed.find("id") != std::string::npos ||
                      option.allowed.find("path") != std::string::npos || option.allowed == "text" ||
                      option.allowed == "expression" || option.key == "-param_v0";
    const bool number = option.allowed.find_first_of("<>") != std::string::npos ||
                        option.allowed.starts_with("number") || option.allowed.starts_with("x,y") ||
                        !option.unit.empty();
    if (text || !number || option.allowed.starts_with("whole")) continue;
    ++numbers;
    const std::string quoted = option.key + " \"1 kg.K\": ";
    const Outcome wrong = outcome(with({{option.key, "1 kg.K"}}));
    EXPECT_EQ(wrong.code, ExitCode::usage) << option.key;
    EXPECT_TRUE(wrong.message.starts_with(quoted)) << wrong.message;
    EXPECT_NE(wrong.message.find("'kg.K' has the wrong dimension; allowed: "), std::string::npos)
        << wrong.message;
    for (const char* junk : {"abc", "1 foo", "", "1e999", "nan"}) {
      const Outcome refused = outcome(with({{option.key, junk}}));
      EXPECT_EQ(refused.code, ExitCode::usage) << option.key << " " << junk;
      EXPECT_TRUE(refused.message.starts_with(option.key + " \"" + junk + "\": ")) << refused.message;
    }
  }
  EXPECT_GT(numbers, 40);
}

TEST(ScenarioKeys, EveryBoundedNumberRefusesWhatIsOutside) {
  int bounded = 0;
  for (const Documented& option : documented()) {
    std::string outside;
    if (option.allowed.starts_with("whole number"))
      outside = "-1";
    else if (option.allowed.starts_with("> ") || option.allowed.starts_with(">= ") ||
             option.allowed.find("< value") != std::string::npos ||
             option.allowed.find("<= value") != std::string::npos)
      outside = "-7";
    else
      continue;
    ++bounded;
    const Outcome result = outcome(with({{option.key, outside}}));
    EXPECT_EQ(result.code, ExitCode::usage) << option.key;
    EXPECT_NE(result.message.find(option.key + " \"" + outside + "\": out of range; allowed: "),
              std::string::npos)
        << option.key << ": " << result.message;
  }
  EXPECT_GT(bounded, 45);
}

TEST(ScenarioKeys, EveryChoiceAndSwitchListsWhatIsAllowed) {
  int choices = 0;
  for (const Documented& option : documented()) {
    if (option.allowed.find(',') == std::string::npos ||
        option.allowed.find_first_of("<>") != std::string::npos ||
        option.allowed.find("whole") != std::string::npos ||
        option.allowed.find("x,y") != std::string::npos || option.allowed.starts_with("number") ||
        option.allowed.find("name") != std::string::npos || option.allowed.find("path") != std::string::npos)
      continue;
    ++choices;
    const Outcome result = outcome(with({{option.key, "nonsense"}}));
    EXPECT_EQ(result.code, ExitCode::usage) << option.key;
    std::string allowed = option.allowed;
    if (const std::string list = "comma list of "; allowed.starts_with(list))
      allowed = allowed.substr(list.size());
    EXPECT_NE(result.message.find("; allowed: " + allowed), std::string::npos) << result.message;
  }
  EXPECT_GT(choices, 20);
}

TEST(ScenarioKeys, EveryExpressionIsParsedAtOnce) {
  int expressions = 0;
  for (const Documented& option : documented()) {
    if (!option.allowed.ends_with("expression")) continue;
    ++expressions;
    for (const char* wrong : {"1+", "q*t", "x=1", ""}) {
      const Outcome result = outcome(with({{option.key, wrong}}));
      EXPECT_EQ(result.code, ExitCode::usage) << option.key;
      EXPECT_TRUE(result.message.starts_with(option.key + " \"" + wrong + "\": ")) << result.message;
    }
  }
  EXPECT_EQ(expressions, 30);
}

} // namespace
