// SPDX-License-Identifier: Apache-2.0
#include "tools/inspect/repair.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "rig/import/mesh_import.h"
#include "rig/text.h"
#include "sim/cache/durable_file.h"
#include "tools/base/obj_text.h"

namespace thew::tools {
namespace {

constexpr double kNear = 1e-6;      // of the extent
constexpr size_t kLargestHole = 8;  // edges

using Edge = std::pair<int, int>;
Edge edge_of(const Triangle& t, int k) { return {t[k], t[(k + 1) % 3]}; }
Edge sorted(const Edge& e) { return {std::min(e.first, e.second), std::max(e.first, e.second)}; }

// Triangles at each edge.
std::map<Edge, std::vector<int>> edges_of(const TriMesh& mesh) {
  std::map<Edge, std::vector<int>> edges;
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      edges[sorted(edge_of(mesh.triangles[t], k))].push_back(static_cast<int>(t));
    }
  }
  return edges;
}

double extent_of(const TriMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Vec3& p : mesh.vertices) box.extend(p);
  return box.isEmpty() ? 0.0 : box.sizes().maxCoeff();
}

std::string count_text(size_t count, const char* what) {
  return std::to_string(count) + " " + what;
}

// Vertices at open edges that lie as good as at one place.
void join_near(TriMesh& mesh, std::vector<std::string>& done) {
  std::set<int> open;
  for (const auto& [edge, triangles] : edges_of(mesh)) {
    if (triangles.size() == 1) open.insert({edge.first, edge.second});
  }
  std::vector<int> order(open.begin(), open.end());
  const auto x = [&](int i) { return mesh.vertices[i].x(); };
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return x(a) < x(b); });
  const double near = kNear * extent_of(mesh);
  std::vector<int> into(mesh.vertices.size());
  std::iota(into.begin(), into.end(), 0);
  size_t joined = 0;
  for (size_t i = 0; i < order.size(); ++i) {
    if (into[order[i]] != order[i]) continue;
    for (size_t k = i + 1; k < order.size() && x(order[k]) - x(order[i]) <= near; ++k) {
      const bool same = (mesh.vertices[order[k]] - mesh.vertices[order[i]]).norm() <= near;
      if (!same || into[order[k]] != order[k]) continue;
      into[order[k]] = order[i];
      ++joined;
    }
  }
  if (joined == 0) return;
  for (Triangle& t : mesh.triangles) {
    for (int& i : t) i = into[i];
  }
  done.push_back("joined " + count_text(joined, "vertices with others within ") +
                 number_text(near) + " m");
}

void drop_bad_triangles(TriMesh& mesh, std::vector<std::string>& done) {
  std::set<Triangle> seen;
  std::vector<Triangle> kept;
  size_t flat = 0, twice = 0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const bool point = t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
    const double longest =
        std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
    // A flat one that joins three places holds its neighbours together: it stays and is reported.
    if (point || longest == 0.0) {
      ++flat;
      continue;
    }
    Triangle key = t;
    std::sort(key.begin(), key.end());
    if (seen.insert(key).second) {
      kept.push_back(t);
    } else {
      ++twice;
    }
  }
  if (flat > 0) done.push_back("dropped " + count_text(flat, "triangles without area"));
  if (twice > 0) done.push_back("dropped " + count_text(twice, "triangles that were there twice"));
  mesh.triangles = std::move(kept);
}

// Loops of open edges, each the way round in which a lid would go.
std::vector<std::vector<int>> holes_of(const TriMesh& mesh) {
  std::map<int, std::vector<int>> next;
  for (const auto& [edge, triangles] : edges_of(mesh)) {
    if (triangles.size() != 1) continue;
    const Triangle& t = mesh.triangles[triangles[0]];
    for (int k = 0; k < 3; ++k) {
      const Edge e = edge_of(t, k);
      if (sorted(e) == edge) next[e.second].push_back(e.first);
    }
  }
  std::vector<std::vector<int>> holes;
  std::set<int> used;
  for (const auto& [start, unused] : next) {
    std::vector<int> loop;
    int at = start;
    while (next.count(at) && next[at].size() == 1 && used.insert(at).second) {
      loop.push_back(at);
      at = next[at][0];
    }
    if (at == start && loop.size() >= 3) holes.push_back(loop);
  }
  return holes;
}

void fill_holes(TriMesh& mesh, std::vector<std::string>& done) {
  for (const std::vector<int>& hole : holes_of(mesh)) {
    const std::string where = point_text(mesh.vertices[hole[0]]);
    if (hole.size() > kLargestHole) continue;
    const auto edges = edges_of(mesh);
    bool free = true;  // no side of the fan is an edge already
    for (size_t k = 2; k + 1 < hole.size(); ++k) {
      free = free && edges.count(sorted({hole[0], hole[k]})) == 0;
    }
    if (!free) continue;
    for (size_t k = 1; k + 1 < hole.size(); ++k) {
      mesh.triangles.push_back({hole[0], hole[k], hole[k + 1]});
    }
    done.push_back("filled a hole of " + count_text(hole.size(), "edges at ") + where);
  }
}

// One winding in each part; closed parts outward.
void orient(TriMesh& mesh, std::vector<std::string>& done) {
  const auto edges = edges_of(mesh);
  std::vector<int> part(mesh.triangles.size(), -1);
  size_t turned = 0, inside_out = 0;
  for (size_t first = 0; first < part.size(); ++first) {
    if (part[first] >= 0) continue;
    std::vector<int> members = {static_cast<int>(first)};
    part[first] = static_cast<int>(first);
    std::vector<char> flipped(1, 0);
    bool closed = true;
    for (size_t m = 0; m < members.size(); ++m) {
      for (int k = 0; k < 3; ++k) {
        const Edge e = edge_of(mesh.triangles[members[m]], k);
        const std::vector<int>& beside = edges.at(sorted(e));
        closed = closed && beside.size() == 2;
        if (beside.size() != 2) continue;
        const int other = beside[0] == members[m] ? beside[1] : beside[0];
        if (part[other] >= 0) continue;
        Triangle& t = mesh.triangles[other];
        bool same = false;
        for (int j = 0; j < 3; ++j) same = same || edge_of(t, j) == e;
        if (same) std::swap(t[1], t[2]);
        flipped.push_back(same);
        part[other] = static_cast<int>(first);
        members.push_back(other);
      }
    }
    TriMesh alone{mesh.vertices, {}};
    for (int m : members) alone.triangles.push_back(mesh.triangles[m]);
    const bool inverted = closed && enclosed_volume(alone) < 0.0;
    const size_t others = std::count(flipped.begin(), flipped.end(), 1);
    for (int m : members) {
      if (inverted) std::swap(mesh.triangles[m][1], mesh.triangles[m][2]);
    }
    if (inverted && others == 0) {
      ++inside_out;
    } else {
      turned += inverted ? members.size() - others : others;
    }
  }
  if (turned > 0) done.push_back("turned " + count_text(turned, "triangles to one winding"));
  if (inside_out > 0) done.push_back("turned " + count_text(inside_out, "parts outward"));
}

void drop_loose_vertices(TriMesh& mesh, std::vector<std::string>& done) {
  std::vector<int> index(mesh.vertices.size(), -1);
  for (const Triangle& t : mesh.triangles) {
    for (int i : t) index[i] = 0;
  }
  std::vector<Vec3> kept;
  for (size_t i = 0; i < index.size(); ++i) {
    if (index[i] < 0) continue;
    index[i] = static_cast<int>(kept.size());
    kept.push_back(mesh.vertices[i]);
  }
  const size_t loose = mesh.vertices.size() - kept.size();
  if (loose == 0) return;
  for (Triangle& t : mesh.triangles) {
    for (int& i : t) i = index[i];
  }
  mesh.vertices = std::move(kept);
  done.push_back("dropped " + count_text(loose, "vertices in no triangle"));
}

}  // namespace

std::vector<std::string> repair(TriMesh& mesh) {
  std::vector<std::string> done;
  join_near(mesh, done);
  drop_bad_triangles(mesh, done);
  orient(mesh, done);  // so that each hole has one way round
  fill_holes(mesh, done);
  orient(mesh, done);  // what is closed now can be told from inside out
  drop_loose_vertices(mesh, done);
  return done;
}

std::vector<std::string> repair_file(const std::filesystem::path& file,
                                     const std::filesystem::path& out, bool overwrite) {
  if (out.extension() != ".obj") {
    throw Error(ErrorCode::kUsage, out.string() +
                                       ": repaired meshes are written as OBJ; give "
                                       "--repair OUT.obj");
  }
  std::error_code none;
  if (std::filesystem::equivalent(file, out, none)) {
    throw Error(ErrorCode::kUsage, out.string() + ": is " + file.string() +
                                       " itself, which stays as it is; give --repair another name");
  }
  claim({out}, overwrite);
  ImportedMesh imported = import_mesh(file);
  std::vector<std::string> done;
  const int joined = imported.imported_vertices - static_cast<int>(imported.mesh.vertices.size());
  if (joined > 0) done.push_back("joined " + count_text(joined, "vertices at equal places"));
  for (std::string& line : repair(imported.mesh)) done.push_back(std::move(line));
  write_durably(out,
                obj_text(file.filename().string() + ", repaired", imported.mesh, Vec3::Zero()));
  return done;
}

}  // namespace thew::tools
