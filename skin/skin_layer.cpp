// SPDX-License-Identifier: Apache-2.0
//
// The skin is the least of an elastic energy (edges as at rest, turned with the bones; anchors to
// the bound shape) in which each node keeps its rest level of the flesh field, by alternating
// projection onto that level with one prefactored solve (Bouaziz et al. 2014, Projective Dynamics).
#include "skin/skin_layer.h"

#include <algorithm>
#include <cmath>

namespace thew {
namespace {

static double kReach = getenv("RE") ? atof(getenv("RE")) : 0.03;        // m, flesh farther from the skin is not felt


constexpr double kLeastAlong = 0.3;  // cosine that a step along an oblique way is divided by at least
constexpr double kLongestStep = 0.003;
static double kShortest = getenv("KS") ? atof(getenv("KS")) : 0.2;
constexpr double kCover = 0.001, kCoverReach = 0.006;
static double kSlack = getenv("SL") ? atof(getenv("SL")) : 0.01;      // m above its level at which the skin is no longer drawn in
// A rigid motion as a dual quaternion, turn + eps shift, shift = 1/2 (0, t) turn.
struct DualQuaternion {
  Eigen::Vector4d turn = Eigen::Vector4d::Zero(), shift = Eigen::Vector4d::Zero();
};

DualQuaternion dual_quaternion(const Transform& motion) {
  const Eigen::Quaterniond turn(motion.linear());
  const Vec3 t = 0.5 * motion.translation();
  return {turn.coeffs(), (Eigen::Quaterniond(0.0, t.x(), t.y(), t.z()) * turn).coeffs()};
}

// Turn and bound position of each node, blended over its bodies (Kavan et al. 2008: unlike a linear
// blend of positions it keeps the limb's thickness around a bent joint).
void bind_to_pose(const SkinModel& model, const Pose& pose, SkinState& state) {
  std::vector<DualQuaternion> motions;
  for (size_t b = 0; b < pose.size(); ++b) {
    motions.push_back(dual_quaternion(pose[b] * model.bind_pose[b].inverse()));
  }
  for (size_t i = 0; i < model.rest.size(); ++i) {
    DualQuaternion sum;
    const Eigen::Vector4d& main = motions[model.bodies[i][0]].turn;
    for (int k = 0; k < 4 && model.bodies[i][k] >= 0; ++k) {
      const DualQuaternion& q = motions[model.bodies[i][k]];
      const double share = q.turn.dot(main) < 0.0 ? -model.shares[i][k] : model.shares[i][k];
      sum.turn += share * q.turn;
      sum.shift += share * q.shift;
    }
    const double length = sum.turn.norm();
    const Eigen::Quaterniond turn(Eigen::Vector4d(sum.turn / length));
    const Eigen::Quaterniond shift(Eigen::Vector4d(sum.shift / length));
    state.turns[i] = turn.toRotationMatrix();
    state.bound[i] =
        to_row(state.turns[i] * to_vec(model.rest[i]) + 2.0 * (shift * turn.conjugate()).vec());
  }
}

// Right-hand side that does not change within a step: turned edges and anchors.
void elastic_pull(const SkinModel& model, SkinState& state) {
  for (size_t i = 0; i < model.rest.size(); ++i) {
    static double kSlip = getenv("LM") ? atof(getenv("LM")) : 0.006;
    const Vec3 slip = state.turns[i] * to_vec(state.slip[i]);
    const double far = slip.norm();
    const double yielded = far > kSlip ? 1.0 - kSlip / far : 0.0;
    state.bound[i] += to_row(yielded * slip);
    Row sum = model.anchor[i] * state.bound[i];
    for (int k = model.first_neighbour[i]; k < model.first_neighbour[i + 1]; ++k) {
      const int j = model.neighbours[k];
      const Vec3 edge = to_vec(model.rest[i]) - to_vec(model.rest[j]);
      const double bound = (to_vec(state.carried[i]) - to_vec(state.carried[j])).norm();
      static double kMax = getenv("SX") ? atof(getenv("SX")) : 3;
      const double stretch = std::clamp(bound / edge.norm(), 1.0, kMax);
      state.turned[k] = to_row(0.5 * stretch * (state.turns[i] + state.turns[j]) * edge);
      sum += model.weights[k] * state.turned[k];
    }
    state.elastic[i] = sum;
  }
}

void find_normals(const SkinModel& model, SkinState& state) {
  std::fill(state.normals.begin(), state.normals.end(), Row{});
  for (const Triangle& t : model.surface.triangles) {
    const Vec3 a = to_vec(state.x[t[0]]);
    const Row n = to_row((to_vec(state.x[t[1]]) - a).cross(to_vec(state.x[t[2]]) - a));
    for (int corner : t) state.normals[corner] += n;
  }
  const auto normalise = [&] {
    for (Row& n : state.normals) {
      const double length = to_vec(n).norm();
      if (length > 0.0) n = n * (1.0 / length);
    }
  };
  static int kSmooth = getenv("NS") ? atoi(getenv("NS")) : 4;
  for (int round = 0; round < kSmooth; ++round) {
    normalise();
    state.solution_scratch = state.normals;
    for (size_t i = 0; i < state.normals.size(); ++i) {
      for (int k = model.first_neighbour[i]; k < model.first_neighbour[i + 1]; ++k) {
        state.normals[i] += state.solution_scratch[model.neighbours[k]];
      }
    }
  }
  normalise();
}

// Out of the flesh: between the field's gradient and the skin's own normal, which alone counts where
// the gradient is lost in a crevice or leads inwards.
Vec3 way_out(const Vec3& gradient, const Vec3& normal) {
  static double kN = getenv("KN") ? atof(getenv("KN")) : 0.1;
  return (gradient + kN * normal).normalized();
}

void look_below(const SkinModel& model, const std::vector<Collider>& below, SkinState& state) {
  for (size_t i = 0; i < state.x.size(); ++i) {
    find_flesh(below, to_vec(state.x[i]), kReach, model.settings.bridging, static_cast<int>(i),
               state.hints, state.planes);
  }
}

void solve_elastic(const SkinModel& model, SkinState& state) {
  for (int k = 0; k < model.matrix.size(); ++k) {
    const Row& rhs = state.elastic[model.matrix.order[k]];
    const Row& force = state.force[model.matrix.order[k]];
    state.solution[k] = RowPair{rhs[0], rhs[1], rhs[2], 0.0, force[0], force[1], force[2], 0.0};
  }
  solve(model.matrix, model.factor, state.solution);
  for (int k = 0; k < model.matrix.size(); ++k) {
    const RowPair& x = state.solution[k];
    state.elastic[model.matrix.order[k]] = Row{x[0], x[1], x[2], 0.0};
    state.force[model.matrix.order[k]] = Row{x[4], x[5], x[6], 0.0};
  }
}

void relax_node(const SkinModel& model, SkinState& state, int i) {
  const int first = model.first_neighbour[i], last = model.first_neighbour[i + 1];
  Row sum{};
  double weight = model.anchor[i];
  for (int k = first; k < last; ++k) {
    const int j = model.neighbours[k];
    sum += model.weights[k] * (state.x[j] - state.elastic[j]);
    weight += model.weights[k];
  }
  const Vec3 before = to_vec(state.x[i]);
  FleshValue flesh = flesh_value(state.planes, i, before, model.settings.bridging);
  const Vec3 normal = to_vec(state.normals[i]);
  if (flesh.nearest_plane >= 0 && flesh.level > model.fat[i]) {
    const Vec3 way = way_out(flesh.gradient, normal);
    const double step = (model.fat[i] - flesh.level) / std::max(flesh.gradient.dot(way), kLeastAlong);
    const double pull = kFleshPull * std::max(1.0 + step / kSlack, 0.0);
    sum += pull * (to_row(before + step * way) - state.elastic[i]);
    weight += pull;
  }
  Row y = state.elastic[i] + sum * (1.0 / weight);
  for (int k = first; k < last; ++k) {
    const Row& e = state.turned[k];
    const Row edge = y - state.x[model.neighbours[k]];
    const double length2 = e[0] * e[0] + e[1] * e[1] + e[2] * e[2];
    const double along = edge[0] * e[0] + edge[1] * e[1] + edge[2] * e[2];
    const double lack = kShortest * length2 - along;
    if (lack > 0.0) y += 0.5 * lack / length2 * e;
  }
  Vec3 x = to_vec(y);
  for (int round = 0; round < 2; ++round) {
    flesh = flesh_value(state.planes, i, x, model.settings.bridging);
    if (flesh.nearest_plane < 0 || flesh.level >= model.fat[i]) break;
    const Vec3 way = way_out(flesh.gradient, normal);
    x += std::min((model.fat[i] - flesh.level) / std::max(flesh.gradient.dot(way), kLeastAlong), kLongestStep) * way;
  }
  state.x[i] = to_row(x);
}

// Flesh nodes that come near a skin triangle from within, or through it.
void look_above(const SkinModel& model, const std::vector<Collider>& below, SkinState& state) {
  refit_bvh(model.surface, state.x, state.bvh);
  state.covers.clear();
  for (const Collider& flesh : below) {
    for (const Row& p : *flesh.x) {
      const ClosestPoint near =
          closest_point(model.surface, state.bvh, state.x, to_vec(p), kCoverReach);
      if (near.triangle < 0 || near.distance < -2.0 * kCover) continue;
      const double* b = near.barycentric;
      state.covers.push_back({near.triangle, {b[0], b[1], b[2]}, near.normal, near.normal.dot(to_vec(p)) + kCover});
    }
  }
}

// Skin nodes that come near the other wall of a fold, or through it.
void look_across(const SkinModel& model, SkinState& state) {
  static double kFoldReach = getenv("FR") ? atof(getenv("FR")) : 0.004;
  static double kOpp = getenv("OP") ? atof(getenv("OP")) : -0.3;
  state.folds.clear();
  for (size_t i = 0; i < state.x.size(); ++i) {
    const Vec3 p = to_vec(state.x[i]);
    const Vec3 normal = to_vec(state.normals[i]);
    triangles_near(state.bvh, p, kFoldReach, state.nearby);
    ClosestPoint best;
    double nearest = kFoldReach;
    for (int t : state.nearby) {
      const Triangle& c = model.surface.triangles[t];
      const Vec3 facing = to_vec(state.normals[c[0]]) + to_vec(state.normals[c[1]]) + to_vec(state.normals[c[2]]);
      if (facing.dot(normal) > 3.0 * kOpp) continue;
      const int node = static_cast<int>(i);
      if (c[0] == node || c[1] == node || c[2] == node) continue;
      const ClosestPoint point = closest_on_triangle(model.surface, state.x, t, p);
      const double away = std::abs(point.distance);
      if (away > nearest || (away == nearest && best.triangle >= 0 && best.triangle < t)) continue;
      nearest = away;
      best = point;
    }
    if (best.triangle < 0) continue;
    const double* b = best.barycentric;
    state.folds.push_back({static_cast<int>(i), {best.triangle, {b[0], b[1], b[2]}, best.normal, model.settings.fold_gap}});
  }
}

// Moves the walls of folds apart.
void part_folds(const SkinModel& model, SkinState& state) {
  for (const SkinState::Fold& fold : state.folds) {
    const Triangle& t = model.surface.triangles[fold.wall.triangle];
    const auto& b = fold.wall.barycentric;
    const Row q = b[0] * state.x[t[0]] + b[1] * state.x[t[1]] + b[2] * state.x[t[2]];
    const double lack = fold.wall.level - fold.wall.normal.dot(to_vec(Row(state.x[fold.node] - q)));
    if (lack <= 0.0) continue;
    const Row push = to_row(lack / (1.0 + b[0] * b[0] + b[1] * b[1] + b[2] * b[2]) * fold.wall.normal);
    state.x[fold.node] += push;
    for (int k = 0; k < 3; ++k) state.x[t[k]] -= b[k] * push;
  }
}

// Moves skin triangles out over flesh nodes.
void cover_flesh(const SkinModel& model, SkinState& state) {
  for (const SkinState::Cover& cover : state.covers) {
    const Triangle& t = model.surface.triangles[cover.triangle];
    const auto& b = cover.barycentric;
    const Row q = b[0] * state.x[t[0]] + b[1] * state.x[t[1]] + b[2] * state.x[t[2]];
    const double lack = cover.level - cover.normal.dot(to_vec(q));
    if (lack <= 0.0) continue;
    const Row push = to_row(lack / (b[0] * b[0] + b[1] * b[1] + b[2] * b[2]) * cover.normal);
    for (int k = 0; k < 3; ++k) state.x[t[k]] += b[k] * push;
  }
}

void relax(const SkinModel& model, SkinState& state) {
  const int nodes = static_cast<int>(state.x.size());
  find_normals(model, state);
  for (int i = 0; i < nodes; ++i) relax_node(model, state, i);
  for (int i = nodes; i-- > 0;) relax_node(model, state, i);
  part_folds(model, state);
  cover_flesh(model, state);
}

// What the flesh pushes or draws each node with, along its way out, in equilibrium.
void find_forces(const SkinModel& model, SkinState& state) {
  for (size_t i = 0; i < state.x.size(); ++i) {
    const int first = model.first_neighbour[i], last = model.first_neighbour[i + 1];
    const Row d = state.x[i] - state.elastic[i];
    Row sum = model.anchor[i] * d;
    for (int k = first; k < last; ++k) {
      const int j = model.neighbours[k];
      sum += model.weights[k] * (d - (state.x[j] - state.elastic[j]));
    }
    const FleshValue flesh = flesh_value(state.planes, static_cast<int>(i), to_vec(state.x[i]), model.settings.bridging);
    Vec3 force = Vec3::Zero();
    if (flesh.nearest_plane >= 0) {
      const Vec3 way = way_out(flesh.gradient, to_vec(state.normals[i]));
      force = way.dot(to_vec(sum)) * way;
    }
    state.force[i] = to_row(state.turns[i].transpose() * force);
  }
}

// Moves a node that is too near the flesh out of it.
void clear_node(const SkinModel& model, const std::vector<Collider>& below, SkinState& state, int i) {
  constexpr int kRounds = 8;
  for (int round = 0; round < kRounds; ++round) {
    find_flesh(below, to_vec(state.x[i]), kReach, model.settings.bridging, i, state.hints, state.planes);
    const Vec3 x = to_vec(state.x[i]);
    const FleshValue flesh = flesh_value(state.planes, i, x, model.settings.bridging);
    if (flesh.nearest_plane < 0 || flesh.nearest >= model.least[i]) return;
    const Vec3& normal = state.planes.planes[i][flesh.nearest_plane].normal;
    const Vec3 way = way_out(flesh.gradient, to_vec(state.normals[i]));
    const double along = std::max(normal.dot(way), kLeastAlong);
    state.x[i] = to_row(x + (model.least[i] - flesh.nearest + 1e-6) / along * way);
  }
}

// Evens out what still crosses, with the ring around it, until nothing does.
void untangle(const SkinModel& model, const std::vector<Collider>& below, SkinState& state) {
  static int kRounds = getenv("UR") ? atoi(getenv("UR")) : 10;
  std::vector<char> tangled(state.x.size(), 0);
  for (int round = 0; round < kRounds; ++round) {
    refit_bvh(model.surface, state.x, state.bvh);
    const auto pairs = crossing_triangles(model.surface, state.bvh, state.x, model.surface, state.bvh, state.x);
    if (pairs.empty()) return;
    for (const auto& pair : pairs) {
      for (int t : pair) {
        for (int node : model.surface.triangles[t]) {
          tangled[node] = 1;
          for (int k = model.first_neighbour[node]; k < model.first_neighbour[node + 1]; ++k) {
            tangled[model.neighbours[k]] = 1;
          }
        }
      }
    }
    for (int sweep = 0; sweep < 4; ++sweep) {
      for (size_t i = 0; i < state.x.size(); ++i) {
        if (!tangled[i]) continue;
        Row sum{};
        double weight = 0.0;
        for (int k = model.first_neighbour[i]; k < model.first_neighbour[i + 1]; ++k) {
          sum += model.weights[k] * state.x[model.neighbours[k]];
          weight += model.weights[k];
        }
        state.x[i] = sum * (1.0 / weight);
      }
    }
    for (size_t i = 0; i < state.x.size(); ++i) {
      if (tangled[i]) clear_node(model, below, state, static_cast<int>(i));
    }
  }
}

}  // namespace

SkinState initial_skin(const SkinModel& model) {
  SkinState state;
  state.x = model.rest;
  state.offset.assign(state.x.size(), Row{});
  state.force = state.slip = state.offset;
  state.bvh = build_bvh(model.surface, state.x);
  state.bound = state.elastic = state.normals = state.x;
  state.turns.resize(state.x.size());
  state.turned.resize(model.neighbours.size());
  state.planes.planes.resize(state.x.size());
  state.planes.count.resize(state.x.size());
  state.solution.resize(state.x.size());
  return state;
}

void step_skin(const SkinModel& model, const Pose& pose, const std::vector<Collider>& below,
               SkinState& state) {
  state.hints.resize(state.x.size() * below.size(), -1);
  bind_to_pose(model, pose, state);
  state.carried = state.bound;
  elastic_pull(model, state);
  for (size_t i = 0; i < state.x.size(); ++i) {
    state.force[i] = to_row(state.turns[i] * to_vec(state.force[i]));
  }
  solve_elastic(model, state);
  static double kBeta = getenv("BE") ? atof(getenv("BE")) : 0.1;
  for (size_t i = 0; i < state.x.size(); ++i) {
    Row back = to_row(state.turns[i].transpose() * to_vec(state.force[i])) - state.offset[i];
    const double far = kBeta * to_vec(back).norm();
    back = back * (kBeta * std::min(1.0, 0.001 / std::max(far, 1e-9)));
    state.offset[i] += back;
    state.x[i] = state.elastic[i] + to_row(state.turns[i] * to_vec(state.offset[i]));
  }
  for (int k = 0; k < model.settings.iterations; ++k) {
    if (k % 4 == 0) look_below(model, below, state), look_above(model, below, state), look_across(model, state);
    relax(model, state);
  }
  look_below(model, below, state);
  for (size_t i = 0; i < state.x.size(); ++i) {
    const FleshValue flesh = flesh_value(state.planes, static_cast<int>(i), to_vec(state.x[i]), model.settings.bridging);
    if (flesh.nearest_plane >= 0 && flesh.nearest < model.least[i]) clear_node(model, below, state, static_cast<int>(i));
  }
  untangle(model, below, state);
  find_forces(model, state);
  for (size_t i = 0; i < state.x.size(); ++i) {
    const Row moved = state.x[i] - state.elastic[i];
    state.offset[i] = to_row(state.turns[i].transpose() * to_vec(moved));
    state.slip[i] = to_row(state.turns[i].transpose() * to_vec(Row(state.x[i] - state.carried[i])));
  }
  refit_bvh(model.surface, state.x, state.bvh);
}

SkinMetrics measure_skin(const SkinModel& model, const std::vector<Collider>& below,
                         const SkinState& state) {
  constexpr double kDeepest = 0.05;  // m
  SkinMetrics metrics;
  for (const Collider& flesh : below) {
    int hint = -1;
    for (const Row& p : state.x) {
      const ClosestPoint near =
          closest_point(*flesh.surface, *flesh.bvh, *flesh.x, to_vec(p), kDeepest, hint);
      if (near.triangle < 0) continue;
      hint = near.triangle;
      metrics.max_penetration = std::max(metrics.max_penetration, -near.distance);
    }
    for (const Row& p : *flesh.x) {
      const ClosestPoint near =
          closest_point(model.surface, state.bvh, state.x, to_vec(p), kDeepest);
      if (near.triangle < 0) continue;
      metrics.max_poke_through = std::max(metrics.max_poke_through, near.distance);
    }
  }
  metrics.intersecting_pairs = static_cast<int>(
      crossing_triangles(model.surface, state.bvh, state.x, model.surface, state.bvh, state.x)
          .size());
  return metrics;
}

}  // namespace thew
