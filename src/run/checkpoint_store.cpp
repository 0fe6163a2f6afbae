#include <algorithm>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <impact/run/checkpoint_file.hpp>
#include <impact/run/durable_file.hpp>
#include <impact/run/hdf5_file.hpp>
#include <set>
#include <sstream>
#include <thread>

// Which files of a directory count as checkpoints: numbers, manifests, checksums. Everything here runs on
// rank 0.
namespace impact {

namespace {

namespace fs = std::filesystem;
constexpr const char* first_line = "impact checkpoint 3";

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
  if (name.compare(0, head.size(), head) != 0) return -1;
  std::from_chars(name.data() + head.size(), name.data() + name.size(), number);
  return number;
}

/// Files that are being removed: freeing the blocks of a large one takes as long as a third of writing it,
/// and nobody waits for that.
std::jthread removal;

std::vector<std::string> names_in(const std::string& dir) {
  if (removal.joinable()) removal.join();
  std::vector<std::string> names;
  std::error_code error;
  fs::directory_iterator entries(dir, error);
  if (error == std::errc::no_such_file_or_directory) return names;
  if (error) throw UserError(ExitCode::io, "cannot read directory " + dir + ": " + error.message());
  for (const auto& entry : entries) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
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

std::string manifest_text(const std::string& file, const CheckpointValues& values) {
  std::uintmax_t size = 0;
  const std::uint64_t sum = file_checksum(file + ".tmp", size);
  std::ostringstream text;
  text.precision(17);
  text << first_line << "\nfile " << fs::path(file).filename().string() << "\nsize " << size << "\nchecksum "
       << to_hex(sum) << "\nstep " << values.step << "\ntime " << values.time << '\n';
  Checksum own;
  own.add(text.str().data(), text.str().size());
  return text.str() + "manifest " + to_hex(own.value()) + "\n";
}

std::string entry(const std::string& text, const std::string& key) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (line.compare(0, key.size() + 1, key + " ") == 0) return line.substr(key.size() + 1);
  return {};
}

} // namespace

std::string next_checkpoint_file(const std::string& dir) {
  long last = 0;
  for (const std::string& name : names_in(dir)) last = std::max(last, number_of(name));
  return (fs::path(dir) / name_of(last + 1)).string();
}

std::string seal_checkpoint(const std::string& file, const CheckpointValues& values) {
  const std::string temporary = file + ".tmp";
  begin_sync(temporary); // the disk works while the sum is taken
  std::string manifest = manifest_text(file, values);
  sync_file(temporary);
  return manifest;
}

void publish_checkpoint(const std::string& file, const std::string& manifest) {
  rename_file(file + ".tmp", file);
  // Makes both names last. Had the disk only the manifest after a crash, the checkpoint would count as
  // damaged and the one before, which is removed later, as the newest.
  replace_file(manifest_of(file).string(), manifest);
}

void remove_old_checkpoints(const CheckpointFolder& folder) {
  std::vector<std::string> files = with_manifest(folder.dir);
  std::set<std::string> stays;
  const std::size_t keep = std::min(files.size(), static_cast<std::size_t>(std::max(1, folder.keep)));
  for (std::size_t k = 0; k < keep; ++k) {
    stays.insert(fs::path(files[k]).filename().string());
    stays.insert(manifest_of(files[k]).filename().string());
  }
  // The manifest goes first: without it the rest does not count, whatever happens in between.
  std::vector<fs::path> gone;
  for (const bool manifests : {true, false})
    for (const std::string& name : names_in(folder.dir))
      if (number_of(name) >= 0 && stays.count(name) == 0 && name.ends_with(".manifest") == manifests)
        gone.push_back(fs::path(folder.dir) / name);
  removal = std::jthread([gone = std::move(gone)] {
    std::error_code ignored;
    for (const fs::path& file : gone) fs::remove(file, ignored);
  });
}

std::string fault_of_checkpoint(const std::string& file) {
  try {
    if (!fs::exists(file)) return "there is no such file";
    if (!fs::exists(manifest_of(file))) return "it has no manifest, so it was not finished";
    const std::string text = read_file(manifest_of(file).string());
    const std::size_t own = text.rfind("manifest ");
    if (text.compare(0, std::strlen(first_line), first_line) != 0 || own == std::string::npos)
      return "its manifest is damaged or of another version";
    Checksum sum;
    sum.add(text.data(), own);
    if (text.substr(own) != "manifest " + to_hex(sum.value()) + "\n") return "its manifest is damaged";
    if (entry(text, "file") != fs::path(file).filename().string())
      return "its manifest belongs to another file";
    std::uintmax_t size = 0;
    const std::uint64_t content = file_checksum(file, size);
    if (entry(text, "size") != std::to_string(size))
      return "it has " + std::to_string(size) + " bytes instead of " + entry(text, "size");
    if (entry(text, "checksum") != to_hex(content))
      return "its content does not have the checksum of the manifest";
    return {};
  } catch (const std::exception& error) {
    return error.what();
  }
}

void write_values(hdf5::File& file, const CheckpointValues& values) {
  file.write("/impact/numbers/time", std::vector<double>{values.time});
  file.write("/impact/numbers/step", std::vector<double>{static_cast<double>(values.step)});
  file.make_group("/impact/given");
  for (const auto& [name, value] : values.numbers)
    file.write("/impact/given/numbers/" + name, std::vector<double>{value});
  for (const auto& [name, text] : values.texts) file.write("/impact/given/texts/" + name, text);
}

CheckpointValues read_values(const hdf5::File& file) {
  CheckpointValues values;
  values.time = file.read_numbers("/impact/numbers/time").at(0);
  values.step = static_cast<long>(file.read_numbers("/impact/numbers/step").at(0));
  for (const std::string& name : file.list("/impact/given/numbers"))
    values.numbers[name] = file.read_numbers("/impact/given/numbers/" + name).at(0);
  for (const std::string& name : file.list("/impact/given/texts"))
    values.texts[name] = file.read_text("/impact/given/texts/" + name);
  return values;
}

namespace {

template <class T> void append_bytes(std::string& out, const T& value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}
void append_text(std::string& out, const std::string& text) {
  append_bytes(out, text.size());
  out += text;
}

struct Reader {
  const std::string& in;
  std::size_t at = 0;
  template <class T> T bytes() {
    T value;
    std::memcpy(&value, in.data() + at, sizeof value);
    at += sizeof value;
    return value;
  }
  std::string text() {
    const auto size = bytes<std::size_t>();
    at += size;
    return in.substr(at - size, size);
  }
};

// The whole checkpoint as bytes, to send it from rank 0 to all.
std::string packed(const Checkpoint& c) {
  std::string out;
  append_text(out, c.file);
  append_bytes(out, c.values.time);
  append_bytes(out, c.values.step);
  append_bytes(out, c.values.numbers.size());
  for (const auto& [name, value] : c.values.numbers) append_text(out, name), append_bytes(out, value);
  append_bytes(out, c.values.texts.size());
  for (const auto& [name, text] : c.values.texts) append_text(out, name), append_text(out, text);
  append_bytes(out, c.warnings.size());
  for (const std::string& warning : c.warnings) append_text(out, warning);
  return out;
}

Checkpoint unpacked(const std::string& in) {
  Reader reader{in};
  Checkpoint c;
  c.file = reader.text();
  c.values.time = reader.bytes<double>();
  c.values.step = reader.bytes<long>();
  for (auto n = reader.bytes<std::size_t>(); n > 0; --n) {
    const std::string name = reader.text();
    c.values.numbers[name] = reader.bytes<double>();
  }
  for (auto n = reader.bytes<std::size_t>(); n > 0; --n) {
    const std::string name = reader.text();
    c.values.texts[name] = reader.text();
  }
  for (auto n = reader.bytes<std::size_t>(); n > 0; --n) c.warnings.push_back(reader.text());
  return c;
}

// A file that passed its checksum; what is wrong in it was written so (another version, another program).
CheckpointValues values_of(const std::string& name) {
  const hdf5::File file(name, hdf5::File::Mode::read);
  if (file.attribute("/", "impact_checkpoint_version", 0) != checkpoint_version)
    throw UserError(ExitCode::io,
                    "cannot use checkpoint " + name + ": it was written by another version of impact");
  return read_values(file);
}

} // namespace

std::optional<Checkpoint> newest_checkpoint(MPI_Comm comm, const std::string& dir) {
  std::string bytes;
  on_rank_zero(comm, [&] {
    Checkpoint found;
    for (const std::string& file : with_manifest(dir)) {
      const std::string fault = fault_of_checkpoint(file);
      if (fault.empty()) {
        found.file = file;
        found.values = values_of(file);
        bytes = packed(found);
        return;
      }
      found.warnings.push_back("checkpoint " + file + " is not used: " + fault);
    }
    if (found.warnings.empty()) return;
    std::string all;
    for (const std::string& warning : found.warnings) all += (all.empty() ? "" : "; ") + warning;
    throw UserError(ExitCode::io, "no usable checkpoint in " + dir + ": " + all +
                                      "; restore one of them, or remove them to start anew");
  });
  bytes = broadcast(comm, bytes);
  if (bytes.empty()) return std::nullopt;
  return unpacked(bytes);
}

void await_removal(MPI_Comm comm) {
  if (removal.joinable()) removal.join(); // on rank 0
  MPI_Barrier(comm);
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

Checkpoint open_checkpoint(MPI_Comm comm, const std::string& file) {
  std::string bytes;
  on_rank_zero(comm, [&] {
    const std::string fault = fault_of_checkpoint(file);
    if (!fault.empty())
      throw UserError(ExitCode::io,
                      "cannot use checkpoint " + file + ": " + fault +
                          "; name another one, or use -restart auto for the newest undamaged one");
    Checkpoint found{file, values_of(file), {}};
    bytes = packed(found);
  });
  return unpacked(broadcast(comm, bytes));
}

} // namespace impact
