// SPDX-License-Identifier: Apache-2.0
#include "tools/base/obj_text.h"

#include <charconv>

namespace thew::tools {

std::string metres(double value) {
  char buffer[64];
  const auto end =
      std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, 9);
  std::string text(buffer, end.ptr);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

std::string metres(const Vec3& p, const char* between) {
  return metres(p.x()) + between + metres(p.y()) + between + metres(p.z());
}

TriMesh in_order_of_use(const TriMesh& mesh) {
  TriMesh out;
  std::vector<int> index(mesh.vertices.size(), -1);
  for (Triangle t : mesh.triangles) {
    for (int& i : t) {
      if (index[i] < 0) {
        index[i] = static_cast<int>(out.vertices.size());
        out.vertices.push_back(mesh.vertices[i]);
      }
      i = index[i];
    }
    out.triangles.push_back(t);
  }
  return out;
}

std::string obj_text(const std::string& what, const TriMesh& mesh, const Vec3& shift) {
  std::string text = "# " + what + "\n";
  for (const Vec3& p : mesh.vertices) text += "v " + metres(p + shift, " ") + "\n";
  for (const Triangle& t : mesh.triangles) {
    text += "f";
    for (int corner : t) text += " " + std::to_string(corner + 1);
    text += "\n";
  }
  return text;
}

}  // namespace thew::tools
