// SPDX-License-Identifier: Apache-2.0
#include "tools/author/skin.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "rig/math.h"
#include "tools/author/bones.h"
#include "tools/author/hand.h"
#include "tools/author/level_grid.h"
#include "tools/author/outline.h"
#include "tools/author/remesh.h"
#include "tools/author/smoothing.h"

namespace thew::tools {
namespace {

constexpr double kCell = 0.0028;  // m, of the grid: half of the narrowest gap between fingers
constexpr double kFar = 0.025;    // m, beyond which no distance from what is below is asked for
constexpr double kCut = -0.058;   // m, z of the plane that cuts the chest

// Strokes from point to point (x, y, z) with the radius there, all m.
void add_chain(std::initializer_list<std::array<double, 4>> points, BoneShape& shape) {
  for (auto b = points.begin() + 1; b != points.end(); ++b) {
    const auto a = b - 1;
    shape.strokes.push_back(
        {{(*a)[0], (*a)[1], (*a)[2]}, {(*b)[0], (*b)[1], (*b)[2]}, (*a)[3], (*b)[3]});
  }
}

// Edges of pectoralis and of latissimus, and the chest behind the cut.
BoneShape chest() {
  BoneShape flesh{"", 0.020, {}, {}, {}};
  add_chain({{0.000, 0.008, -0.085, 0.0440}, {0.000, -0.035, -0.090, 0.0430}}, flesh);
  add_chain({{-0.006, 0.052, -0.100, 0.0300},
             {-0.004, 0.024, -0.040, 0.0260},
             {-0.002, 0.006, 0.000, 0.0260}},
            flesh);
  add_chain({{0.034, -0.010, -0.090, 0.0280},
             {0.026, -0.036, -0.045, 0.0190},
             {0.014, -0.080, -0.006, 0.0120}},
            flesh);
  add_chain({{-0.034, -0.035, -0.090, 0.0270},
             {-0.026, -0.048, -0.040, 0.0190},
             {-0.010, -0.085, -0.006, 0.0120}},
            flesh);
  return flesh;
}

// Distance from the nearest of the meshes; beyond kFar it is kFar.
LevelGrid distance_below(const std::vector<Measured>& below, const LevelGrid& like) {
  LevelGrid grid = like;
  std::fill(grid.level.begin(), grid.level.end(), kFar);
  for (const Measured& mesh : below) {
    const NodeBox box = box_of(mesh.x);
    std::array<int, 3> first, last;
    for (int a = 0; a < 3; ++a) {
      const auto cells = [&](double at) {
        return static_cast<int>((at - grid.low[a]) / grid.cell[a]);
      };
      first[a] = std::clamp(cells(box.low[a] - kFar), 0, grid.size[a] - 1);
      last[a] = std::clamp(cells(box.high[a] + kFar) + 1, 0, grid.size[a] - 1);
    }
    for (int k = first[2]; k <= last[2]; ++k) {
      for (int j = first[1]; j <= last[1]; ++j) {
        for (int i = first[0]; i <= last[0]; ++i) {
          double& level = grid.level[grid.index(i, j, k)];
          const ClosestPoint near =
              closest_point(mesh.surface, mesh.bvh, mesh.x, grid.point(i, j, k), kFar);
          if (near.triangle >= 0) level = std::min(level, near.distance);
        }
      }
    }
  }
  return grid;
}

// The hollows of a level filled as a membrane would that is drawn tight over it.
void draw_tight(LevelGrid& grid) {
  constexpr int kRounds = 9, kPasses = 3;  // of blur
  const std::vector<double> under = grid.level;
  for (int round = 0; round < kRounds; ++round) {
    blur(kPasses, grid);
    for (size_t i = 0; i < under.size(); ++i) grid.level[i] = std::min(grid.level[i], under[i]);
  }
}

// Skin over what is below and over the flesh; the hand keeps its fingers apart.
LevelGrid skin_level(const std::vector<Measured>& below, double clearance) {
  // m, over which the limb melts into what is below, the chest, the hand
  constexpr double kMelt = 0.008, kChest = 0.020, kWrist = 0.010;
  LevelGrid skin =
      empty_grid({-0.095, -0.745, kCut - 0.010}, {0.115, 0.080, 0.095}, Vec3::Constant(kCell));
  const LevelGrid distance = distance_below(below, skin);
  const BoneShape behind = chest();
  sample([&](const Vec3& p) { return melt(limb_level(p), bone_distance(behind, p), kChest); },
         skin);
  for (size_t i = 0; i < skin.level.size(); ++i) {
    skin.level[i] = melt(distance.level[i] - clearance, skin.level[i], kMelt);
  }
  for (int j = 0; skin.point(0, j, 0).y() < -0.600; ++j) {  // there the hand's own level counts
    for (int k = 0; k < skin.size[2]; ++k) {
      for (int i = 0; i < skin.size[0]; ++i) skin.level[skin.index(i, j, k)] = kFar;
    }
  }
  draw_tight(skin);
  for (int k = 0; k < skin.size[2]; ++k) {
    for (int j = 0; j < skin.size[1]; ++j) {
      for (int i = 0; i < skin.size[0]; ++i) {
        double& level = skin.level[skin.index(i, j, k)];
        const Vec3 p = skin.point(i, j, k);
        level = melt(level, hand_level(p), kWrist);
        level = melt(level, distance.level[skin.index(i, j, k)] - clearance, 0.003);
        level = -melt(-level, p.z() - kCut, 0.004);
      }
    }
  }
  blur(1, skin);
  return skin;
}

// m, length of edges: shorter where skin folds and where it is narrow.
double edge_length(const Vec3& p) {
  constexpr double kArm = 0.0054, kElbow = 0.0044, kHand = 0.0036;
  const double elbow = smoothstep(-0.36, -0.32, p.y()) * (1.0 - smoothstep(-0.27, -0.23, p.y()));
  const double hand = 1.0 - smoothstep(-0.58, -0.54, p.y());
  return kArm + (kElbow - kArm) * elbow + (kHand - kArm) * hand;
}

// Moves the nodes of every triangle whose corners, edges or middle come too near outwards.
bool keep_clear(const std::vector<Measured>& below, double clearance, TriMesh& mesh) {
  const std::vector<Vec3> normals = vertex_normals(mesh);
  std::vector<double> out(mesh.vertices.size(), 0.0);
  const auto check = [&](const Vec3& p, const Triangle& t) {
    for (const Measured& other : below) {
      const ClosestPoint near = closest_point(other.surface, other.bvh, other.x, p, clearance);
      if (near.triangle < 0 || near.distance >= clearance) continue;
      for (int node : t) out[node] = std::max(out[node], clearance - near.distance);
    }
  };
  for (const Triangle& t : mesh.triangles) {
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    check((a + b + c) / 3.0, t);
    check(0.5 * (a + b), {t[0], t[1], t[1]});
    check(a, {t[0], t[0], t[0]});
  }
  bool moved = false;
  for (size_t i = 0; i < out.size(); ++i) {
    moved |= out[i] > 0.0;
    mesh.vertices[i] += 1.05 * out[i] * normals[i];
  }
  return moved;
}

}  // namespace

TriMesh arm_skin(const std::vector<TriMesh>& meshes, double clearance) {
  std::vector<Measured> below;
  for (const TriMesh& mesh : meshes) below.emplace_back(mesh);
  LevelGrid grid = skin_level(below, clearance + 0.0002);
  const Level level = [&](const Vec3& p) { return level_at(grid, p); };
  TriMesh mesh = remeshed(surface_nets(grid), edge_length, level);
  smooth_folds(mesh);
  for (int pass = 0; pass < 40 && keep_clear(below, clearance, mesh); ++pass) {
  }
  return mesh;
}

}  // namespace thew::tools
