#include "field_series.hpp"
#include <algorithm>
#include <charconv>
#include <filesystem>
#include <impact/io/durable_file.hpp>
#include <impact/io/hdf5_reader.hpp>
#include <impact/petsc/error.hpp>
#include <map>
#include <set>
#include <string_view>

namespace impact {

namespace {

/// The name of a file in our folder is "000012.h5" or "mesh_0.h5", or one of these with the ending of a file
/// that was not finished or set aside. Other names have the number -1.
struct OwnName {
  bool mesh = false, finished = false;
  int number = -1;
};

OwnName own_name(const std::string& name) {
  OwnName own;
  own.mesh = name.starts_with("mesh_");
  const char *begin = name.data() + (own.mesh ? 5 : 0), *end = name.data() + name.size();
  int number = -1;
  const auto [rest, error] = std::from_chars(begin, end, number);
  const std::string_view ending(rest, end);
  if (error != std::errc{} || number < 0 || !ending.starts_with(".h5")) return own;
  own.number = number;
  own.finished = ending == ".h5";
  return own;
}

/// Finished files of one kind by their number.
std::map<int, std::string> finished_files(const std::string& folder, bool meshes) {
  std::map<int, std::string> files;
  for (const std::string& name : names_in(folder))
    if (const OwnName own = own_name(name); own.finished && own.mesh == meshes) files[own.number] = name;
  return files;
}

} // namespace

std::string FieldSeries::relative(const std::string& name) const {
  return std::filesystem::path(folder()).filename().string() + "/" + name;
}

std::string FieldSeries::next_mesh_name() const { return "mesh_" + std::to_string(next_mesh_) + ".h5"; }

std::string FieldSeries::frame_name(double time) const {
  for (const XdmfFrame& frame : xdmf.frames)
    if (frame.time == time) return std::filesystem::path(frame.file).filename().string();
  const std::string digits = std::to_string(next_frame_);
  return std::string(6 - std::min<std::size_t>(6, digits.size()), '0') + digits + ".h5";
}

void FieldSeries::add_mesh(const XdmfMesh& entry, const std::string& sum) {
  mesh = xdmf.meshes.size();
  xdmf.meshes.push_back(entry);
  sums_.push_back(sum);
  ++next_mesh_;
}

void FieldSeries::add_frame(const XdmfFrame& frame) {
  const auto same =
      std::ranges::find_if(xdmf.frames, [&](const XdmfFrame& f) { return f.time == frame.time; });
  if (same != xdmf.frames.end()) {
    *same = frame;
  } else {
    xdmf.frames.push_back(frame);
    ++next_frame_;
  }
  replace_xdmf();
}

void FieldSeries::replace_xdmf() const { replace_file(xdmf_file(), xdmf.text()); }

void FieldSeries::set_aside(const std::string& name, const std::exception& error,
                            std::string& warning) const {
  rename_durably(file(name), file(name) + ".damaged");
  warning +=
      std::string(warning.empty() ? "" : "; ") + error.what() + "; it was kept as " + file(name) + ".damaged";
}

bool FieldSeries::find_meshes(const std::string& sum, std::string& warning) {
  bool found = false;
  for (const auto& [number, name] : finished_files(folder(), true)) {
    next_mesh_ = number + 1;
    try {
      const hdf5::Reader h5(file(name));
      std::uint64_t length = 1;
      for (const hsize_t n : h5.extent("/topology")) length *= n;
      const XdmfMesh entry{relative(name),
                           h5.text("/cells"),
                           h5.extent("/geometry").at(0),
                           static_cast<std::uint64_t>(h5.numbers("/cell_count").at(0)),
                           length,
                           h5.has("/region")};
      sums_.push_back(h5.text("/checksum"));
      xdmf.meshes.push_back(entry);
    } catch (const std::exception& error) {
      set_aside(name, error, warning);
      continue;
    }
    if (sums_.back() == sum) {
      mesh = sums_.size() - 1;
      found = true;
    }
  }
  return found;
}

XdmfFrame FieldSeries::read_frame(const std::string& name) const {
  const hdf5::Reader h5(file(name));
  const auto its_mesh = std::ranges::find(sums_, h5.text("/mesh"));
  if (its_mesh == sums_.end())
    throw UserError(ExitCode::io, "cannot use " + file(name) + ": its mesh is not there");
  XdmfFrame frame{
      h5.numbers("/time").at(0), relative(name), static_cast<std::size_t>(its_mesh - sums_.begin()), {}};
  for (const bool on_nodes : {true, false})
    for (const std::string& field : h5.list(on_nodes ? "/node" : "/cell")) {
      const auto extent = h5.extent((on_nodes ? "/node/" : "/cell/") + field);
      frame.fields.push_back({field, on_nodes, extent.size() > 1 ? static_cast<int>(extent[1]) : 1});
    }
  return frame;
}

void FieldSeries::find_frames(double after, std::string& warning) {
  for (const auto& [number, name] : finished_files(folder(), false)) {
    try {
      XdmfFrame frame = read_frame(name);
      // The number grows with the time; a file that breaks this was left by times that were dropped before.
      if (frame.time > after || (!xdmf.frames.empty() && frame.time <= xdmf.frames.back().time)) continue;
      xdmf.frames.push_back(std::move(frame));
      next_frame_ = number + 1;
    } catch (const std::exception& error) {
      set_aside(name, error, warning);
    }
  }
}

void FieldSeries::remove_all_but_named() const {
  std::set<std::string> stays;
  if (!xdmf.meshes.empty()) stays.insert(xdmf.meshes[mesh].file);
  for (const XdmfFrame& frame : xdmf.frames) {
    stays.insert(frame.file);
    stays.insert(xdmf.meshes[frame.mesh].file);
  }
  for (const std::string& name : names_in(folder()))
    if (own_name(name).number >= 0 && stays.count(relative(name)) == 0 && !name.ends_with(".damaged"))
      remove_file(file(name));
}

} // namespace impact
