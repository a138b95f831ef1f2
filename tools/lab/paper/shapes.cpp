// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/paper/shapes.h"

#include <charconv>
#include <cmath>
#include <map>
#include <string>

#include "rig/math.h"
#include "sim/cache/durable_file.h"
#include "tools/base/obj_text.h"
#include "tools/lab/elements/delaunay.h"

namespace thew::tools {
namespace {

// A vertex per lattice point, so that faces of a cube share their edges.
struct Lattice {
  TriMesh mesh;
  std::map<std::array<int, 3>, int> index;
  int at(const std::array<int, 3>& key, double scale) {
    const auto [found, added] = index.try_emplace(key, static_cast<int>(mesh.vertices.size()));
    if (added) {
      mesh.vertices.push_back(scale * Vec3(key[0], key[1], key[2]) - Vec3::Constant(0.5));
    }
    return found->second;
  }
};

std::string places(double value) {
  char buffer[64];
  const auto end =
      std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::fixed, 7);
  return std::string(buffer, end.ptr);
}

}  // namespace

TriMesh paper_ball(int triangles) {
  const int n = triangles / 2 + 2;
  const double golden = kPi * (3.0 - std::sqrt(5.0));
  // The hull is the base of the tetrahedra from a point within.
  std::vector<Vec3> points = {{1e-3, 2e-3, 3e-3}};
  for (int i = 0; i < n; ++i) {
    const double y = 1.0 - (2.0 * i + 1.0) / n, r = std::sqrt(1.0 - y * y);
    const SinCos turn = sin_cos(golden * i);
    points.push_back({r * turn.cos, y, r * turn.sin});
  }
  TriMesh mesh{{points.begin() + 1, points.end()}, boundary(delaunay(points))};
  for (Triangle& t : mesh.triangles) {
    for (int& corner : t) --corner;
  }
  return mesh;
}

TriMesh ringed_ball(int rings, int around) {
  TriMesh mesh;
  mesh.vertices.push_back({0, 1, 0});
  for (int ring = 1; ring <= rings; ++ring) {
    const SinCos down = sin_cos(kPi * ring / (rings + 1));
    for (int k = 0; k < around; ++k) {
      const SinCos turn = sin_cos(2.0 * kPi * (k + 0.5 * (ring % 2)) / around);
      mesh.vertices.push_back({down.sin * turn.cos, down.cos, down.sin * turn.sin});
    }
  }
  mesh.vertices.push_back({0, -1, 0});
  const auto node = [&](int ring, int k) { return 1 + (ring - 1) * around + k % around; };
  const int last = static_cast<int>(mesh.vertices.size()) - 1;
  for (int k = 0; k < around; ++k) {
    mesh.triangles.push_back({0, node(1, k + 1), node(1, k)});
    mesh.triangles.push_back({last, node(rings, k), node(rings, k + 1)});
    for (int ring = 1; ring < rings; ++ring) {
      const int a = node(ring, k), b = node(ring, k + 1);
      const int c = node(ring + 1, k), d = node(ring + 1, k + 1);
      if (ring % 2) {  // odd rings stand half a step ahead
        mesh.triangles.push_back({a, d, c});
        mesh.triangles.push_back({a, b, d});
      } else {
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({b, d, c});
      }
    }
  }
  return mesh;
}

TriMesh rounded_plate(double length, double width, double thickness, double radius) {
  constexpr int kSteps = 12;
  std::vector<Vec3> rim = {{-length, 0, 0}};
  for (int i = 0; i <= kSteps; ++i) {
    const SinCos turn = sin_cos(0.5 * kPi * i / kSteps);
    rim.push_back({radius * turn.sin, radius * (1.0 - turn.cos), 0});
  }
  rim.push_back({radius, thickness, 0});
  rim.push_back({-length, thickness, 0});
  TriMesh mesh;
  const int n = static_cast<int>(rim.size());
  for (double z : {0.5 * width, -0.5 * width}) {
    for (const Vec3& p : rim) mesh.vertices.push_back(p + Vec3(0, 0, z));
  }
  for (int i = 0; i < n; ++i) {
    const int j = (i + 1) % n;
    mesh.triangles.push_back({i, n + i, n + j});
    mesh.triangles.push_back({i, n + j, j});
    if (i == 0 || j == 0) continue;
    mesh.triangles.push_back({0, i, j});
    mesh.triangles.push_back({n, n + j, n + i});
  }
  return mesh;
}

TriMesh paper_cube(int n, bool four) {
  Lattice lattice;  // of half squares
  const double scale = 0.5 / n;
  for (int axis = 0; axis < 3; ++axis) {
    for (int side : {0, 2 * n}) {
      for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
          const auto node = [&](int di, int dj) {
            std::array<int, 3> key;
            key[axis] = side;
            key[(axis + 1) % 3] = 2 * i + di;
            key[(axis + 2) % 3] = 2 * j + dj;
            return lattice.at(key, scale);
          };
          std::array<int, 4> q = {node(0, 0), node(2, 0), node(2, 2), node(0, 2)};
          if (side == 0) std::swap(q[1], q[3]);
          if (four) {
            const int centre = node(1, 1);
            for (int k = 0; k < 4; ++k) {
              lattice.mesh.triangles.push_back({q[k], q[(k + 1) % 4], centre});
            }
          } else if ((i + j) % 2) {
            lattice.mesh.triangles.push_back({q[0], q[1], q[2]});
            lattice.mesh.triangles.push_back({q[0], q[2], q[3]});
          } else {
            lattice.mesh.triangles.push_back({q[1], q[2], q[3]});
            lattice.mesh.triangles.push_back({q[1], q[3], q[0]});
          }
        }
      }
    }
  }
  return lattice.mesh;
}

TriMesh paper_torus(double radius, double tube, int around, int along) {
  TriMesh mesh;
  for (int i = 0; i < along; ++i) {
    const SinCos big = sin_cos(2.0 * kPi * i / along);
    for (int k = 0; k < around; ++k) {
      const SinCos small = sin_cos(2.0 * kPi * (k + 0.5 * (i % 2)) / around);
      const double r = radius + tube * small.cos;
      mesh.vertices.push_back({r * big.cos, tube * small.sin, r * big.sin});
    }
  }
  const auto node = [&](int i, int k) { return i % along * around + k % around; };
  for (int i = 0; i < along; ++i) {
    for (int k = 0; k < around; ++k) {
      const int a = node(i, k), b = node(i, k + 1), c = node(i + 1, k), d = node(i + 1, k + 1);
      if (i % 2) {
        mesh.triangles.push_back({a, d, c});
        mesh.triangles.push_back({a, b, d});
      } else {
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({b, d, c});
      }
    }
  }
  if (enclosed_volume(mesh) < 0.0) {
    for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  }
  return mesh;
}

std::string shape_text(const std::string& what, const TriMesh& shape) {
  const TriMesh mesh = in_order_of_use(shape);
  std::string text = "# " + what + ", metres; made by author_paper, Apache-2.0\n";
  for (const Vec3& p : mesh.vertices) {
    text += "v " + places(p.x()) + " " + places(p.y()) + " " + places(p.z()) + "\n";
  }
  for (const Triangle& t : mesh.triangles) {
    text += "f";
    for (int corner : t) text += " " + std::to_string(corner + 1);
    text += "\n";
  }
  return text;
}

void write_obj(const std::filesystem::path& file, const std::string& what, const TriMesh& shape) {
  replace_durably(file, shape_text(what, shape));
}

}  // namespace thew::tools
