// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <tuple>

#include "rig/mesh.h"
#include "rig/text.h"

namespace thew::rig {
namespace {

// Least height of a triangle over its longest edge [1]: rounding to float32 (6e-8 of a coordinate)
// makes such a triangle out of a line.
constexpr double kFlat = 1e-7;

class Partition {  // union-find; a set is named by its smallest member
 public:
  explicit Partition(size_t size) : parent_(size) { std::iota(parent_.begin(), parent_.end(), 0); }
  int find(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void unite(int i, int j) {
    i = find(i);
    j = find(j);
    parent_[std::max(i, j)] = std::min(i, j);
  }

 private:
  std::vector<int> parent_;
};

// Corner c is the (c mod 3)-th of triangle c / 3; its half-edge runs to the triangle's next corner.
struct HalfEdge {
  int low, high;  // vertices
  int corner;
  bool forward;  // from low to high
};

// Data that the checks share. Edges and components leave out triangles that name a vertex twice.
struct Surface {
  const TriMesh& mesh;
  std::vector<HalfEdge> edges;  // sorted by low, high, corner
  std::vector<int> component;   // per vertex, numbered by first vertex; -1: in no triangle
  int components = 0;
  std::vector<bool> closed;  // per component: each edge has two triangles of one winding

  int vertex(int corner) const { return mesh.triangles[corner / 3][corner % 3]; }
};

bool is_degenerate(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

int next_corner(int corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; }

std::vector<HalfEdge> sorted_half_edges(const TriMesh& mesh) {
  std::vector<HalfEdge> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (int t = 0; t < static_cast<int>(mesh.triangles.size()); ++t) {
    const Triangle& v = mesh.triangles[t];
    if (is_degenerate(v)) continue;
    for (int k = 0; k < 3; ++k) {
      const int a = v[k], b = v[(k + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), 3 * t + k, a < b});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return std::tie(a.low, a.high, a.corner) < std::tie(b.low, b.high, b.corner);
  });
  return edges;
}

void find_components(Surface& surface) {
  Partition partition(surface.mesh.vertices.size());
  std::vector<bool> used(surface.mesh.vertices.size(), false);
  for (const HalfEdge& e : surface.edges) {
    partition.unite(e.low, e.high);
    used[e.low] = used[e.high] = true;
  }
  surface.component.assign(used.size(), -1);
  for (int v = 0; v < static_cast<int>(used.size()); ++v) {
    if (!used[v]) continue;
    const int first = partition.find(v);  // first <= v
    surface.component[v] = first == v ? surface.components++ : surface.component[first];
  }
  surface.closed.assign(surface.components, true);
}

// One defect per kind: the count, and the text of the first.
using Defects = std::vector<Defect>;

void report(Defects& defects, Defect::Kind kind, const char* fix,
            const std::function<std::string()>& where) {
  for (Defect& d : defects) {
    if (d.kind == kind) {
      ++d.count;
      return;
    }
  }
  defects.push_back({kind, 1, where(), fix});
}

std::string component_text(const Surface& s, int vertex) {
  if (s.components < 2 || s.component[vertex] < 0) return "";
  return "component " + std::to_string(s.component[vertex] + 1) + " of " +
         std::to_string(s.components) + ", ";
}

std::string vertex_text(const TriMesh& mesh, int v) {
  return "vertex " + std::to_string(v) + " at " + point_text(mesh.vertices[v]);
}

std::string edge_text(const Surface& s, const HalfEdge& e) {
  const Vec3 middle = 0.5 * (s.mesh.vertices[e.low] + s.mesh.vertices[e.high]);
  return component_text(s, e.low) + "edge " + std::to_string(e.low) + "-" + std::to_string(e.high) +
         " at " + point_text(middle);
}

void check_numbers(const TriMesh& mesh, Defects& defects) {
  for (int v = 0; v < static_cast<int>(mesh.vertices.size()); ++v) {
    if (mesh.vertices[v].allFinite()) continue;
    report(defects, Defect::kNotFinite, "export the mesh again or delete these vertices",
           [&] { return vertex_text(mesh, v); });
  }
  const int count = static_cast<int>(mesh.vertices.size());
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int v : mesh.triangles[t]) {
      if (v >= 0 && v < count) continue;
      report(defects, Defect::kIndexOutOfRange, "export the mesh again", [&] {
        return "triangle " + std::to_string(t) + " names vertex " + std::to_string(v) + " of " +
               std::to_string(count);
      });
    }
  }
}

// Checks the half-edges from first to last, which share one edge. Also unites the corners that the
// edge joins in `fans`, and records in s.closed which components are open.
void check_edge(Surface& s, const HalfEdge* first, const HalfEdge* last, Partition& fans,
                Defects& defects) {
  const auto where = [&] { return edge_text(s, *first); };
  const auto count = last - first;
  if (count == 1) {
    report(defects, Defect::kOpenEdge, "close the holes (in Blender: Mesh > Clean Up > Fill Holes)",
           where);
  } else if (count > 2) {
    report(defects, Defect::kNonManifoldEdge,
           "delete inner faces so that two triangles meet at each edge", where);
  } else if (first[0].forward == first[1].forward) {
    report(defects, Defect::kInconsistentWinding,
           "make the normals consistent (in Blender: Mesh > Normals > Recalculate Outside)", where);
  }
  if (count != 2 || first[0].forward == first[1].forward) {
    s.closed[s.component[first->low]] = false;
  }
  for (const HalfEdge* e = first + 1; e != last; ++e) {
    const int ends[2] = {e->corner, next_corner(e->corner)};
    const int firsts[2] = {first->corner, next_corner(first->corner)};
    const bool same = e->forward == first->forward;
    fans.unite(ends[0], firsts[same ? 0 : 1]);
    fans.unite(ends[1], firsts[same ? 1 : 0]);
  }
}

// The triangles around a vertex must form one fan: all its corners joined through edges.
void check_fans(const Surface& s, Partition& fans, Defects& defects) {
  std::vector<int> fan_at(s.mesh.vertices.size(), -1);
  std::vector<bool> reported(s.mesh.vertices.size(), false);
  for (int corner = 0; corner < static_cast<int>(3 * s.mesh.triangles.size()); ++corner) {
    if (is_degenerate(s.mesh.triangles[corner / 3])) continue;
    const int v = s.vertex(corner), fan = fans.find(corner);
    if (fan_at[v] == -1) fan_at[v] = fan;
    if (fan_at[v] == fan || reported[v]) continue;
    reported[v] = true;
    report(defects, Defect::kNonManifoldVertex,
           "split the vertex so that its triangles form one fan",
           [&] { return component_text(s, v) + vertex_text(s.mesh, v); });
  }
}

void check_triangles(const Surface& s, Defects& defects) {
  for (size_t t = 0; t < s.mesh.triangles.size(); ++t) {
    const Triangle& v = s.mesh.triangles[t];
    const Vec3 &a = s.mesh.vertices[v[0]], &b = s.mesh.vertices[v[1]], &c = s.mesh.vertices[v[2]];
    const double longest =
        std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
    if ((b - a).cross(c - a).norm() > kFlat * longest) continue;
    report(defects, Defect::kZeroArea, "dissolve degenerate triangles or merge near vertices", [&] {
      return component_text(s, v[0]) + "triangle " + std::to_string(t) + " at " +
             point_text((a + b + c) / 3.0);
    });
  }
}

void check_components(const Surface& s, Defects& defects) {
  std::vector<int> origin(s.components,
                          -1);  // a vertex of each, relative to which its volume is summed
  std::vector<double> volume(s.components, 0.0);
  for (const Triangle& t : s.mesh.triangles) {
    if (is_degenerate(t)) continue;
    const int i = s.component[t[0]];
    if (origin[i] < 0) origin[i] = t[0];
    const Vec3& o = s.mesh.vertices[origin[i]];
    const Vec3 a = s.mesh.vertices[t[0]] - o, b = s.mesh.vertices[t[1]] - o;
    volume[i] += a.dot(b.cross(s.mesh.vertices[t[2]] - o)) / 6.0;
  }
  const auto where = [&](int i) {
    return component_text(s, origin[i]) + vertex_text(s.mesh, origin[i]);
  };
  for (int i = 0; i < s.components; ++i) {
    if (s.components > 1) {
      report(defects, Defect::kSeveralComponents,
             "keep one closed surface per file, or merge vertices at seams",
             [&] { return where(1); });
    }
    if (!s.closed[i] || volume[i] >= 0.0) continue;  // the volume of an open surface says nothing
    report(defects, Defect::kInsideOut,
           "flip the normals (in Blender: Mesh > Normals > Recalculate Outside)",
           [&] { return where(i) + ", volume " + number_text(volume[i]) + " m^3"; });
  }
}

struct Unit {
  const char* name;
  double metres;
};

void check_scale(const TriMesh& mesh, const ScaleRange& range, Defects& defects) {
  Eigen::AlignedBox3d box;
  for (const Vec3& p : mesh.vertices) box.extend(p);
  const Vec3 size = box.isEmpty() ? Vec3::Zero() : Vec3(box.sizes());
  const double extent = size.maxCoeff();
  if (extent >= range.smallest && extent <= range.largest) return;
  const char* axis[3] = {"wide (x)", "tall (y)", "deep (z)"};
  int longest = 0;
  size.maxCoeff(&longest);
  std::string where = number_text(extent) + " m " + axis[longest];
  std::string fix = "scale the mesh to metres";
  const double middle = std::sqrt(range.smallest * range.largest);
  double best = range.largest /
                middle;  // the likeliest unit gives the extent nearest to the middle of the range
  for (const Unit& unit : {Unit{"millimetres", 1e-3}, Unit{"centimetres", 1e-2},
                           Unit{"a mesh scaled from millimetres twice", 1e3}}) {
    const double guess = extent * unit.metres;
    const double oddness = std::max(guess / middle, middle / guess);
    if (extent <= 0.0 || oddness > best) continue;
    best = oddness;
    where =
        std::string("looks like ") + unit.name + ": " + number_text(extent) + " m " + axis[longest];
    fix = "scale the mesh to metres: times " + number_text(unit.metres);
  }
  defects.push_back({Defect::kWrongScale, 1, where, fix});
}

}  // namespace

const char* defect_name(Defect::Kind kind) {
  switch (kind) {
    case Defect::kNotFinite:
      return "vertices not finite";
    case Defect::kIndexOutOfRange:
      return "indices out of range";
    case Defect::kOpenEdge:
      return "open edges";
    case Defect::kNonManifoldEdge:
      return "edges of more than two triangles";
    case Defect::kNonManifoldVertex:
      return "non-manifold vertices";
    case Defect::kInconsistentWinding:
      return "edges of inconsistent winding";
    case Defect::kInsideOut:
      return "components inside out";
    case Defect::kZeroArea:
      return "triangles without area";
    case Defect::kSeveralComponents:
      return "components where one is wanted";
    case Defect::kWrongScale:
      return "wrong scale";
    case Defect::kUnusedVertex:
      return "vertices in no triangle";
  }
  return "unknown defect";
}

std::vector<Defect> find_defects(const TriMesh& mesh, const ScaleRange& scale) {
  Defects defects;
  check_numbers(mesh, defects);
  if (!defects.empty()) return defects;  // nothing further can be said of such a mesh
  Surface surface{mesh, sorted_half_edges(mesh), {}, 0, {}};
  find_components(surface);
  Partition fans(3 * mesh.triangles.size());
  const HalfEdge* const end = surface.edges.data() + surface.edges.size();
  for (const HalfEdge* first = surface.edges.data(); first != end;) {
    const HalfEdge* last = first + 1;
    while (last != end && last->low == first->low && last->high == first->high) ++last;
    check_edge(surface, first, last, fans, defects);
    first = last;
  }
  check_fans(surface, fans, defects);
  check_triangles(surface, defects);
  check_components(surface, defects);
  for (int v = 0; v < static_cast<int>(mesh.vertices.size()); ++v) {
    if (surface.component[v] >= 0) continue;
    report(defects, Defect::kUnusedVertex, "delete loose vertices",
           [&] { return vertex_text(mesh, v); });
  }
  check_scale(mesh, scale, defects);
  std::stable_sort(defects.begin(), defects.end(),
                   [](const Defect& a, const Defect& b) { return a.kind < b.kind; });
  return defects;
}

}  // namespace thew::rig
