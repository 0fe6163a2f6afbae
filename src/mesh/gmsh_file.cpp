#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <impact/math/index.hpp>
#include <impact/mesh/gmsh.hpp>
#include <optional>

namespace impact {

namespace {

[[noreturn]] void garbled(const std::string& what) { throw UserError(ExitCode::io, what); }

// Elements of a type in gmsh's manual, section "MSH file format", without groups.
GmshBlock kind_of(std::int64_t type) {
  if (type == 15) return {0, 1, 0, {}};
  if (type == 1) return {1, 2, 0, {}};
  if (type == 8) return {1, 3, 0, {}};
  for (const Shape shape : known_shapes())
    if (shape->names.gmsh == type) return {shape->dim, shape->nodes, 0, {}};
  if (type == 6 || type == 7)
    throw UserError(ExitCode::data,
                    "prisms or pyramids; allowed are triangles, quadrilaterals, tetrahedra and hexahedra");
  if (type >= 8 && type <= 140)
    throw UserError(ExitCode::data,
                    "elements of gmsh type " + std::to_string(type) +
                        ": allowed are triangles, quadrilaterals, tetrahedra and hexahedra of first and "
                        "second order; mesh with one of them (gmsh -order 2)");
  garbled("unknown element type " + std::to_string(type));
}

// Reads numbers one by one, ASCII or binary, and never past the end.
class Cursor {
public:
  Cursor(const char* begin, const char* end) : p_(begin), end_(end) {}
  bool binary = false;

  void skip_blanks() {
    while (p_ < end_ && std::isspace(static_cast<unsigned char>(*p_))) ++p_;
  }
  bool done() const { return p_ >= end_; }
  std::size_t left() const { return static_cast<std::size_t>(end_ - p_); }
  void end_line() {
    while (p_ < end_ && *p_++ != '\n') {
    }
  }
  std::string line() {
    const char* begin = p_;
    end_line();
    std::string text(begin, p_);
    while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) text.pop_back();
    return text;
  }
  std::int64_t integer() { return binary ? raw<std::int32_t>() : text<std::int64_t>(); } // gmsh's int
  std::int64_t size() { return binary ? raw<std::int64_t>() : text<std::int64_t>(); }    // gmsh's size_t
  double number() { return binary ? raw<double>() : text<double>(); }
  std::int64_t ascii_integer() { return text<std::int64_t>(); }
  double ascii_number() { return text<double>(); }
  /// A count of items of which each takes at least one byte: a garbled count must not make us allocate the
  /// machine.
  std::size_t count(std::int64_t n) const {
    if (n < 0 || static_cast<std::uint64_t>(n) > left())
      garbled("a count of " + std::to_string(n) + " items is impossible");
    return static_cast<std::size_t>(n);
  }
  std::string quoted() {
    const std::string rest = line();
    const std::size_t open = rest.find('"'), close = rest.find('"', open + 1);
    if (open == std::string::npos) garbled("a name without quotes in $PhysicalNames");
    if (close == std::string::npos) garbled("a name without closing quotes in $PhysicalNames");
    return rest.substr(open + 1, close - open - 1);
  }
  void skip_section(const std::string& name) {
    const std::string mark = "$End" + name;
    const char* found = std::search(p_, end_, mark.begin(), mark.end());
    if (found == end_) garbled("the file ends inside $" + name);
    p_ = found + mark.size();
    end_line();
  }
  void expect_end(const std::string& name) {
    skip_blanks();
    if (line() != "$End" + name) garbled("no $End" + name + " where it is expected");
  }

private:
  template <class T> T raw() {
    if (left() < sizeof(T)) garbled("the file ends too early");
    T value;
    std::memcpy(&value, p_, sizeof(T));
    p_ += sizeof(T);
    return value;
  }
  template <class T> T text() {
    skip_blanks();
    T value{};
    if (p_ < end_ && *p_ == '+') ++p_;
    const auto [next, error] = std::from_chars(p_, end_, value);
    if (p_ >= end_) garbled("the file ends too early");
    if (error == std::errc::result_out_of_range && std::is_floating_point_v<T>)
      value = T{}; // a denormal number
    else if (error != std::errc() || (next < end_ && !std::isspace(static_cast<unsigned char>(*next))))
      garbled("not a number: \"" +
              std::string(p_, std::find_if(p_, std::min(end_, p_ + 20), [](char c) { return c == '\n'; })) +
              "\"");
    p_ = next;
    return value;
  }

  const char *p_, *end_;
};

/// Numbers from 0 by gmsh's tags, which mostly are consecutive.
class NodeTags {
public:
  void reserve(std::size_t count) { nodes_.reserve(count); }
  void add(std::int64_t tag) { nodes_.emplace_back(tag, static_cast<int>(nodes_.size())); }
  std::size_t size() const { return nodes_.size(); }
  /// After the last one.
  void sort() {
    std::ranges::sort(nodes_);
    const auto twin = std::ranges::adjacent_find(nodes_, {}, &Node::first);
    if (twin != nodes_.end()) garbled("node " + std::to_string(twin->first) + " occurs twice");
  }
  int find(std::int64_t tag) const {
    const std::uint64_t guess =
        nodes_.empty() ? 0 : static_cast<std::uint64_t>(tag) - static_cast<std::uint64_t>(nodes_[0].first);
    if (guess < nodes_.size() && nodes_[guess].first == tag) return nodes_[guess].second;
    const auto found = std::ranges::lower_bound(nodes_, tag, {}, &Node::first);
    if (found == nodes_.end() || found->first != tag)
      garbled("an element uses node " + std::to_string(tag) + ", which is not there");
    return found->second;
  }

private:
  using Node = std::pair<std::int64_t, int>;
  std::vector<Node> nodes_;
};

class Reader {
public:
  Reader(const char* begin, const char* end) : in_(begin, end) {}

  GmshFile read() {
    bool formatted = false;
    for (in_.skip_blanks(); !in_.done(); in_.skip_blanks()) {
      const std::string head = in_.line();
      if (head.empty() || head[0] != '$')
        garbled("no section where one is expected; is this a mesh file of gmsh?");
      const std::string name = head.substr(1);
      formatted = formatted || name == "MeshFormat";
      if (!formatted) garbled("no $MeshFormat at the head; is this a mesh file of gmsh?");
      read_section(name);
    }
    if (!elements_) garbled("no $Elements; the file is cut or no mesh");
    return std::move(file_);
  }
  bool version4() const { return version4_; }

private:
  void read_section(const std::string& name) {
    if (name == "PartitionedEntities")
      throw UserError(ExitCode::data,
                      "a partitioned mesh; write it unpartitioned, the program partitions by itself");
    if (name == "Elements" && !nodes_) garbled("$Elements before $Nodes");
    if (name == "MeshFormat") return read_format();
    if (name == "PhysicalNames") return read_names();
    if (name == "Entities") return read_entities();
    if (name == "Nodes") return version4_ ? read_nodes4() : read_nodes2();
    if (name == "Elements") return version4_ ? read_elements4() : read_elements2();
    in_.skip_section(name);
  }

  void read_format() {
    const double version = in_.ascii_number();
    const std::int64_t type = in_.ascii_integer(), data_size = in_.ascii_integer();
    version4_ = std::abs(version - 4.1) < 1e-6;
    if (!version4_ && std::abs(version - 2.2) > 1e-6)
      garbled("mesh format version " + std::to_string(version).substr(0, 3) +
              "; allowed 4.1 and 2.2 (gmsh -format msh41)");
    if (data_size != 8) garbled("data size " + std::to_string(data_size) + "; allowed 8");
    in_.end_line();
    in_.binary = type == 1;
    if (in_.binary && in_.integer() != 1) garbled("binary file with another byte order; write it as ASCII");
    in_.expect_end("MeshFormat");
  }

  void read_names() {
    for (std::size_t n = in_.count(in_.ascii_integer()); n > 0; --n) {
      const auto dim = static_cast<int>(in_.ascii_integer()), tag = static_cast<int>(in_.ascii_integer());
      names_[{dim, tag}] = in_.quoted();
    }
    in_.expect_end("PhysicalNames");
  }

  void read_entities() {
    std::size_t counts[4];
    for (auto& n : counts) n = in_.count(in_.size());
    for (int dim = 0; dim < 4; ++dim)
      for (std::size_t e = 0; e < counts[dim]; ++e) {
        const std::int64_t tag = in_.integer();
        for (int k = 0; k < (dim == 0 ? 3 : 6); ++k) in_.number();
        auto& tags = physical_of_entity_[{dim, tag}];
        for (std::size_t n = in_.count(in_.size()); n > 0; --n)
          tags.push_back(std::abs(static_cast<int>(in_.integer())));
        if (dim == 0) continue;
        for (std::size_t n = in_.count(in_.size()); n > 0; --n) in_.integer();
      }
    in_.expect_end("Entities");
  }

  void read_nodes4() {
    const std::size_t blocks = in_.count(in_.size()), total = in_.count(in_.size());
    in_.size();
    in_.size();
    tags_.reserve(total);
    file_.x.reserve(3 * total);
    for (std::size_t b = 0; b < blocks; ++b) {
      const std::int64_t dim = in_.integer();
      in_.integer();
      const std::int64_t parametric = in_.integer();
      const std::size_t n = in_.count(in_.size());
      for (std::size_t k = 0; k < n; ++k) tags_.add(in_.size());
      for (std::size_t k = 0; k < n; ++k) {
        for (int i = 0; i < 3; ++i) file_.x.push_back(in_.number());
        for (std::int64_t i = 0; parametric != 0 && i < dim; ++i) in_.number();
      }
    }
    if (tags_.size() != total)
      garbled("$Nodes announces " + std::to_string(total) + " nodes, but has " +
              std::to_string(tags_.size()));
    tags_.sort();
    nodes_ = true;
    in_.expect_end("Nodes");
  }
  void read_nodes2() {
    const std::size_t total = in_.count(in_.ascii_integer());
    if (in_.binary) in_.end_line();
    for (std::size_t k = 0; k < total; ++k) {
      tags_.add(in_.integer());
      for (int i = 0; i < 3; ++i) file_.x.push_back(in_.number());
    }
    tags_.sort();
    nodes_ = true;
    in_.expect_end("Nodes");
  }

  // Groups of one (dim, tag) and groups of one name and dimension are the same.
  int group(int dim, int tag) {
    static constexpr const char* prefix_2d[] = {"point_", "boundary_", "region_", "volume_"};
    static constexpr const char* prefix_3d[] = {"point_", "curve_", "boundary_", "region_"};
    const auto named = names_.find({dim, tag});
    const bool solid = std::any_of(physical_of_entity_.begin(), physical_of_entity_.end(),
                                   [](const auto& e) { return e.first.first == 3; });
    const std::string name =
        named != names_.end() ? named->second : (solid ? prefix_3d : prefix_2d)[dim] + std::to_string(tag);
    for (std::size_t g = 0; g < file_.groups.size(); ++g) {
      if (file_.groups[g].name != name) continue;
      if (file_.groups[g].dim == dim) return static_cast<int>(g);
      throw UserError(ExitCode::data,
                      "physical group \"" + name + "\" occurs with two dimensions; give them two names");
    }
    if (name.empty() || name == "depth" || name == "celltype")
      throw UserError(ExitCode::data,
                      "physical group \"" + name + "\": this name is reserved; choose another one");
    file_.groups.push_back({name, dim, tag});
    return static_cast<int>(file_.groups.size()) - 1;
  }

  GmshBlock& block(GmshBlock b, const std::vector<int>& tags) {
    std::vector<int> groups;
    for (const int tag : tags) groups.push_back(group(b.dim, tag));
    const auto found = std::find(file_.sets.begin(), file_.sets.end(), groups);
    b.set = static_cast<int>(found - file_.sets.begin());
    if (found == file_.sets.end()) file_.sets.push_back(std::move(groups));
    const GmshBlock* last = file_.blocks.empty() ? nullptr : &file_.blocks.back();
    if (!last || last->nodes != b.nodes || last->dim != b.dim || last->set != b.set)
      file_.blocks.push_back(std::move(b));
    return file_.blocks.back();
  }

  void read_elements4() {
    const std::size_t blocks = in_.count(in_.size()), total = in_.count(in_.size());
    in_.size();
    in_.size();
    std::size_t seen = 0;
    for (std::size_t b = 0; b < blocks; ++b) {
      const int dim = static_cast<int>(in_.integer());
      const std::int64_t entity = in_.integer();
      const GmshBlock kind = kind_of(in_.integer());
      if (kind.dim != dim)
        garbled("an element block of dimension " + std::to_string(dim) + " with elements of another");
      const std::size_t n = in_.count(in_.size());
      GmshBlock& out = block(kind, physical_of_entity_[{dim, entity}]);
      if (n <= in_.left() / at(kind.nodes)) out.node.reserve(out.node.size() + n * at(kind.nodes));
      for (std::size_t k = 0; k < n; ++k, ++seen) {
        in_.size();
        for (int a = 0; a < kind.nodes; ++a) out.node.push_back(tags_.find(in_.size()));
      }
    }
    if (seen != total)
      garbled("$Elements announces " + std::to_string(total) + " elements, but has " + std::to_string(seen));
    elements_ = true;
    in_.expect_end("Elements");
  }
  void read_elements2() {
    const std::size_t total = in_.count(in_.ascii_integer());
    if (in_.binary) in_.end_line();
    std::int64_t type = 0, same = 0, tag_count = 0;
    for (std::size_t k = 0; k < total; ++k) {
      if (!in_.binary) {
        in_.integer();
        type = in_.integer();
        tag_count = in_.integer();
      } else if (same-- == 0) {
        type = in_.integer();
        same = in_.integer() - 1;
        tag_count = in_.integer();
      }
      if (in_.binary) in_.integer();
      const GmshBlock kind = kind_of(type);
      std::vector<int> tags;
      for (std::size_t t = in_.count(tag_count); t > 0; --t) tags.push_back(static_cast<int>(in_.integer()));
      tags.resize(tags.empty() || tags[0] == 0 ? 0 : 1);
      GmshBlock& out = block(kind, tags);
      for (int a = 0; a < kind.nodes; ++a) out.node.push_back(tags_.find(in_.integer()));
    }
    elements_ = true;
    in_.expect_end("Elements");
  }

  Cursor in_;
  GmshFile file_;
  bool version4_ = true, nodes_ = false, elements_ = false; // what has been read
  std::map<std::pair<int, int>, std::string> names_;
  std::map<std::pair<int, std::int64_t>, std::vector<int>> physical_of_entity_;
  NodeTags tags_;
};

} // namespace

Shape GmshBlock::shape() const {
  for (const Shape shape : known_shapes())
    if (shape->dim == dim && shape->nodes == nodes) return shape;
  throw UserError(ExitCode::data, "mesh: no cell has " + std::to_string(nodes) + " nodes");
}

namespace {

std::string text_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary | std::ios::ate);
  if (!in) throw UserError(ExitCode::io, path + ": cannot be opened; is the path right?");
  const std::streamoff length = in.tellg();
  if (length <= 0) throw UserError(ExitCode::io, path + ": is empty or no file");
  std::string text(static_cast<std::size_t>(length), '\0');
  in.seekg(0);
  if (!in.read(text.data(), length)) throw UserError(ExitCode::io, path + ": cannot be read");
  return text;
}

} // namespace

GmshFile read_gmsh(const std::string& path) {
  std::string text = text_of(path);
  try {
    std::optional<Reader> reader(std::in_place, text.data(), text.data() + text.size());
    GmshFile file = reader->read();
    const bool version4 = reader->version4();
    reader.reset(); // the checks need the memory
    text = {};
    text.shrink_to_fit();
    check_gmsh(file, version4);
    return file;
  } catch (const UserError& error) {
    throw UserError(error.code(), path + ": " + error.what());
  }
}

} // namespace impact
