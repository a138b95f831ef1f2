// SPDX-License-Identifier: Apache-2.0
#include "skin/sides.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "skin/depth.h"

namespace thew::skin {
namespace {

int root_of(std::vector<int>& parent, int node) {
  while (parent[node] != node) node = parent[node] = parent[parent[node]];
  return node;
}

void join(std::vector<int>& parent, int a, int b) {
  const int one = root_of(parent, a), two = root_of(parent, b);
  parent[std::max(one, two)] = std::min(one, two);
}

// By node, a way to the root of its piece, for root_of().
std::vector<int> joined_by(const std::vector<Triangle>& triangles, size_t nodes) {
  std::vector<int> parent(nodes);
  std::iota(parent.begin(), parent.end(), 0);
  for (const Triangle& t : triangles) {
    join(parent, t[0], t[1]);
    join(parent, t[1], t[2]);
  }
  return parent;
}

// Edges that the triangles around them do not run along equally often in both directions. Triangles
// from these edges to one node close the surface.
std::vector<std::array<int, 2>> open_edges(const Surface& surface) {
  std::vector<std::array<int, 3>> sides;  // both nodes, the lower first, and the direction
  sides.reserve(3 * surface.triangles.size());
  for (const Triangle& t : surface.triangles) {
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      sides.push_back({std::min(a, b), std::max(a, b), a < b ? 1 : -1});
    }
  }
  std::sort(sides.begin(), sides.end());
  std::vector<std::array<int, 2>> open;
  for (size_t i = 0, end = 0; i < sides.size(); i = end) {
    int sum = 0;
    for (; end < sides.size() && sides[end][0] == sides[i][0] && sides[end][1] == sides[i][1];) {
      sum += sides[end++][2];
    }
    if (sum != 0) open.push_back({sides[i][0], sides[i][1]});
  }
  return open;
}

NodeBox box_of(const Bvh::Node& node) {
  NodeBox box;
  box.low = Point{node.lo[0], node.lo[1], node.lo[2], 0.0};
  box.high = Point{node.hi[0], node.hi[1], node.hi[2], 0.0};
  return box;
}

// Triangles of leaves that meet a box, in addition to those that are there.
void add_triangles_in(const Bvh& bvh, const NodeBox& box, std::vector<int>& triangles) {
  constexpr int kStack = 192;  // see kStack in bvh.cpp
  int stack[kStack], top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Bvh::Node& node = bvh.nodes[stack[--top]];
    if (!are_near(box_of(node), box, 0.0)) continue;
    triangles.insert(triangles.end(), bvh.order.begin() + node.first,
                     bvh.order.begin() + node.first + node.count);
    if (node.count > 0) continue;
    stack[top++] = node.first;
    stack[top++] = node.first + 1;
  }
}

enum class Side : char { kAlone, kUnknown, kInside, kOutside };

// The nodes of `body` on one side of `of`, and the largest distance of them.
class Search {
 public:
  Search(const PlacedShell& body, const PlacedShell& of, bool inside)
      : body_(body), of_(of), inside_(inside) {
    for (const std::vector<int>& rim : of.shell->rims) {
      NodeBox box = empty_box();
      for (const int node : rim) grow(box, (*of.x)[node], (*of.x)[node]);
      rims_.push_back(box);
    }
  }

  double result() const { return most_; }

  // No triangle of the body is near the surface.
  void add_pieces() {
    const Shell& shell = *body_.shell;
    const bool sees = sees_rim(box_of(body_.bvh->nodes[0]));
    for (int piece = 0; piece < static_cast<int>(shell.pieces.size()); ++piece) {
      Side side = sees ? Side::kUnknown : side_of_node(shell.pieces[piece]);
      if (side == (inside_ ? Side::kOutside : Side::kInside)) continue;
      for (int i = 0; i < nodes(); ++i) {
        if (shell.piece_of[i] == piece) add(i, side);
      }
    }
  }

  // What blocked triangles of the body connect may be on both sides.
  void add_groups(const std::vector<char>& blocked) {
    const std::vector<Triangle>& triangles = body_.surface->triangles;
    thread_local std::vector<int> within, parent;
    thread_local std::vector<Side> side;
    within.clear();
    if (inside_) {  // no other node can be
      add_triangles_in(*body_.bvh, box_of(of_.bvh->nodes[0]), within);
    } else {
      within.resize(triangles.size());
      std::iota(within.begin(), within.end(), 0);
    }
    constexpr int kNone = -1;
    parent.assign(nodes(), kNone);
    side.assign(nodes(), Side::kAlone);
    for (const int t : within) {
      for (const int i : triangles[t]) {
        if (parent[i] == kNone) parent[i] = i;
        if (!blocked[t]) side[i] = Side::kUnknown;
      }
      if (blocked[t]) continue;
      join(parent, triangles[t][0], triangles[t][1]);
      join(parent, triangles[t][1], triangles[t][2]);
    }
    for (int i = 0; i < nodes(); ++i) {
      if (parent[i] != kNone) add(i, side[root_of(parent, i)]);
    }
  }

  void add_loose() {
    for (const int i : body_.shell->loose) {
      Side alone = Side::kAlone;
      add(i, alone);
    }
  }

  void block_at_rims(std::vector<char>& blocked) const {
    thread_local std::vector<int> triangles;
    triangles.clear();
    for (const NodeBox& rim : rims_) add_triangles_in(*body_.bvh, rim, triangles);
    for (const int t : triangles) blocked[t] = 1;
  }

 private:
  int nodes() const { return static_cast<int>(body_.x->size()); }
  Vec3 at(int node) const { return to_vec((*body_.x)[node]); }

  // Whether a ray along x, y or z from the box meets the box of a rim.
  bool sees_rim(const NodeBox& from) const {
    return std::any_of(rims_.begin(), rims_.end(), [&](const NodeBox& rim) {
      for (int axis = 0; axis < 3; ++axis) {
        NodeBox beam = from;
        beam.high[axis] = std::numeric_limits<double>::infinity();
        if (are_near(beam, rim, 0.0)) return true;
      }
      return false;
    });
  }

  Side side_of_node(int node) const {
    return encloses(*of_.surface, *of_.bvh, *of_.x, at(node)) ? Side::kInside : Side::kOutside;
  }

  // A node of a group of whose side is known what `of_group` says. All rays that see no rim count
  // the same in a group, so that one is enough.
  void add(int node, Side& of_group) {
    if (body_.counted && !(*body_.counted)[node]) return;
    const Point& p = (*body_.x)[node];
    Side side = Side::kOutside;
    if (!(box_distance(*of_.bvh, p) > 0.0)) {
      if (of_group == Side::kAlone || sees_rim(NodeBox{p, p})) {
        side = side_of_node(node);
      } else {
        if (of_group == Side::kUnknown) {
          of_group = ray_count(*of_.surface, *of_.bvh, *of_.x, at(node)) != 0 ? Side::kInside
                                                                              : Side::kOutside;
        }
        side = of_group;
      }
    }
    if ((side == Side::kInside) == inside_) raise(node);
  }

  void raise(int node) {
    constexpr double kAnywhere = std::numeric_limits<double>::infinity();
    const Vec3 p = at(node);
    // The distance from any triangle is a bound.
    if (hint_ >= 0 &&
        std::abs(closest_on_triangle(*of_.surface, *of_.x, hint_, p).distance) <= most_) {
      return;
    }
    const ClosestPoint near = closest_point(*of_.surface, *of_.bvh, *of_.x, p, kAnywhere, hint_);
    hint_ = near.triangle;
    most_ = std::max(most_, std::abs(near.distance));
  }

  const PlacedShell &body_, &of_;
  const bool inside_;
  std::vector<NodeBox> rims_;
  int hint_ = -1;  // the triangle that was nearest last
  double most_ = 0.0;
};

double farthest(const PlacedShell& body, const PlacedShell& of,
                const std::vector<std::array<int, 2>>& near, int column, bool inside) {
  if (of.bvh->order.empty()) return 0.0;
  Search search(body, of, inside);
  search.add_loose();
  if (body.bvh->order.empty()) return search.result();
  if (inside && !are_near(box_of(body.bvh->nodes[0]), box_of(of.bvh->nodes[0]), 0.0)) {
    return search.result();
  }
  thread_local std::vector<char> blocked;
  blocked.assign(body.surface->triangles.size(), 0);
  for (const std::array<int, 2>& pair : near) blocked[pair[column]] = 1;
  search.block_at_rims(blocked);
  if (std::find(blocked.begin(), blocked.end(), 1) == blocked.end()) {
    search.add_pieces();
  } else {
    search.add_groups(blocked);
  }
  return search.result();
}

Surface piece_surface(const Surface& surface, const Shell& shell, int piece) {
  Surface out;
  for (const Triangle& t : surface.triangles) {
    if (shell.piece_of[t[0]] == piece) out.triangles.push_back(t);
  }
  return out;
}

}  // namespace

Shell make_shell(const Surface& surface, int nodes) {
  Shell shell;
  std::vector<int> parent = joined_by(surface.triangles, nodes);
  shell.piece_of.assign(nodes, -1);
  for (int i = 0; i < nodes; ++i) {
    const int root = root_of(parent, i);  // the lowest node of its piece
    if (root != i) {
      shell.piece_of[i] = shell.piece_of[root];
    } else if (surface.vertex_triangles[i].empty()) {
      shell.loose.push_back(i);
    } else {
      shell.piece_of[i] = static_cast<int>(shell.pieces.size());
      shell.pieces.push_back(i);
    }
  }
  const std::vector<std::array<int, 2>> open = open_edges(surface);
  std::iota(parent.begin(), parent.end(), 0);
  for (const auto& [a, b] : open) join(parent, a, b);
  std::vector<int> rim_of(nodes, -1);
  for (const auto& edge : open) {
    for (const int i : edge) {
      int& rim = rim_of[root_of(parent, i)];
      if (rim < 0) {
        rim = static_cast<int>(shell.rims.size());
        shell.rims.emplace_back();
      }
      shell.rims[rim].push_back(i);
    }
  }
  return shell;
}

std::vector<Triangle> turned_outwards(const std::vector<Vec3>& x, std::vector<Triangle> triangles) {
  constexpr double kSheet = 0.05;  // of a ball's volume of the same area; a limb has half of it
  constexpr double kBall = 0.094;  // volume of a ball over its area to the power of 1.5
  std::vector<int> parent = joined_by(triangles, x.size());
  std::vector<double> volume(x.size(), 0.0), area(x.size(), 0.0);  // by piece, at its root
  for (const Triangle& t : triangles) {
    const int root = root_of(parent, t[0]);
    const Vec3 a = x[t[0]] - x[root], b = x[t[1]] - x[root], c = x[t[2]] - x[root];
    volume[root] += a.dot(b.cross(c)) / 6.0;
    area[root] += 0.5 * (b - a).cross(c - a).norm();
  }
  for (Triangle& t : triangles) {
    const int root = root_of(parent, t[0]);
    if (volume[root] < -kSheet * kBall * area[root] * std::sqrt(area[root])) std::swap(t[1], t[2]);
  }
  return triangles;
}

std::vector<char> find_doubled(const std::vector<Triangle>& triangles) {
  std::set<Triangle> known;
  std::vector<char> doubled;
  for (Triangle t : triangles) {
    std::sort(t.begin(), t.end());
    doubled.push_back(!known.insert(t).second);
  }
  return doubled;
}

bool bends(const Surface& piece, const Points& x, const std::vector<Span>& spans) {
  int begun = 0, whole = 0;
  for (const Span& span : spans) {
    const int ends = static_cast<int>(std::count_if(span.begin(), span.end(), [&](const Vec3& p) {
      return winding_number(piece, x, p) > 0.5;
    }));
    begun += ends > 0;
    whole += ends == 2;
  }
  return whole > 0 && 4 * whole >= 3 * begun;
}

std::vector<char> find_hard(const Surface& surface, const Points& rest, const Shell& shell,
                            const std::vector<char>& near, const std::vector<Span>& spans) {
  const Bvh bvh = build_bvh(surface, rest);
  const std::vector<int>& piece = shell.piece_of;
  std::vector<char> is_hard(rest.size(), 0), hard(rest.size(), 0);  // by piece, by node
  for (const auto& [a, b] : crossing_triangles(surface, bvh, rest, surface, bvh, rest)) {
    const int at_a = surface.triangles[a][0], at_b = surface.triangles[b][0];
    if (near[at_a] && near[at_b] && piece[at_a] != piece[at_b]) {
      is_hard[piece[at_a]] = is_hard[piece[at_b]] = 1;
    }
  }
  for (size_t p = 0; p < shell.pieces.size(); ++p) {
    if (is_hard[p] && bends(piece_surface(surface, shell, static_cast<int>(p)), rest, spans)) {
      is_hard[p] = 0;
    }
  }
  for (size_t i = 0; i < hard.size(); ++i) hard[i] = piece[i] >= 0 && is_hard[piece[i]];
  return hard;
}

double deepest_inside(const PlacedShell& body, const PlacedShell& of,
                      const std::vector<std::array<int, 2>>& near, int column) {
  return farthest(body, of, near, column, true);
}

double farthest_outside(const PlacedShell& body, const PlacedShell& of,
                        const std::vector<std::array<int, 2>>& near, int column) {
  return farthest(body, of, near, column, false);
}

}  // namespace thew::skin
