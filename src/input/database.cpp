#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <impact/input/database.hpp>
#include <impact/input/spelling.hpp>
#include <impact/petsc/error.hpp>
#include <map>
#include <sstream>

namespace impact {

namespace {

/// The words of the command line behind the program's name.
std::vector<std::string> arguments() {
  int count = 0;
  char** words = nullptr;
  check(PetscGetArgs(&count, &words));
  return {words + std::min(count, 1), words + count};
}

bool names_file(const std::string& word) {
  return lower_case(word) == "-options_file" || lower_case(word) == "-options_file_yaml";
}

bool is_yaml(const std::string& file) { return file.ends_with(".yml") || file.ends_with(".yaml"); }

/// An option as it stands in a file: its name in lower case, its value without blanks and quotes, the line.
struct FileOption {
  std::string name, text;
  int line;
};

/// The options of the text of a file; of a YAML file a key goes behind those that its line is indented below.
std::vector<FileOption> options_in(const std::string& text, bool yaml) {
  std::vector<FileOption> options;
  std::vector<std::pair<std::size_t, std::string>> above; // indentation, name
  std::istringstream lines(text);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    const std::size_t begin = line.find_first_not_of(yaml ? " " : " \t"),
                      end = line.find_first_of(yaml ? ":" : " \t\r", begin);
    if (begin == std::string::npos || line[begin] == '#' ||
        (yaml ? end == std::string::npos : line[begin] != '-'))
      continue;
    while (!above.empty() && above.back().first >= begin) above.pop_back();
    std::string name = lower_case(
        line.substr(begin + (yaml ? 0 : 1), end == std::string::npos ? end : end - begin - (yaml ? 0 : 1)));
    if (name.empty() || std::isalpha(static_cast<unsigned char>(name[0])) == 0) continue;
    if (yaml && !above.empty()) name.insert(0, above.back().second + "_");
    std::istringstream words(end == std::string::npos ? "" : line.substr(end + 1));
    std::string value;
    for (std::string part; words >> part && part[0] != '#';) value += part;
    std::erase(value, '"');
    if (yaml) above.emplace_back(begin, name);
    if (!yaml || !value.empty()) options.push_back({name, value, number});
  }
  return options;
}

/// Calls visit(file, option) for all options in a file and in those that it names. `above`: the files from
/// the command line down to this one.
template <class Visit>
void follow_option_file(const std::string& file, bool yaml, std::vector<std::string> above,
                        const Visit& visit) {
  const auto refuse = [&](const std::string& reason) { refuse_option({"-options_file", file}, reason); };
  const bool again = std::ranges::find(above, file) != above.end();
  above.push_back(file);
  if (again) refuse("leads back to itself: " + join(above) + "; remove the line that names it again");
  std::ifstream stream(file);
  std::ostringstream text;
  text << stream.rdbuf();
  if (text.str().starts_with(byte_order_mark))
    refuse("begins with a byte-order mark; save it as plain UTF-8");
  for (const FileOption& option : options_in(text.str(), yaml || is_yaml(file))) {
    visit(file, option);
    if (option.name == "options_file" || option.name == "options_file_yaml")
      follow_option_file(option.text, option.name == "options_file_yaml", above, visit);
  }
}

/// Of a command line and of PETSC_OPTIONS.
template <class Visit> void follow_option_files(std::vector<std::string> words, const Visit& visit) {
  if (const char* more = std::getenv("PETSC_OPTIONS")) {
    std::istringstream text(more);
    for (std::string word; text >> word;) words.push_back(word);
  }
  for (std::size_t i = 0; i + 1 < words.size(); ++i)
    if (names_file(words[i]))
      follow_option_file(words[i + 1], lower_case(words[i]) == "-options_file_yaml", {}, visit);
}

} // namespace

void refuse_option(const GivenOption& option, const std::string& reason) {
  throw UserError(ExitCode::usage, option.key + " \"" + option.text + "\": " + reason);
}

void check_option_files(int argc, const char* const* argv) {
  std::map<std::pair<std::string, std::string>, int> lines;
  const std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
  const auto is_option = [](const std::string& word) {
    return word.size() > 1 && word[0] == '-' && word[1] != '.' &&
           !std::isdigit(static_cast<unsigned char>(word[1]));
  };
  for (std::size_t i = 0; i < words.size(); ++i)
    if (!is_option(words[i]) && (i == 0 || !is_option(words[i - 1])))
      throw UserError(ExitCode::usage,
                      "`" + words[i] +
                          "` on the command line belongs to no option; allowed: an option and its value, "
                          "in quotes where that has blanks; a file of options stands behind -options_file");
  follow_option_files(words, [&](const std::string& file, const FileOption& option) {
    const auto [at, fresh] = lines.emplace(std::pair(file, option.name), option.line);
    if (!fresh && at->second != option.line)
      throw UserError(ExitCode::usage, "-" + option.name + ": given twice in " + file + ", lines " +
                                           std::to_string(at->second) + " and " +
                                           std::to_string(option.line) + "; remove one of them");
  });
}

std::string explain_unread_files(int argc, const char* const* argv, const std::string& petsc_message) {
  if (petsc_message.find("max number of options") != std::string::npos)
    return "PETSc keeps no more than 512 options, and there are more here; say once what is the same "
           "(-material_<id>_like, comma lists of groups in -bc_<id>_on), leave out what has its default";
  if (petsc_message.find("two options per line") != std::string::npos)
    return "the options cannot be read: " + petsc_message +
           "; a value that begins with a minus needs brackets: (-t)";
  for (int i = 1; i + 1 < argc; ++i) {
    std::ifstream lines(argv[i + 1]);
    std::string line;
    for (int number = 1; is_yaml(argv[i + 1]) && std::getline(lines, line); ++number) {
      const std::size_t first = line.find_first_not_of(' ');
      if (first == std::string::npos || line[first] == '#' || line.starts_with("---")) continue;
      const auto count = [&](char c) { return std::ranges::count(line, c); };
      const char* why = line[first] == '\t' ? "a tab in front; indent with blanks"
                        : line.find(':') == std::string::npos && line[first] != '-' ? "no \"name: value\""
                        : count('[') != count(']') || count('{') != count('}')      ? "a bracket is missing"
                        : count('"') % 2 == 1                                       ? "a quote is missing"
                                                                                    : nullptr;
      if (why != nullptr)
        return std::string(argv[i + 1]) + ", line " + std::to_string(number) + ": " + why + ": " + line;
    }
  }
  return "the options cannot be read: " + petsc_message + "; check -options_file";
}

bool on_command_line(const std::string& name) {
  const std::vector<std::string> words = arguments();
  return std::ranges::any_of(
      words, [&](const std::string& word) { return lower_case(word) == "-" + lower_case(name); });
}

std::vector<std::string> texts_in_files(const std::string& name) {
  std::vector<std::string> texts;
  follow_option_files(arguments(), [&](const std::string&, const FileOption& option) {
    if (option.name == lower_case(name)) texts.push_back(option.text);
  });
  return texts;
}

std::vector<std::string> option_names() {
  std::vector<std::string> names;
  char* all = nullptr;
  check(PetscOptionsGetAll(nullptr, &all));
  std::istringstream words(all != nullptr ? all : "");
  check(PetscFree(all));
  for (std::string word; words >> word;)
    if (word.size() > 1 && word[0] == '-' && std::isalpha(static_cast<unsigned char>(word[1])))
      names.push_back(word.substr(1));
  return names;
}

std::optional<std::string> option_text(const std::string& name) {
  const char* text = nullptr;
  PetscBool given = PETSC_FALSE;
  check(PetscOptionsFindPair(nullptr, nullptr, ("-" + name).c_str(), &text, &given));
  if (!given) return {};
  return std::string(trim(text != nullptr ? text : ""));
}

void replace_option(const std::string& name, const std::string& text) {
  check(PetscOptionsSetValue(nullptr, ("-" + name).c_str(), text.c_str()));
}

std::vector<std::string> option_folders() {
  std::vector<std::string> folders;
  follow_option_files(arguments(), [&](const std::string& file, const FileOption&) {
    const std::string folder = std::filesystem::path(file).parent_path().string();
    if (std::ranges::find(folders, folder) == folders.end()) folders.push_back(folder);
  });
  folders.emplace_back();
  return folders;
}

std::string find_input_file(MPI_Comm comm, const GivenOption& option) {
  std::string found;
  on_rank_zero(comm, [&] {
    if (option.text.empty()) refuse_option(option, "missing; allowed: the path of a file");
    std::vector<std::string> looked;
    for (const std::string& folder : option_folders()) {
      const auto path = (std::filesystem::path(folder) / option.text).lexically_normal();
      std::error_code none;
      if (std::filesystem::is_regular_file(path, none)) {
        found = path.string();
        return;
      }
      const std::string text = path.string();
      if (std::ranges::find(looked, text) == looked.end()) looked.push_back(text);
    }
    throw UserError(ExitCode::io,
                    option.key + " \"" + option.text + "\": no such file; looked for " + join(looked));
  });
  return broadcast(comm, found);
}

std::string read_input_file(MPI_Comm comm, const GivenOption& option, const std::string& path) {
  std::string text;
  on_rank_zero(comm, [&] {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream content;
    content << file.rdbuf();
    if (!file) throw UserError(ExitCode::io, option.key + " \"" + path + "\": cannot be read");
    text = content.str();
    if (text.starts_with(byte_order_mark)) text.erase(0, std::strlen(byte_order_mark));
  });
  return broadcast(comm, text);
}

bool read_at_the_ends(const std::string& name) {
  for (const char* exact :
       {"help", "version", "info", "citations", "saws_options", "options_file", "skip_petscrc"})
    if (name == exact) return true;
  for (const char* prefix :
       {"log_", "options_", "malloc", "memory_", "on_error", "mpi_", "petsc_", "ts_view"})
    if (name.starts_with(prefix)) return true;
  return false;
}

std::vector<GivenOption> unread_options() {
  PetscInt count = 0;
  char **names = nullptr, **values = nullptr;
  check(PetscOptionsLeftGet(nullptr, &count, &names, &values));
  std::vector<GivenOption> left;
  for (PetscInt i = 0; i < count; ++i)
    if (!read_at_the_ends(lower_case(names[i])))
      left.push_back({std::string("-") + names[i], values[i] ? values[i] : ""});
  check(PetscOptionsLeftRestore(nullptr, &count, &names, &values));
  return left;
}

} // namespace impact
