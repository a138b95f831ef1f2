// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "rig/vectorise.h"
#include "skin/skin_passes.h"

namespace thew::skin {
namespace {

// Most stretch of an edge [1], over the outer side of a joint; chosen by trial.
constexpr double kMaxStretch = 3.0;
// Least length of an edge along its rotated direction, over its rest length; by trial.
constexpr double kMinEdge = 0.1;
// Weight of the pull of the flesh on skin above its level; chosen by trial.
constexpr double kInwardPull = 0.05;

Point turn(const Mat3& rotation, const Point& v) { return to_point(rotation * to_vec(v)); }
Point turn_back(const Mat3& rotation, const Point& v) {
  return to_point(rotation.transpose() * to_vec(v));
}

DualQuaternion dual_quaternion(const Transform& motion) {
  const Eigen::Quaterniond turn(motion.linear());
  const Vec3 t = 0.5 * motion.translation();
  return {turn.coeffs(), (Eigen::Quaterniond(0.0, t.x(), t.y(), t.z()) * turn).coeffs()};
}

void relax_node(const SkinModel& model, SkinState& state, int i) {
  const int first = model.first_neighbour[i], last = model.first_neighbour[i + 1];
  const Lengths& lengths = model.settings.lengths;
  const double bridging = model.settings.bridging, fat = model.fat[i];
  Point sum{};  // sum of weighted displacements from the elastic shape
  double weight = model.anchor[i];
  for (int k = first; k < last; ++k) {
    const int j = model.neighbours[k];
    sum += model.weights[k] * (state.x[j] - state.elastic[j]);
    weight += model.weights[k];
  }
  FleshValue flesh = flesh_value(state.planes, i, to_vec(state.x[i]), bridging);
  if (flesh.found && flesh.level > fat) {
    const Vec3 out = outward_direction(flesh, state.normals[i]);
    const double step = climb_distance(flesh, out, fat - flesh.level);
    const double pull = kInwardPull * std::max(1.0 + step / lengths.pull_range, 0.0);
    sum += pull * (state.x[i] + to_point(step * out) - state.elastic[i]);
    weight += pull;
  }
  constexpr double kOver = 1.0;  // over-relaxation; 1: none
  Point x = state.x[i] + kOver * (state.elastic[i] + sum * (1.0 / weight) - state.x[i]);
  for (int k = first; k < last; ++k) {  // neighbours must not pass one another
    const Point& e = state.turned[k];
    const double lack = kMinEdge - dot(x - state.x[model.neighbours[k]], e) / dot(e, e);
    if (lack > 0.0) x += 0.5 * lack * e;
  }
  const double firm = std::min(fat, lengths.firm_fat);
  for (int round = 0; round < 2; ++round) {
    flesh = flesh_value(state.planes, i, to_vec(x), bridging);
    if (!flesh.found || flesh.level >= firm) break;
    const Vec3 out = outward_direction(flesh, state.normals[i]);
    x +=
        to_point(std::min(climb_distance(flesh, out, firm - flesh.level), lengths.max_climb) * out);
  }
  state.x[i] = x;
}

[[gnu::always_inline]] inline Point unit(const Point& n) {
  const double length = norm(n);
  return length > 0.0 ? n * (1.0 / length) : n;
}

// Twice the area vectors of triangles.
THEW_VECTORISED
void find_areas(const SkinModel& model, int first, int last, SkinState& state) {
  for (int t = first; t < last; ++t) {
    const Triangle& corner = model.surface.triangles[t];
    const Point a = state.x[corner[0]];
    state.areas[t] = cross3(state.x[corner[1]] - a, state.x[corner[2]] - a);
  }
}

THEW_VECTORISED
void sum_areas(const SkinModel& model, int first, int last, SkinState& state) {
  for (int i = first; i < last; ++i) {
    Point sum{};
    for (const int t : model.surface.vertex_triangles[i]) sum += state.areas[t];
    state.own_normals[i] = unit(sum);
  }
}

THEW_VECTORISED
void average_normals(const SkinModel& model, int first, int last, SkinState& state) {
  for (int i = first; i < last; ++i) {
    Point sum = state.own_normals[i];
    for (int k = model.first_neighbour[i]; k < model.first_neighbour[i + 1]; ++k) {
      sum += state.own_normals[model.neighbours[k]];
    }
    state.normals[i] = unit(sum);
  }
}

}  // namespace

void find_normals(const SkinModel& model, const Loop& loop, SkinState& state) {
  constexpr int kTriangles = 1024, kNodes = 512;  // that a thread takes at a time
  const int nodes = static_cast<int>(state.x.size());
  loop.ranges(static_cast<int>(model.surface.triangles.size()), kTriangles,
              [&](int first, int last) { find_areas(model, first, last, state); });
  loop.ranges(nodes, kNodes, [&](int first, int last) { sum_areas(model, first, last, state); });
  loop.ranges(nodes, kNodes,
              [&](int first, int last) { average_normals(model, first, last, state); });
}

void bind_to_pose(const SkinModel& model, const Pose& pose, SkinState& state) {
  // Kavan et al. 2008. Unlike a linear blend this keeps the thickness of the limb around a bent
  // joint.
  std::vector<DualQuaternion>& motions = state.motions;
  motions.clear();
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
        to_point(state.turns[i] * to_vec(model.rest[i]) + 2.0 * (shift * turn.conjugate()).vec());
  }
}

void solve_elastic(const SkinModel& model, SkinState& state) {
  const size_t nodes = model.rest.size();
  const double yield = model.settings.lengths.anchor_slip;
  for (size_t i = 0; i < nodes; ++i) {
    // An anchor pulls no more than at a distance of anchor_slip. So skin that the flesh has
    // squeezed out of a fold slides, instead of being pulled through the flesh.
    const Point slip = turn(state.turns[i], state.slip[i]);
    const double far = norm(slip);
    Point anchored = state.bound[i];
    if (far > yield) anchored += (1.0 - yield / far) * slip;
    Point sum = model.anchor[i] * anchored;
    for (int k = model.first_neighbour[i]; k < model.first_neighbour[i + 1]; ++k) {
      const int j = model.neighbours[k];
      const Point edge = model.rest[i] - model.rest[j], bound = state.bound[i] - state.bound[j];
      // Edges rotate and stretch with the bodies, but are not shortened: they would let the walls
      // of a fold pass through each other (skin/notes.md).
      const double stretch =
          std::clamp(std::sqrt(dot(bound, bound) / dot(edge, edge)), 1.0, kMaxStretch);
      state.turned[k] = to_point(0.5 * stretch * (state.turns[i] + state.turns[j]) * to_vec(edge));
      sum += model.weights[k] * state.turned[k];
    }
    state.elastic[i] = sum;
    state.force[i] = turn(state.turns[i], state.force[i]);
  }
  for (size_t k = 0; k < nodes; ++k) {
    const Point &a = state.elastic[model.matrix.order[k]], &b = state.force[model.matrix.order[k]];
    state.solution[k] = PointPair{a[0], a[1], a[2], 0.0, b[0], b[1], b[2], 0.0};
  }
  solve(model.matrix, model.factor, state.solution);
  for (size_t k = 0; k < nodes; ++k) {
    const PointPair& x = state.solution[k];
    state.elastic[model.matrix.order[k]] = Point{x[0], x[1], x[2], 0.0};
    state.force[model.matrix.order[k]] = Point{x[4], x[5], x[6], 0.0};
  }
}

void predict_skin(const SkinModel& model, double share_of_return, SkinState& state) {
  const double longest = model.settings.lengths.max_return;
  // Sweeps smooth local displacements, but converge slowly for wide ones. So the displacement goes
  // a part of the way to its equilibrium with the forces of the step before.
  for (size_t i = 0; i < state.x.size(); ++i) {
    const Point offset = turn(state.turns[i], state.offset[i]);
    const Point back = state.force[i] - offset;
    const double far = norm(back);
    const double share = std::min(share_of_return, longest / std::max(far, longest));
    state.x[i] = state.elastic[i] + offset + share * back;
  }
  state.predicted = state.x;
}

void relax(const SkinModel& model, const Loop& loop, SkinState& state) {
  const int nodes = static_cast<int>(state.x.size());
  find_normals(model, loop, state);
  for (int i = 0; i < nodes; ++i) relax_node(model, state, i);
  for (int i = nodes; i-- > 0;) relax_node(model, state, i);
}

void limit_corrections(const SkinModel& model, SkinState& state) {
  constexpr double kSpeedUp = 2.0;  // of the correction from step to step; chosen by trial
  const double always = model.settings.lengths.free_correction;
  for (size_t i = 0; i < state.x.size(); ++i) {
    const Point correction = state.x[i] - state.predicted[i];
    const double far = norm(correction), most = kSpeedUp * state.correction[i] + always;
    if (far > most) state.x[i] = state.predicted[i] + (most / far) * correction;
  }
}

void store_motion(const SkinModel& model, SkinState& state) {
  for (size_t i = 0; i < state.x.size(); ++i) {
    const Point d = state.x[i] - state.elastic[i];
    Point sum = model.anchor[i] * d;
    for (int k = model.first_neighbour[i]; k < model.first_neighbour[i + 1]; ++k) {
      const int j = model.neighbours[k];
      sum += model.weights[k] * (d - (state.x[j] - state.elastic[j]));
    }
    // There is no friction. Of the force that the sweeps have left unbalanced, the flesh bears the
    // part along its outward direction, and the other wall of a fold bears the part that pulls the
    // node towards it.
    const FleshValue flesh =
        flesh_value(state.planes, static_cast<int>(i), to_vec(state.x[i]), model.settings.bridging);
    const Point out = flesh.found ? to_point(outward_direction(flesh, state.normals[i])) : Point{};
    Point force = dot(out, sum) * out;
    const Point apart = state.separation[i] - dot(out, state.separation[i]) * out;
    const double by = norm(apart);
    if (by > model.settings.lengths.least_separation)
      force += std::max(dot(apart, sum), 0.0) / (by * by) * apart;
    state.force[i] = turn_back(state.turns[i], force);
    state.offset[i] = turn_back(state.turns[i], d);
    state.correction[i] = norm(state.x[i] - state.predicted[i]);
    state.slip[i] = turn_back(state.turns[i], state.x[i] - state.bound[i]);
  }
}

}  // namespace thew::skin
