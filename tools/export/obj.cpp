// SPDX-License-Identifier: Apache-2.0
#include "tools/export/obj.h"

#include "tools/base/output_file.h"
#include "tools/export/formats.h"
#include "tools/export/sequence.h"

namespace thew::tools {

std::string obj_text(const Shot& shot, const std::vector<std::vector<Vec3>>& positions) {
  std::string text;
  std::size_t before = 1;  // OBJ counts from 1, through all objects
  for (std::size_t m = 0; m < shot.meshes.size(); ++m) {
    const BakeMesh& mesh = shot.mesh(m);
    text += "o " + one_line(mesh.name) + "\n";
    for (const Vec3& p : positions[m]) {
      text += "v " + (shot.info().double_precision ? digits<double>(p) : digits<float>(p)) + "\n";
    }
    for (const Vec3& n : unit_normals(mesh, positions[m])) {
      text += "vn " + digits<float>(n) + "\n";
    }
    text += "s 1\n";
    for (const Triangle& triangle : mesh.rest.triangles) {
      text += "f";
      for (const int vertex : triangle) {
        const std::string number = std::to_string(before + static_cast<std::size_t>(vertex));
        text += " " + number + "//" + number;
      }
      text += "\n";
    }
    before += positions[m].size();
  }
  return text;
}

Exported export_obj(const Shot& shot, const std::filesystem::path& file) {
  WrittenFiles written;
  const std::string facts = facts_as_lines(shot, "# ");
  for_each_frame(shot, [&](const ShotFrame& frame) {
    const std::filesystem::path path = sequence_file(file, frame.frame);
    ExportFile out(path);
    out.append(facts + "# frame: " + std::to_string(frame.frame) + "\n");
    out.append(obj_text(shot, frame.positions));
    out.finish();
    written.add(path);
  });
  return {written.keep(), ""};
}

}  // namespace thew::tools
