#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <impact/mesh/gmsh.hpp>
#include <poll.h>
#include <spawn.h>
#include <sstream>
#include <string_view>
#include <strings.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

extern char** environ;

namespace impact {

namespace {

bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; }

bool has_word(const std::string& text, const std::string& word) {
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1))
    if ((at == 0 || !is_word(text[at - 1])) &&
        (at + word.size() == text.size() || !is_word(text[at + word.size()])))
      return true;
  return false;
}

std::string without_comments(const std::string& text) {
  std::string kept;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::size_t quote = text[i] == '"' ? text.find('"', i + 1) : std::string::npos;
    if (quote != std::string::npos) {
      kept += text.substr(i, quote - i + 1);
      i = quote;
    } else if (text.compare(i, 2, "//") == 0) {
      i = std::min(text.find('\n', i), text.size()) - 1;
    } else if (text.compare(i, 2, "/*") == 0) {
      i = std::min(text.find("*/", i), text.size() - 2) + 1;
    } else {
      kept += text[i];
    }
  }
  return kept;
}

enum class Constant { number, word };

// The names between the brackets of each DefineConstant, and what their values are.
std::map<std::string, Constant> declared_constants(const std::string& text) {
  std::map<std::string, Constant> found;
  constexpr std::string_view keyword = "DefineConstant";
  for (std::size_t at = text.find(keyword); at != std::string::npos; at = text.find(keyword, at + 1)) {
    int depth = 0;
    std::string name;
    bool in_name = true, in_text = false, seen_value = false;
    for (std::size_t i = at + keyword.size(); i < text.size(); ++i) {
      const char c = text[i];
      if (c == '"') in_text = !in_text;
      if (!in_name && !seen_value && c != '{' && !std::isspace(static_cast<unsigned char>(c))) {
        seen_value = true;
        if (c == '"') found[name] = Constant::word;
      }
      if (in_text || c == '"') continue;
      if (c == '[' || c == '(' || c == '{') ++depth;
      if (c == ']' || c == ')' || c == '}') --depth;
      if (in_name && is_word(c)) name += c;
      if (in_name && !name.empty() && !is_word(c)) found.emplace(name, Constant::number);
      if (c == '=') in_name = false;
      if (depth == 1 && c == ',') {
        name.clear();
        in_name = true;
        seen_value = false;
      }
      if (depth <= 0 && !std::isspace(static_cast<unsigned char>(c))) break;
    }
  }
  return found;
}

bool is_number(const std::string& value) {
  double number = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  return error == std::errc() && end == value.data() + value.size();
}

// gmsh ignores names that it does not know, those that are not asked for by DefineConstant or Exists, and a
// word where a number is declared: another mesh than the one that was meant, without a word.
void check_parameters(const std::string& geo, const std::map<std::string, std::string>& parameters) {
  std::ifstream in(geo);
  if (!in) throw UserError(ExitCode::io, geo + ": cannot be opened; is the path right?");
  std::ostringstream content;
  content << in.rdbuf();
  const std::string text = without_comments(content.str());
  const std::map<std::string, Constant> declared = declared_constants(text);
  std::string known;
  for (const auto& [name, kind] : declared) known += (known.empty() ? "" : ", ") + name;
  const bool whole = !has_word(text, "Include") && !has_word(text, "Merge") && !has_word(text, "Exists");
  for (const auto& [name, value] : parameters) {
    for (const auto& [other, kind] : declared)
      if (other != name && strcasecmp(other.c_str(), name.c_str()) == 0)
        throw UserError(ExitCode::usage, "-mesh_set_" + name + ": " + geo + " declares " + name + " and " +
                                             other +
                                             ", and options know no case: values of both would go to one; "
                                             "give one of them another name there");
    const auto found = declared.find(name);
    if (found == declared.end() && whole)
      throw UserError(
          ExitCode::usage,
          geo + ": has no parameter \"" + name + "\" (-mesh_set_" + name +
              "); allowed: " + (known.empty() ? "none, it has no DefineConstant" : known) +
              (has_word(text, "DefineNumber")
                   ? "; what DefineNumber sets stands in gmsh's window alone: write DefineConstant[" + name +
                         " = ..]"
                   : ""));
    if (found != declared.end() && is_number(value) != (found->second == Constant::number))
      throw UserError(ExitCode::usage,
                      "-mesh_set_" + name + " \"" + value + "\": " + geo + " declares " +
                          (is_number(value) ? "a word" : "a number") +
                          " of that name; allowed: " + (is_number(value) ? "a word" : "a number"));
  }
}

std::vector<std::string> command(const MeshRequest& request, const std::string& out) {
  std::vector<std::string> words{"gmsh", "-3", "-format",  "msh41", "-order", request.order == 2 ? "2" : "1",
                                 "-nt",  "1",  "-nopopup", "-v",    "2"};
  if (request.middles == Middles::edges)
    words.insert(words.end(), {"-setnumber", "Mesh.SecondOrderIncomplete", "1"});
  for (const auto& [name, value] : request.parameters) {
    words.insert(words.end(), {is_number(value) ? "-setnumber" : "-setstring", name, value});
  }
  words.insert(words.end(), {"-o", out, request.file});
  return words;
}

// The launcher's variables would make a gmsh that is linked with MPI join our job.
std::vector<char*> environment() {
  static constexpr std::string_view heads[] = {"OMPI_", "PMIX_", "PMI_"};
  std::vector<char*> kept;
  for (char** entry = environ; *entry; ++entry)
    if (std::none_of(std::begin(heads), std::end(heads),
                     [&](std::string_view head) { return std::string_view(*entry).starts_with(head); }))
      kept.push_back(*entry);
  kept.push_back(nullptr);
  return kept;
}

struct Ended {
  int status = 0;
  bool late = false;
  std::string said, stopped_by;
};

// A child that asks for all memory must fail by itself, not bring others down.
void limit_memory(pid_t child) {
  const auto bytes =
      static_cast<rlim_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<rlim_t>(sysconf(_SC_PAGESIZE));
  const rlimit limit{bytes, bytes};
  prlimit(child, RLIMIT_AS, &limit, nullptr);
}

// Five times a second the child is looked at: after the request's patience, or at its first reason to stop,
// it is killed.
Ended run(std::vector<std::string> words, const MeshRequest& request) {
  int channel[2];
  if (pipe2(channel, O_CLOEXEC) != 0) throw UserError(ExitCode::io, "gmsh: no pipe to it");
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, channel[1], 1);
  posix_spawn_file_actions_adddup2(&actions, channel[1], 2);
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  std::vector<char*> variables = environment();
  pid_t child = 0;
  const int failed = posix_spawnp(&child, "gmsh", &actions, nullptr, arguments.data(), variables.data());
  posix_spawn_file_actions_destroy(&actions);
  close(channel[1]);
  if (failed != 0) {
    close(channel[0]);
    throw UserError(ExitCode::io, std::string("gmsh: cannot be started (") + std::strerror(failed) +
                                      "); install gmsh or give a .msh file");
  }
  limit_memory(child);
  Ended end;
  char piece[4096];
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = Clock::now();
  for (bool open = true; open && !end.late && end.stopped_by.empty();) {
    pollfd at{channel[0], POLLIN, 0};
    if (poll(&at, 1, 200) > 0) {
      const ssize_t n = read(channel[0], piece, sizeof piece);
      if (n > 0) end.said.append(piece, static_cast<std::size_t>(n));
      open = n > 0 || (n < 0 && errno == EINTR);
    }
    if (request.reason_to_stop) end.stopped_by = request.reason_to_stop();
    end.late = open && request.patience > 0 &&
               Clock::now() - start > std::chrono::duration<double>(request.patience);
  }
  if (end.late || !end.stopped_by.empty()) kill(child, SIGKILL);
  close(channel[0]);
  while (waitpid(child, &end.status, 0) < 0 && errno == EINTR) {
  }
  return end;
}

std::string first_error(const std::string& said) {
  std::istringstream lines(said);
  for (std::string line; std::getline(lines, line);)
    if (line.find("Error") != std::string::npos) return line;
  return "";
}

std::string last_words(const std::string& said) {
  const std::size_t end = said.find_last_not_of("\n ");
  if (end == std::string::npos) return "";
  const std::size_t start = said.rfind('\n', end);
  return ", after \"" + said.substr(start + 1, end - start) + '"'; // from 0 where there is one line
}

} // namespace

std::string run_gmsh(const MeshRequest& request) {
  namespace fs = std::filesystem;
  const std::string& geo = request.file;
  check_parameters(geo, request.parameters);
  std::error_code ignored;
  fs::create_directories(request.work_dir, ignored);
  const std::string out = (fs::path(request.work_dir) / fs::path(geo).stem()).string() + ".msh";
  fs::remove(out, ignored); // a stale file must not pass for the new mesh
  // -3 also serves plane geometries, whose surfaces it meshes on the way.
  const Ended end = run(command(request, out), request);
  if (!end.stopped_by.empty())
    throw UserError(ExitCode::io, geo + ": gmsh was ended by " + end.stopped_by +
                                      "; nothing is computed yet, and there is nothing to go on from");
  const std::string error = first_error(end.said);
  if (end.late)
    throw UserError(ExitCode::data, geo + ": gmsh has worked for " +
                                        std::to_string(static_cast<long>(request.patience)) +
                                        " s and is stopped; a loop without end, or too many cells; or allow "
                                        "more by -mesh_wall");
  if (end.said.find("bad_alloc") != std::string::npos)
    throw UserError(ExitCode::data, geo + ": gmsh wants more memory than there is; ask for fewer cells");
  if (!error.empty()) throw UserError(ExitCode::io, geo + ": gmsh says: " + error);
  if (WIFSIGNALED(end.status))
    throw UserError(ExitCode::io, geo + ": gmsh itself failed (" + strsignal(WTERMSIG(end.status)) + ")" +
                                      last_words(end.said) +
                                      "; another Mesh.Algorithm or another size of cells may get through");
  if (WEXITSTATUS(end.status) != 0 || !fs::exists(out))
    throw UserError(ExitCode::io, geo + ": gmsh wrote no mesh to " + out + "; is the folder writable?");
  return out;
}

} // namespace impact
