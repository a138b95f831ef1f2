// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstring>

#include "rig/vectorise.h"
#include "skin/flesh_level.h"
#include "skin/skin_passes.h"

namespace thew::skin {
namespace {

// Most stretch of an edge [1], over the outer side of a joint; chosen by trial.
constexpr double kMaxStretch = 3.0;
constexpr double kAboveRounding = 1.0 + 1e-12;

Point turn(const Mat3& rotation, const Point& v) { return to_point(rotation * to_vec(v)); }
Point turn_back(const Mat3& rotation, const Point& v) {
  return to_point(rotation.transpose() * to_vec(v));
}

DualQuaternion dual_quaternion(const Transform& motion) {
  const Eigen::Quaterniond turn(motion.linear());
  const Vec3 t = 0.5 * motion.translation();
  return {turn.coeffs(), (Eigen::Quaterniond(0.0, t.x(), t.y(), t.z()) * turn).coeffs()};
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
  for (size_t i = 0; i < state.carried.size(); ++i) {
    state.bound[i] += turn(state.turns[i], state.carried[i]);
  }
}

void set_carried(const SkinModel& model, const Pose& pose, const Points& shape, double share,
                 SkinState& state) {
  state.carried.clear();
  bind_to_pose(model, pose, state);
  state.carried.resize(shape.size());
  for (size_t i = 0; i < shape.size(); ++i) {
    state.carried[i] = share * turn_back(state.turns[i], shape[i] - state.bound[i]);
  }
}

namespace {

// The columns of a matrix; their fourth coordinates mean nothing.
[[gnu::always_inline]] inline void load_columns(const Mat3& matrix, Point* columns) {
  const double* from = matrix.data();
  Point last;
  std::memcpy(&columns[0], from, sizeof(Point));
  std::memcpy(&columns[1], from + 3, sizeof(Point));
  std::memcpy(&last, from + 5, sizeof(Point));
  columns[2] = __builtin_shufflevector(last, last, 1, 2, 3, 3);
}

// In the order in which Eigen sums.
[[gnu::always_inline]] inline Point product(const Point* columns, const Point& v) {
  Point sum = columns[0] * v[0] + (columns[1] * v[1] + columns[2] * v[2]);
  sum[3] = 0.0;
  return sum;
}

// Sets `turned` around the nodes [first, last), and `elastic` to what draws them.
THEW_VECTORISED
void turn_edges(const SkinModel& model, int first, int last, SkinState& state) {
  const double yield = model.settings.lengths.anchor_slip;
  for (int i = first; i < last; ++i) {
    // An anchor pulls no more than at a distance of anchor_slip. So skin that the flesh has
    // squeezed out of a fold slides, instead of being pulled through the flesh.
    Point own[3], other[3];
    load_columns(state.turns[i], own);
    const Point slip = product(own, state.slip[i]);
    const double far = norm(slip);
    Point anchored = state.bound[i];
    if (far > yield) anchored += (1.0 - yield / far) * slip;
    Point sum = model.anchor[i] * anchored;
    if (!model.stick.empty()) sum += model.stick[i] * state.stuck[i];
    for (int k = model.first_neighbour[i]; k < model.first_neighbour[i + 1]; ++k) {
      const int j = model.neighbours[k];
      const Point edge = model.rest[i] - model.rest[j], bound = state.bound[i] - state.bound[j];
      // Edges rotate and stretch with the bodies, but are not shortened: they would let the walls
      // of a fold pass through each other (skin/notes.md).
      const double stretch =
          std::clamp(std::sqrt(dot(bound, bound) / dot(edge, edge)), 1.0, kMaxStretch);
      load_columns(state.turns[j], other);
      for (int c = 0; c < 3; ++c) other[c] = 0.5 * stretch * (own[c] + other[c]);
      Point turned = state.carried.empty() ? product(other, edge) : bound;
      sum += model.weights[k] * turned;
      turned[3] = kAboveRounding * kMinEdge * dot(turned, turned);
      state.turned[k] = turned;
    }
    state.elastic[i] = sum;
    state.force[i] = product(own, state.force[i]);
  }
}

}  // namespace

void solve_elastic(const SkinModel& model, const Loop& loop, SkinState& state) {
  constexpr int kNodes = 512;  // that a thread takes at a time
  const size_t nodes = model.rest.size();
  loop.ranges(static_cast<int>(nodes), kNodes,
              [&](int first, int last) { turn_edges(model, first, last, state); });
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
    if (!model.stick.empty()) sum += model.stick[i] * d;
    for (int k = model.first_neighbour[i]; k < model.first_neighbour[i + 1]; ++k) {
      const int j = model.neighbours[k];
      sum += model.weights[k] * (d - (state.x[j] - state.elastic[j]));
    }
    // There is no friction. Of the force that the sweeps have left unbalanced, the flesh bears the
    // part along its outward direction, and the other wall of a fold bears the part that pulls the
    // node towards it.
    const FleshValue flesh =
        flesh_value(state.planes, static_cast<int>(i), to_vec(state.x[i]), model.settings.bridging);
    const Point out = flesh.found
                          ? to_point(outward_direction(flesh.gradient_of_level, state.normals[i]))
                          : Point{};
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
