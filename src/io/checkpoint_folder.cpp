#include "checkpoint_folder.hpp"
#include <algorithm>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <impact/input/spelling.hpp>
#include <impact/input/units.hpp>
#include <impact/io/durable_file.hpp>
#include <iomanip>
#include <set>
#include <sstream>

// Which files of a directory count as checkpoints: numbers, manifests, checksums.
namespace impact {

namespace {

namespace fs = std::filesystem;
constexpr const char* format = "impact checkpoint 5";

fs::path manifest_of(const fs::path& file) { return fs::path(file).replace_extension(".manifest"); }

std::string name_of(long number) {
  char name[48];
  std::snprintf(name, sizeof name, "checkpoint_%06ld.h5", number);
  return name;
}

// -1 for names that are not ours.
long number_of(const std::string& name) {
  const std::string head = "checkpoint_";
  long number = -1;
  if (!name.starts_with(head)) return -1;
  std::from_chars(name.data() + head.size(), name.data() + name.size(), number);
  return number;
}

// Checkpoint files that have a manifest, newest first.
std::vector<std::string> with_manifest(const std::string& dir) {
  std::vector<long> numbers;
  for (const std::string& name : names_in(dir))
    if (number_of(name) >= 0 && name.ends_with(".manifest")) numbers.push_back(number_of(name));
  std::sort(numbers.rbegin(), numbers.rend());
  std::vector<std::string> files;
  for (const long n : numbers) files.push_back((fs::path(dir) / name_of(n)).string());
  return files;
}

/// A manifest holds, by key, name and sum of its file and all that the run wants to find again.
using Entries = std::map<std::string, std::string>;

std::string manifest_text(const Checkpoint& c, const hdf5::Written& written) {
  Entries entries{{"file", fs::path(c.file).filename().string()}, {"size", std::to_string(written.bytes)},
                  {"checksum", to_hex(written.checksum)},         {"step", std::to_string(c.values.step)},
                  {"time", number_text(c.values.time)},           {"rows", c.rows}};
  for (const auto& [name, value] : c.values.texts) entries["text:" + name] = value;
  std::ostringstream text;
  text << format << '\n';
  for (const auto& [key, value] : entries) text << std::quoted(key) << ' ' << std::quoted(value) << '\n';
  return text.str() + "manifest " + to_hex(checksum(text.str())) + "\n";
}

Entries entries_of(const std::string& manifest) {
  Entries entries;
  std::istringstream in(manifest.substr(manifest.find('\n') + 1));
  for (std::string key, value; in >> std::quoted(key) >> std::quoted(value);) entries[key] = value;
  return entries;
}

/// Why a file cannot be trusted, empty when size, checksum and manifest agree; `manifest` becomes its text.
std::string fault_of(const std::string& file, std::string& manifest) {
  try {
    if (!fs::exists(file)) return "there is no such file";
    if (!fs::exists(manifest_of(file)))
      return "it has no manifest beside it (" + manifest_of(file).filename().string() +
             "), so it was not finished, or copied without";
    manifest = read_file(manifest_of(file).string());
    const std::size_t own = manifest.rfind("manifest ");
    if (manifest.starts_with("impact checkpoint ") && !manifest.starts_with(std::string(format) + "\n"))
      return "it was written by another version of impact (" + manifest.substr(7, manifest.find('\n') - 7) +
             ", this one reads " + (format + 7) + ")";
    if (own == std::string::npos ||
        manifest.substr(own) != "manifest " + to_hex(checksum(manifest.substr(0, own))) + "\n")
      return "its manifest is damaged";
    Entries said = entries_of(manifest);
    if (said["file"] != fs::path(file).filename().string()) return "its manifest belongs to another file";
    std::uint64_t size = 0;
    const std::uint64_t sum = file_checksum(file, size);
    if (said["size"] != std::to_string(size))
      return "it has " + std::to_string(size) + " bytes instead of " + said["size"];
    if (said["checksum"] != to_hex(sum)) return "its content does not have the checksum of the manifest";
    return {};
  } catch (const std::exception& error) {
    return error.what();
  }
}

/// The checkpoint of that name and manifest of rank 0 on all ranks. Collective.
Checkpoint shared(MPI_Comm comm, const std::string& file, const std::string& manifest) {
  Checkpoint checkpoint{broadcast(comm, file), {}, {}, {}};
  CheckpointValues& values = checkpoint.values;
  for (const auto& [key, value] : entries_of(broadcast(comm, manifest))) {
    if (key == "step") values.step = std::stol(value);
    if (key == "time") values.time = parse_number(value).value_or(0);
    if (key == "rows") checkpoint.rows = value;
    if (key.starts_with("text:")) values.texts[key.substr(5)] = value;
  }
  return checkpoint;
}

} // namespace

std::string in_one_line(const std::string& lines) {
  return replaced(lines.substr(0, lines.find_last_not_of('\n') + 1), "\n", "; ");
}

std::string next_checkpoint_file(const std::string& dir) {
  long last = 0;
  for (const std::string& name : names_in(dir)) last = std::max(last, number_of(name));
  return (fs::path(dir) / name_of(last + 1)).string();
}

void publish_checkpoint(const Checkpoint& checkpoint, const hdf5::Written& written) {
  replace_file(manifest_of(checkpoint.file).string(), manifest_text(checkpoint, written));
}

void remove_old_checkpoints(const CheckpointFolder& folder) {
  std::vector<std::string> files = with_manifest(folder.dir);
  std::set<std::string> stays;
  files.resize(std::min(files.size(), static_cast<std::size_t>(std::max(1, folder.keep))));
  for (const std::string& file : files)
    stays.insert({fs::path(file).filename().string(), manifest_of(file).filename().string()});
  // The manifest goes first: without it the rest does not count, whatever happens in between.
  std::error_code ignored;
  for (const bool manifests : {true, false})
    for (const std::string& name : names_in(folder.dir))
      if (number_of(name) >= 0 && !stays.contains(name) && name.ends_with(".manifest") == manifests)
        fs::remove(fs::path(folder.dir) / name, ignored);
}

std::optional<Checkpoint> newest_checkpoint(MPI_Comm comm, const std::string& dir) {
  std::string found, manifest, damaged;
  on_rank_zero(comm, [&] {
    for (const std::string& file : with_manifest(dir)) {
      const std::string fault = fault_of(file, manifest);
      if (fault.empty()) {
        found = file;
        return;
      }
      damaged += "checkpoint " + file + " is not used: " + fault + "\n";
    }
    if (damaged.empty()) return;
    throw UserError(ExitCode::io, "no usable checkpoint in " + dir + ": " + in_one_line(damaged) +
                                      "; restore one of them, or remove them to start anew");
  });
  Checkpoint checkpoint = shared(comm, found, manifest);
  std::istringstream lines(broadcast(comm, damaged));
  for (std::string line; std::getline(lines, line);) checkpoint.warnings.push_back(line);
  return checkpoint.file.empty() ? std::nullopt : std::optional(checkpoint);
}

Checkpoint open_checkpoint(MPI_Comm comm, const std::string& file) {
  std::string manifest;
  on_rank_zero(comm, [&] {
    if (const std::string fault = fault_of(file, manifest); !fault.empty())
      throw UserError(ExitCode::io,
                      "cannot use checkpoint " + file + ": " + fault +
                          "; name another one, or use -restart auto for the newest undamaged one");
  });
  return shared(comm, file, manifest);
}

int retire_checkpoints(MPI_Comm comm, const std::string& dir, const std::string& resumed) {
  int count = 0;
  on_rank_zero(comm, [&] {
    std::error_code error;
    const bool here = !resumed.empty() && fs::equivalent(fs::path(resumed).parent_path() / ".", dir, error);
    const long last = here ? number_of(fs::path(resumed).filename().string()) : -1;
    for (const std::string& file : with_manifest(dir)) {
      if (number_of(fs::path(file).filename().string()) <= last) continue;
      rename_durably(manifest_of(file).string(), manifest_of(file).string() + ".old");
      ++count;
    }
  });
  MPI_Bcast(&count, 1, MPI_INT, 0, comm);
  return count;
}

} // namespace impact
