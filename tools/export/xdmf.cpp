// SPDX-License-Identifier: Apache-2.0
//
// A text that tells readers of XDMF where in bake.h5 each frame stands. Slabs are written behind
// the dataset's path, |start:stride:count:size, each by dimension. In ParaView 5.11 both readers of
// XDMF 3 know these alone, its reader of XDMF 2 the element HyperSlab alone, and meshio 5.0
// neither.
#include "tools/base/output_file.h"
#include "tools/base/text.h"
#include "tools/export/formats.h"

namespace thew::tools {
namespace {

std::string data_item(const std::string& dimensions, const std::string& type, int precision,
                      const std::string& where) {
  return "<DataItem Dimensions=\"" + dimensions + "\" NumberType=\"" + type + "\" Precision=\"" +
         std::to_string(precision) + "\" Format=\"HDF\">" + escape_html(where) + "</DataItem>";
}

std::string grid(const Shot& shot, std::size_t m, int place, const std::string& bake) {
  const BakeMesh& mesh = shot.mesh(m);
  const std::string group = bake + ":/meshes/" + mesh.name;
  const std::string nodes = std::to_string(mesh.rest.vertices.size());
  const std::string triangles = std::to_string(mesh.rest.triangles.size());
  std::string text =
      "        <Grid Name=\"" + escape_html(one_line(mesh.name)) +
      "\" GridType=\"Uniform\">\n          <Topology TopologyType=\"Triangle\" "
      "NumberOfElements=\"" +
      triangles + "\">" + data_item(triangles + " 3", "UInt", 4, group + "/triangles") +
      "</Topology>\n          <Geometry GeometryType=\"XYZ\">" +
      data_item(nodes + " 3", "Float", shot.info().double_precision ? 8 : 4,
                group + "/positions|" + std::to_string(place) + " 0 0:1 1 1:1 " + nodes +
                    " 3:" + std::to_string(shot.info().frames.size()) + " " + nodes + " 3") +
      "</Geometry>\n";
  if (!mesh.weights.empty()) {
    text += "          <Attribute Name=\"weight\" AttributeType=\"Scalar\" Center=\"Node\">" +
            data_item(nodes, "Float", 8, group + "/weights") + "</Attribute>\n";
  }
  for (const auto& [name, values] : metrics_of(shot, mesh)) {
    text += "          <Attribute Name=\"" + name + "\" AttributeType=\"Scalar\" Center=\"Grid\">" +
            "<DataItem Dimensions=\"1\" NumberType=\"Float\" Precision=\"8\" Format=\"XML\">" +
            digits((*values)[place]) + "</DataItem></Attribute>\n";
  }
  return text + "        </Grid>\n";
}

// As seen from the side-car's folder, links resolved: ".." of a linked folder is elsewhere.
std::string path_from(const std::filesystem::path& file, const std::filesystem::path& bake) {
  const auto folder =
      std::filesystem::weakly_canonical(std::filesystem::absolute(file).parent_path());
  return std::filesystem::weakly_canonical(bake).lexically_relative(folder).string();
}

void check_names(const Shot& shot, const std::string& bake) {
  std::vector<std::string> names = {bake};
  for (std::size_t m = 0; m < shot.meshes.size(); ++m) names.push_back(shot.mesh(m).name);
  for (const std::string& name : names) {
    if (name.find_first_of("|:") == std::string::npos) continue;
    throw Error(ErrorCode::kUsage,
                "\"" + one_line(name) +
                    "\": XDMF has a meaning of its own for | and :, and so cannot "
                    "point to this name; rename it, or choose another --mesh");
  }
}

}  // namespace

Exported export_xdmf(const Shot& shot, const std::filesystem::path& file,
                     const std::filesystem::path& bake) {
  const std::string relative = path_from(file, bake);
  check_names(shot, relative);
  ExportFile out(file);
  out.append(
      "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<Xdmf Version=\"3.0\">\n  <Domain>\n"
      "    <Grid Name=\"bake\" GridType=\"Collection\" CollectionType=\"Temporal\">\n");
  for (const auto& [name, value] : facts_of(shot)) {
    out.append("      <Information Name=\"" + name + "\" Value=\"" + escape_html(value) + "\"/>\n");
  }
  // Each frame is read, though it is only pointed at: what is no position is told here.
  for_each_frame(shot, [&](const ShotFrame& frame) {
    out.append("      <Grid Name=\"frame " + std::to_string(frame.frame) +
               "\" GridType=\"Collection\" CollectionType=\"Spatial\">\n        <Time Value=\"" +
               digits(frame.frame / shot.info().fps) + "\"/>\n");
    for (std::size_t m = 0; m < shot.meshes.size(); ++m) {
      out.append(grid(shot, m, frame.place, relative));
    }
    out.append("      </Grid>\n");
  });
  out.append("    </Grid>\n  </Domain>\n</Xdmf>\n");
  out.finish();
  return {{file},
          "the numbers stay in " + bake.string() +
              ", keep both where they are; time is "
              "frame / fps, in seconds; in ParaView choose Xdmf3 Reader S or T, since its XDMF "
              "Reader does not know the slabs"};
}

}  // namespace thew::tools
