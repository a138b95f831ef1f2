// SPDX-License-Identifier: Apache-2.0
// A cache read and drawn: read_cache BAKE.h5 OUT.svg
// Outlines of all meshes in the last frame, seen along -z: each triangle that faces the eye is
// filled, muscles red and all else grey. Prints the length of each muscle, frame by frame.
#include <thew/thew.h>

#include <algorithm>
#include <cstdio>
#include <fstream>

namespace {

void draw(const thew::Bake& bake, std::ostream& svg) {
  const thew::BakeContents& contents = bake.contents();
  const int frame = contents.frames.back();
  double low[2] = {1e30, 1e30}, high[2] = {-1e30, -1e30};
  std::string shapes;
  for (const thew::BakedMesh& mesh : contents.meshes) {
    const std::vector<double> x = bake.positions(mesh.name, frame);
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (i % 3 == 2) continue;  // z
      low[i % 3] = std::min(low[i % 3], x[i]);
      high[i % 3] = std::max(high[i % 3], x[i]);
    }
    std::string path;
    for (std::size_t t = 0; t < mesh.rest.triangles.size(); t += 3) {
      const double* p[3];
      for (std::size_t k = 0; k < 3; ++k) p[k] = &x[3 * mesh.rest.triangles[t + k]];
      const double area =
          (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]);
      if (area <= 0) continue;  // it faces away
      char text[200];
      std::snprintf(text, sizeof text, "M%.5f %.5fL%.5f %.5fL%.5f %.5fZ", p[0][0], -p[0][1],
                    p[1][0], -p[1][1], p[2][0], -p[2][1]);
      path += text;
    }
    const bool muscle = mesh.kind == thew::BakedMesh::Kind::kMuscle;
    shapes += std::string("<path fill=\"") + (muscle ? "#9e2921" : "#b8b2a8") +
              "\" fill-opacity=\"0.7\" d=\"" + path + "\"/>\n";
  }
  svg << "<svg xmlns=\"http://www.w3.org/2000/svg\" height=\"600\" viewBox=\"" << low[0] << ' '
      << -high[1] << ' ' << high[0] - low[0] << ' ' << high[1] - low[1] << "\">\n"
      << shapes << "</svg>\n";
}

void print_lengths(const thew::Bake& bake) {
  for (const std::string& name : bake.contents().measures) {
    if (name.rfind("length/", 0) != 0) continue;
    const std::vector<double> length = bake.measure(name);
    for (std::size_t i = 0; i < length.size(); ++i) {
      std::printf("%s %4d %6.1f mm %s\n", name.c_str() + 7, bake.contents().frames[i],
                  1e3 * length[i],
                  std::string(static_cast<std::size_t>(150 * length[i]), '=').c_str());
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return std::fprintf(stderr, "usage: read_cache BAKE.h5 OUT.svg\n"), 2;
  try {
    const thew::Bake bake(argv[1]);
    print_lengths(bake);
    std::ofstream svg(argv[2]);
    draw(bake, svg);
    if (svg.flush()) return 0;
    return std::fprintf(stderr, "%s: cannot be written\n", argv[2]), 1;
  } catch (const thew::Error& error) {
    return std::fprintf(stderr, "%s\n", error.what()), 1;
  }
}
