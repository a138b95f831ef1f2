// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <functional>
#include <set>

#include "tools/base/output_file.h"
#include "tools/export/formats.h"

namespace thew::tools {
namespace {

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : one_line(text)) {
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  return result + "\"";
}

// A prim's name is an identifier, and no two prims have the same.
std::string prim_name(const std::string& name, std::set<std::string>& taken) {
  std::string result;
  for (const char c : name) {
    const bool digit = c >= '0' && c <= '9';
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    if (digit && result.empty()) result = "_";
    result += digit || letter ? c : '_';
  }
  if (result.empty()) result = "_";
  while (!taken.insert(result).second) result += "_";
  return result;
}

std::string header(const Shot& shot) {
  std::string text = "#usda 1.0\n(\n    customLayerData = {\n";
  for (const auto& [name, value] : facts_of(shot)) {
    text += "        string " + name + " = " + quoted(value) + "\n";
  }
  const std::string fps = digits(shot.info().fps);
  return text + "    }\n    defaultPrim = \"Bake\"\n    endTimeCode = " +
         std::to_string(shot.frame(shot.places.size() - 1)) + "\n    framesPerSecond = " + fps +
         "\n    metersPerUnit = 1\n    startTimeCode = " + std::to_string(shot.first_frame()) +
         "\n    timeCodesPerSecond = " + fps + "\n    upAxis = \"Y\"\n)\n\n";
}

std::string tuples(const std::vector<Vec3>& values) {
  std::string text = "[";
  for (const Vec3& value : values) {
    text += (text.size() > 1 ? ", (" : "(") + digits<float>(value, ", ") + ")";
  }
  return text + "]";
}

std::vector<Vec3> extent(const std::vector<Vec3>& positions) {
  Vec3 low = positions.front(), high = low;
  for (const Vec3& p : positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return {low, high};
}

std::string topology(const TriMesh& rest) {
  std::string counts, indices;
  for (const Triangle& triangle : rest.triangles) {
    counts += counts.empty() ? "3" : ", 3";
    for (const int vertex : triangle) {
      indices += (indices.empty() ? "" : ", ") + std::to_string(vertex);
    }
  }
  return "        int[] faceVertexCounts = [" + counts + "]\n        int[] faceVertexIndices = [" +
         indices + "]\n";
}

// One attribute's values at all frames; a time code is a frame's number. Its default, the rest
// pose, has to follow: three.js's reader forgets one that comes before.
void write_samples(ExportFile& out, const std::string& declaration, const Shot& shot,
                   const std::function<std::vector<Vec3>(std::size_t)>& at) {
  out.append("        " + declaration + ".timeSamples = {\n");
  for (std::size_t i = 0; i < shot.places.size(); ++i) {
    out.append("            " + std::to_string(shot.frame(i)) + ": " + tuples(at(i)) + ",\n");
  }
  out.append("        }\n");
}

}  // namespace

Exported export_usda(const Shot& shot, const std::filesystem::path& file) {
  ExportFile out(file);
  out.append(header(shot) + "def Xform \"Bake\"\n{\n");
  std::vector<ShotFrame> frames;
  std::vector<std::vector<std::vector<Vec3>>> velocity;  // by frame, mesh
  for_each_frame(shot, [&](const ShotFrame& frame) {
    frames.push_back(frame);
    velocity.push_back(velocities(shot, frame.place));
  });
  std::set<std::string> taken;
  for (std::size_t m = 0; m < shot.meshes.size(); ++m) {
    const BakeMesh& mesh = shot.mesh(m);
    const auto positions = [&](std::size_t i) -> const auto& { return frames[i].positions[m]; };
    out.append("    def Mesh \"" + prim_name(mesh.name, taken) +
               "\" (\n        customData = {\n            string name = " + quoted(mesh.name) +
               "\n        }\n    )\n    {\n");
    write_samples(out, "float3[] extent", shot, [&](auto i) { return extent(positions(i)); });
    out.append(topology(mesh.rest));
    write_samples(out, "normal3f[] normals", shot,
                  [&](auto i) { return unit_normals(mesh, positions(i)); });
    out.append("        normal3f[] normals = " + tuples(unit_normals(mesh, mesh.rest.vertices)) +
               " (\n            interpolation = \"vertex\"\n        )\n");
    out.append("        uniform token orientation = \"rightHanded\"\n");
    write_samples(out, "point3f[] points", shot, positions);
    out.append("        point3f[] points = " + tuples(mesh.rest.vertices) + "\n");
    out.append("        uniform token subdivisionScheme = \"none\"\n");
    write_samples(out, "vector3f[] velocities", shot, [&](auto i) { return velocity[i][m]; });
    out.append("    }\n");
  }
  out.append("}\n");
  out.finish();
  return {{file}, "time codes are frame numbers; the default points are the rest pose"};
}

}  // namespace thew::tools
