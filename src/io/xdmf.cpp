#include "field_series.hpp"
#include <algorithm>
#include <impact/input/spelling.hpp>
#include <impact/input/units.hpp>

namespace impact {

namespace {

std::string escaped(std::string text) {
  using Pair = std::pair<const char*, const char*>;
  for (const auto& [from, to] :
       {Pair("&", "&amp;"), Pair("<", "&lt;"), Pair(">", "&gt;"), Pair("\"", "&quot;"), Pair("\n", "&#10;")})
    text = replaced(std::move(text), from, to);
  std::ranges::replace_if(
      text, [](unsigned char c) { return c < 32; }, ' ');
  return text;
}

std::string item(const std::string& file, const std::string& dataset, const std::string& extent, bool real) {
  return "<DataItem Dimensions=\"" + extent + "\" NumberType=\"" + (real ? "Float" : "Int") +
         "\" Precision=\"8\" Format=\"HDF\">" + escaped(file) + ":" + escaped(dataset) + "</DataItem>";
}

std::string topology(const XdmfMesh& mesh) {
  std::string extent = std::to_string(mesh.topology_length);
  if (mesh.cell_type != "Mixed" && mesh.cells > 0)
    extent = std::to_string(mesh.cells) + " " + std::to_string(mesh.topology_length / mesh.cells);
  return "        <Topology TopologyType=\"" + mesh.cell_type + "\" NumberOfElements=\"" +
         std::to_string(mesh.cells) + "\">" + item(mesh.file, "/topology", extent, false) + "</Topology>\n";
}

// Six components stay in the order xx yy zz xy yz xz as a Matrix: ParaView names them so, while its readers
// disagree on the order inside a Tensor6.
std::string attribute(const XdmfFile& file, const XdmfFrame& frame, const XdmfField& field) {
  const XdmfMesh& mesh = file.meshes[frame.mesh];
  const char* type = field.components == 1 ? "Scalar" : field.components == 3 ? "Vector" : "Matrix";
  std::string extent = std::to_string(field.on_nodes ? mesh.nodes : mesh.cells);
  if (field.components > 1) extent += " " + std::to_string(field.components);
  return "        <Attribute Name=\"" + escaped(field.name) + "\" AttributeType=\"" + type + "\" Center=\"" +
         (field.on_nodes ? "Node" : "Cell") + "\">" +
         item(frame.file, (field.on_nodes ? "/node/" : "/cell/") + field.name, extent, true) +
         "</Attribute>\n";
}

std::string grid(const XdmfFile& file, const XdmfFrame& frame) {
  const XdmfMesh& mesh = file.meshes[frame.mesh];
  std::string text = "      <Grid Name=\"mesh\" GridType=\"Uniform\">\n        <Time Value=\"" +
                     number_text(frame.time) + "\"/>\n" + topology(mesh) +
                     "        <Geometry GeometryType=\"XYZ\">" +
                     item(mesh.file, "/geometry", std::to_string(mesh.nodes) + " 3", true) + "</Geometry>\n";
  if (mesh.regions)
    text += "        <Attribute Name=\"region\" AttributeType=\"Scalar\" Center=\"Cell\">" +
            item(mesh.file, "/region", std::to_string(mesh.cells), false) + "</Attribute>\n";
  for (const XdmfField& field : frame.fields) text += attribute(file, frame, field);
  return text + "      </Grid>\n";
}

} // namespace

std::string XdmfFile::text() const {
  std::string out = "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<Xdmf Version=\"3.0\">\n  <Domain>\n"
                    "    <Information Name=\"title\" Value=\"" +
                    escaped(title) + "\"/>\n" + "    <Information Name=\"units\" Value=\"" + escaped(units) +
                    "\"/>\n" +
                    "    <Grid Name=\"times\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
  for (const XdmfFrame& frame : frames) out += grid(*this, frame);
  return out + "    </Grid>\n  </Domain>\n</Xdmf>\n";
}

} // namespace impact
