// SPDX-License-Identifier: Apache-2.0
#include "tools/base/output_file.h"
#include "tools/export/formats.h"
#include "tools/export/sequence.h"

namespace thew::tools {
namespace {

std::string header(const Shot& shot, const BakeMesh& mesh, int frame) {
  const std::string number = shot.info().double_precision ? "double" : "float";
  std::string text = "ply\nformat binary_little_endian 1.0\n" + facts_as_lines(shot, "comment ");
  text += "comment mesh: " + one_line(mesh.name) + "\ncomment frame: " + std::to_string(frame) +
          "\ncomment vx vy vz: velocity in m/s\n";
  text += "element vertex " + std::to_string(mesh.rest.vertices.size()) + "\n";
  for (const char* name : {"x", "y", "z"}) text += "property " + number + " " + name + "\n";
  for (const char* name : {"nx", "ny", "nz", "vx", "vy", "vz"}) {
    text += "property float " + std::string(name) + "\n";
  }
  return text + "element face " + std::to_string(mesh.rest.triangles.size()) +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}

std::string body(const Shot& shot, const BakeMesh& mesh, const ShotFrame& frame) {
  const std::vector<Vec3>& positions = frame.positions[0];
  const std::vector<Vec3> normals = unit_normals(shot, 0, positions);
  const std::vector<Vec3> velocity = velocities(shot, frame.place)[0];
  std::string bytes;
  for (std::size_t v = 0; v < positions.size(); ++v) {
    if (shot.info().double_precision) {
      for (int axis = 0; axis < 3; ++axis) put(bytes, positions[v][axis]);
    } else {
      put_floats(bytes, positions[v]);
    }
    put_floats(bytes, normals[v]);
    put_floats(bytes, velocity[v]);
  }
  for (const Triangle& triangle : mesh.rest.triangles) {
    put<std::uint8_t>(bytes, 3);
    for (const int vertex : triangle) put<std::int32_t>(bytes, vertex);
  }
  return bytes;
}

}  // namespace

Exported export_ply(const Shot& shot, const std::filesystem::path& file) {
  const BakeMesh& mesh = only_mesh(shot, "PLY");
  WrittenFiles written;
  for_each_frame(shot, [&](const ShotFrame& frame) {
    const std::filesystem::path path = sequence_file(file, frame.frame);
    ExportFile out(path);
    out.append(header(shot, mesh, frame.frame) + body(shot, mesh, frame));
    out.finish();
    written.add(path);
  });
  return {written.keep(), ""};
}

}  // namespace thew::tools
