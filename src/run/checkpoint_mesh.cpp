#include <algorithm>
#include <impact/run/checkpoint_file.hpp>
#include <sstream>

namespace impact {

namespace {

constexpr const char* folder = "/impact/mesh/";

void write_numbers(hdf5::File& file, const std::string& path, const std::vector<int>& numbers) {
  const hdf5::Id dataset = file.make_dataset(path, H5T_NATIVE_INT, {numbers.size()});
  if (!numbers.empty()) file.write_slab(dataset, H5T_NATIVE_INT, 0, numbers.size(), numbers.data());
}

} // namespace

void write_stored_mesh(hdf5::File& file, const GmshFile& mesh) {
  std::ostringstream groups;
  for (const GmshGroup& group : mesh.groups)
    groups << group.dim << ' ' << group.tag << ' ' << group.name << '\n';
  std::vector<int>
      blocks; // of each block: dimension, nodes of an element, numbers of groups and nodes, both lists
  for (const GmshBlock& block : mesh.blocks) {
    blocks.insert(blocks.end(), {block.dim, block.nodes, static_cast<int>(block.groups.size()),
                                 static_cast<int>(block.node.size())});
    blocks.insert(blocks.end(), block.groups.begin(), block.groups.end());
    blocks.insert(blocks.end(), block.node.begin(), block.node.end());
  }
  file.write(std::string(folder) + "nodes", mesh.x);
  file.write(std::string(folder) + "groups", groups.str());
  write_numbers(file, std::string(folder) + "blocks", blocks);
}

std::optional<GmshFile> read_stored_mesh(const std::string& checkpoint) {
  const hdf5::File file(checkpoint, hdf5::File::Mode::read);
  if (!file.has(std::string(folder) + "blocks")) return {};
  GmshFile mesh;
  mesh.x = file.read_numbers(std::string(folder) + "nodes");
  std::istringstream groups(file.read_text(std::string(folder) + "groups"));
  for (GmshGroup group; groups >> group.dim >> group.tag;) {
    groups.get(); // the blank before the name
    std::getline(groups, group.name);
    mesh.groups.push_back(group);
  }
  const std::vector<double> blocks = file.read_numbers(std::string(folder) + "blocks");
  const auto list = [&](std::size_t& at, std::size_t count) {
    std::vector<int> numbers(count);
    std::transform(blocks.begin() + static_cast<std::ptrdiff_t>(at),
                   blocks.begin() + static_cast<std::ptrdiff_t>(at + count), numbers.begin(),
                   [](double number) { return static_cast<int>(number); });
    at += count;
    return numbers;
  };
  for (std::size_t at = 0; at < blocks.size();) {
    const std::vector<int> head = list(at, 4);
    GmshBlock block{head[0], head[1], {}, {}};
    block.groups = list(at, static_cast<std::size_t>(head[2]));
    block.node = list(at, static_cast<std::size_t>(head[3]));
    mesh.dim = std::max(mesh.dim, block.dim);
    mesh.blocks.push_back(std::move(block));
  }
  return mesh;
}

} // namespace impact
