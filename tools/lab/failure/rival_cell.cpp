// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/failure/rival_cell.h"

#include <algorithm>
#include <cmath>

#include "rig/math.h"
#include "tools/base/signals.h"

namespace thew::tools {
namespace {

constexpr double kDensity = 1060.0;  // kg/m^3
constexpr double kTheirs = 1000.0;   // N/m or Pa, the stiffness that they are made with
constexpr double kFarthest = 3.0;    // of the farthest node at rest
constexpr const char* kFlownOff = "a node is no number or three times as far off as any at rest";

// A body k times as stiff moves as one of stiffness 1 whose clock runs sqrt(k) times as fast (all
// moduli, those of volume and obstacles too, against the same mass). So each stepper, whatever it
// is made of, takes any stiffness.
Surroundings surroundings_of(const MapBody& body, Load load, double value, double clock) {
  const LoadWay way = load_way(body, load, value);
  Surroundings around;
  if (load == Load::kTwist) {
    around.drive = [=, &body](double time, const std::vector<Vec3>& rest, Points& x) {
      const Mat3 turn = rotation_about(Vec3::UnitX(), way.at(time / clock));
      const std::vector<char> held = held_nodes(body, rest);
      for (size_t i = 0; i < rest.size(); ++i) {
        if (held[i]) x[i] = to_point(held[i] == 2 ? Vec3(turn * rest[i]) : rest[i]);
      }
    };
    return around;
  }
  around.beyond = [way, clock, half = 0.5 * body.size.y()](double time, const Vec3& p) {
    const double depth = std::abs(p.y()) - (half - way.at(time / clock));
    return Vec3(0.0, depth > 0.0 ? std::copysign(depth, p.y()) : 0.0, 0.0);
  };
  return around;
}

double kinetic_energy(const RivalBody& body) {
  double energy = 0.0;
  for (size_t i = 0; i < body.v.size(); ++i) {
    if (!body.driven[i]) energy += 0.5 * body.mass[i] * dot(body.v[i], body.v[i]);
  }
  return energy;
}

bool is_near(const RivalBody& body) {
  double reach = 0.0;
  for (const Vec3& p : body.rest) reach = std::max(reach, p.norm());
  const double most = kFarthest * kFarthest * reach * reach;
  return std::all_of(body.x.begin(), body.x.end(),
                     [&](const Point& p) { return dot(p, p) < most; });
}

}  // namespace

std::vector<RelatedMethod> map_rivals(const MapBody& body) {
  std::vector<RelatedMethod> all = related_methods(true);
  std::erase_if(all, [&](const RelatedMethod& one) {
    return !one.of.empty() || !one.meets || (one.solid && body.solid.vertices.empty());
  });
  return all;
}

std::vector<double> rival_steps(const RelatedMethod& method) {
  if (!method.has_step) return {0.1};
  if (method.implicit) return {0.05, 0.1, 0.2};  // each of them dear
  if (method.name == "Chen 2024") return {0.025, 0.05, 0.1, 0.2};
  return {0.000625, 0.00125, 0.0025, 0.005, 0.01};
}

bool can_load(Load load) { return load != Load::kWeights; }

MapCell run_rival_cell(const MapBody& body, Load load, double value, const RelatedMethod& method,
                       double h, Points& last) {
  MapCell cell;
  RivalBody now =
      method.solid ? solid_body(body.solid, kDensity) : surface_body(body.mesh, kDensity);
  if (load == Load::kTwist) {
    const std::vector<char> held = held_nodes(body, now.rest);
    for (size_t i = 0; i < held.size(); ++i) now.driven[i] = held[i] > 0;
  }
  const double stiffer = body.material.stiffness / kTheirs;
  const double clock = std::sqrt(load == Load::kStiffness ? stiffer * value : stiffer);
  const Surroundings around = surroundings_of(body, load, value, clock);
  const Stepper step = method.dials[0].make(now, kMapDrag / clock);
  const int phase = static_cast<int>(std::lround(kPhase / h));
  CellWatch watch(now.triangles, volume_of(now), phase);
  for (int frame = 1; frame <= 4 * phase; ++frame) {
    stop_if_interrupted();
    step(around, frame * h * clock, h * clock, now);
    if (!is_near(now)) {
      cell.failure = kFlownOff;
      cell.mechanism = Mechanism::kFliesOff;
      cell.verdict = Verdict::kDiverged;
      return cell;
    }
    watch.see(frame, now.x, kinetic_energy(now), cell);
  }
  for (const Point& v : now.v) {
    cell.speed = std::max(cell.speed, clock * to_vec(v).norm() / body.size.norm());
  }
  for (size_t i = 0; i < now.x.size(); ++i) {
    if (now.surface[i]) last.push_back(now.x[i]);
  }
  return cell;
}

}  // namespace thew::tools
