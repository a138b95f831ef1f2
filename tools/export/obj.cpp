// SPDX-License-Identifier: Apache-2.0
#include "tools/export/obj.h"

#include <algorithm>
#include <set>

#include "tools/base/bake_mesh.h"
#include "tools/base/output_file.h"
#include "tools/export/character_skin.h"
#include "tools/export/formats.h"
#include "tools/export/looks.h"
#include "tools/export/sequence.h"

namespace thew::tools {

namespace {

// Words are told apart by spaces.
std::string word(const std::string& name) {
  std::string result = one_line(name);
  std::replace(result.begin(), result.end(), ' ', '_');
  return result.empty() ? "_" : result;
}

// By face, what its group and material are from there on; "" where it is as before.
std::vector<std::string> headings(const Shot& shot, std::size_t m, std::size_t faces) {
  const BakeMesh& mesh = shot.mesh(m);
  const std::string kind = kind_name(mesh.kind), group = "g " + word(mesh.name) + " " + kind;
  std::vector<std::string> headings(faces, group + "\nusemtl " + kind + "\n");
  if (shot.meshes[m] == skin_mesh(shot.info())) {
    for (const SkinLooks::Part& part : shot.looks.parts) {
      const std::string material = word(part.material);
      for (const int f : part.faces) {
        headings[f] = group + " " + material + "\nusemtl " + material + "\n";
      }
    }
  }
  for (std::size_t f = headings.size(); f-- > 1;) {
    if (headings[f] == headings[f - 1]) headings[f].clear();
  }
  return headings;
}

std::string materials_text(const Shot& shot) {
  std::set<std::string> written;
  std::string text;
  const auto add = [&](const std::string& name, BakeMesh::Kind kind) {
    if (!written.insert(name).second) return;
    const auto [red, green, blue] = kind_colour(kind);
    text +=
        "newmtl " + name + "\nKd " + digits(red) + " " + digits(green) + " " + digits(blue) + "\n";
  };
  for (std::size_t m = 0; m < shot.meshes.size(); ++m) {
    add(kind_name(shot.mesh(m).kind), shot.mesh(m).kind);
  }
  for (const SkinLooks::Part& part : shot.looks.parts) {
    add(word(part.material), BakeMesh::Kind::kSkin);
  }
  return text;
}

}  // namespace

std::vector<std::string> obj_faces(const Shot& shot) {
  std::vector<std::string> texts;
  std::size_t before = 1, uvs_before = 1;  // OBJ counts from 1, through all objects
  for (std::size_t m = 0; m < shot.meshes.size(); ++m) {
    const Faces faces = faces_of(shot, m);
    const Uvs uvs = uvs_of(shot, m);
    std::string& text = texts.emplace_back();
    for (const auto& [u, v] : uvs.values) text += "vt " + digits(u) + " " + digits(v) + "\n";
    text += "s 1\n";
    const std::vector<std::string> heading = headings(shot, m, faces.counts.size());
    std::size_t corner = 0;
    for (std::size_t f = 0; f < faces.counts.size(); ++f) {
      text += heading[f] + "f";
      for (int c = 0; c < faces.counts[f]; ++c, ++corner) {
        const std::string number = std::to_string(before + faces.corners[corner]);
        const std::string uv =
            uvs.values.empty() ? "" : std::to_string(uvs_before + uvs.corners[corner]);
        text += " " + number + "/" + uv + "/" + number;
      }
      text += "\n";
    }
    uvs_before += uvs.values.size();
    before += shot.mesh(m).rest.vertices.size();
  }
  return texts;
}

std::string obj_text(const Shot& shot, const std::vector<std::string>& faces,
                     const std::vector<std::vector<Vec3>>& positions) {
  std::string text;
  for (std::size_t m = 0; m < shot.meshes.size(); ++m) {
    const BakeMesh& mesh = shot.mesh(m);
    text += "o " + one_line(mesh.name) + "\n";
    for (const Vec3& p : positions[m]) {
      text += "v " + (shot.info().double_precision ? digits<double>(p) : digits<float>(p)) + "\n";
    }
    for (const Vec3& n : unit_normals(shot, m, positions[m])) {
      text += "vn " + digits<float>(n) + "\n";
    }
    text += faces[m];
  }
  return text;
}

Exported export_obj(const Shot& shot, const std::filesystem::path& file) {
  WrittenFiles written;
  const std::vector<std::string> faces = obj_faces(shot);
  const std::string facts = facts_as_lines(shot, "# ");
  const std::string library = materials_file(file).filename().string();
  ExportFile materials(materials_file(file));
  materials.append(facts + materials_text(shot));
  materials.finish();
  written.add(materials_file(file));
  for_each_frame(shot, [&](const ShotFrame& frame) {
    const std::filesystem::path path = sequence_file(file, frame.frame);
    ExportFile out(path);
    out.append(facts + "# frame: " + std::to_string(frame.frame) + "\nmtllib " + library + "\n");
    out.append(obj_text(shot, faces, frame.positions));
    out.finish();
    written.add(path);
  });
  return {written.keep(), ""};
}

}  // namespace thew::tools
