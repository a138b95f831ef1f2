// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/rivals/hirota.h"

#include <nlopt.h>

#include <memory>

#include "muscles/volume.h"

namespace thew::tools {
namespace {

constexpr double kHold = 1e4;  // N/m, of obstacles and of what the surroundings drive, at a node

Vec3 control_at(const std::vector<double>& control, int i) {
  return {control[3 * i], control[3 * i + 1], control[3 * i + 2]};
}

void add_at(std::vector<double>& gradient, int i, const Vec3& g) {
  for (int k = 0; k < 3; ++k) gradient[3 * i + k] += g[k];
}

// Springs to the 13 neighbours ahead: a box's edges, the diagonals of its faces and its own.
void add_springs(int side, const Vec3& cell, Lattice& out) {
  const auto index = [&](int x, int y, int z) { return (x * side + y) * side + z; };
  for (int at = 0; at < side * side * side; ++at) {
    const int x = at / (side * side), y = at / side % side, z = at % side;
    for (int code = 14; code < 27; ++code) {
      const int dx = code / 9 - 1, dy = code / 3 % 3 - 1, dz = code % 3 - 1;
      const int px = x + dx, py = y + dy, pz = z + dz;
      if (std::min({px, py, pz}) < 0 || std::max({px, py, pz}) >= side) continue;
      const int to = index(px, py, pz);
      const double length = (out.rest[to] - out.rest[at]).norm();
      // As a solid's edges: modulus times the volume that each spring stands for over length^2.
      const double share = cell.prod() / 13.0 * 3.0;
      out.springs.push_back({at, to, out.setting.young * share / (length * length), length});
    }
  }
}

}  // namespace

Lattice make_lattice(const RivalBody& body, const LatticeSetting& setting) {
  Lattice out;
  out.setting = setting;
  const int side = setting.cells + 1;
  Vec3 low = body.rest[0], high = body.rest[0];
  for (const Vec3& p : body.rest) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const Vec3 cell = (high - low) / setting.cells;
  for (int at = 0; at < side * side * side; ++at) {
    out.rest.push_back(low +
                       cell.cwiseProduct(Vec3(at / (side * side), at / side % side, at % side)));
  }
  add_springs(side, cell, out);
  for (const Vec3& p : body.rest) {
    int base[3];
    double part[3];
    for (int k = 0; k < 3; ++k) {
      const double u = (p[k] - low[k]) / cell[k];
      base[k] = std::clamp(static_cast<int>(u), 0, setting.cells - 1);
      part[k] = u - base[k];
    }
    std::array<int, 8>& corners = out.corners.emplace_back();
    std::array<double, 8>& weights = out.weights.emplace_back();
    for (int c = 0; c < 8; ++c) {
      const int bit[3] = {c & 1, c >> 1 & 1, c >> 2 & 1};
      corners[c] = ((base[0] + bit[0]) * side + base[1] + bit[1]) * side + base[2] + bit[2];
      weights[c] = 1.0;
      for (int k = 0; k < 3; ++k) weights[c] *= bit[k] ? part[k] : 1.0 - part[k];
    }
  }
  return out;
}

double lattice_energy(const Lattice& lattice, const RivalBody& body,
                      const std::function<Vec3(const Vec3&)>& beyond, const Points& driven,
                      const std::vector<double>& control, Points& x,
                      std::vector<double>* gradient) {
  double energy = 0.0;
  if (gradient) gradient->assign(control.size(), 0.0);
  for (const Lattice::Spring& spring : lattice.springs) {
    const Vec3 d = control_at(control, spring.b) - control_at(control, spring.a);
    const double length = d.norm(), more = length - spring.length;
    energy += 0.5 * spring.stiffness * more * more;
    if (!gradient || !(length > 0.0)) continue;
    const Vec3 g = spring.stiffness * more / length * d;
    add_at(*gradient, spring.b, g);
    add_at(*gradient, spring.a, -g);
  }
  x.assign(body.rest.size(), Point{});
  for (size_t i = 0; i < x.size(); ++i) {
    Vec3 p = Vec3::Zero();
    for (int c = 0; c < 8; ++c) {
      p += lattice.weights[i][c] * control_at(control, lattice.corners[i][c]);
    }
    x[i] = to_point(p);
  }
  Points slope(x.size(), Point{});
  if (lattice.setting.modulus > 0.0) {
    const double rest = enclosed_volume(body.rest, body.triangles);
    const double change = enclosed_volume(x, body.triangles) / rest - 1.0;
    energy += 0.5 * lattice.setting.modulus * rest * change * change;
    volume_gradient(x, body.triangles, slope);
    for (Point& g : slope) g *= lattice.setting.modulus * change;
  }
  for (size_t i = 0; i < x.size(); ++i) {
    const Vec3 depth = body.driven[i] ? to_vec(x[i] - driven[i])
                       : beyond       ? beyond(to_vec(x[i]))
                                      : Vec3(Vec3::Zero());
    energy += 0.5 * kHold * depth.squaredNorm();
    slope[i] += kHold * to_point(depth);
    for (int c = 0; gradient && c < 8; ++c) {
      add_at(*gradient, lattice.corners[i][c], lattice.weights[i][c] * to_vec(slope[i]));
    }
  }
  return energy;
}

namespace {

struct Problem {
  const Lattice& lattice;
  const RivalBody& body;
  std::function<Vec3(const Vec3&)> beyond;
  Points driven, x;
  std::vector<double> control, gradient;
};

double evaluate(unsigned count, const double* control, double* gradient, void* data) {
  Problem& problem = *static_cast<Problem*>(data);
  problem.control.assign(control, control + count);
  const double energy =
      lattice_energy(problem.lattice, problem.body, problem.beyond, problem.driven, problem.control,
                     problem.x, gradient ? &problem.gradient : nullptr);
  if (gradient) std::copy(problem.gradient.begin(), problem.gradient.end(), gradient);
  return energy;
}

}  // namespace

double stretched_energy(const RivalBody& body, const LatticeSetting& setting, const Vec3& stretch) {
  const Lattice lattice = make_lattice(body, setting);
  RivalBody free = body;
  std::fill(free.driven.begin(), free.driven.end(), 0);
  std::vector<double> control;
  for (const Vec3& p : lattice.rest) {
    for (int k = 0; k < 3; ++k) control.push_back(stretch[k] * p[k]);
  }
  Points x;
  return lattice_energy(lattice, free, {}, x, control, x, nullptr);
}

Stepper hirota_stepper(const RivalBody& body, const LatticeSetting& setting) {
  const auto lattice = std::make_shared<const Lattice>(make_lattice(body, setting));
  std::vector<double> control;
  for (const Vec3& p : lattice->rest) control.insert(control.end(), p.data(), p.data() + 3);
  return [lattice, control](const Surroundings& around, double time, double h,
                            RivalBody& now) mutable {
    drive_nodes(around, time, h, now);
    Problem problem{*lattice, now, {}, now.x, {}, {}, {}};
    if (around.beyond) {
      problem.beyond = [&](const Vec3& p) { return around.beyond(time, p); };
    }
    const std::unique_ptr<nlopt_opt_s, void (*)(nlopt_opt)> optimiser(
        nlopt_create(NLOPT_LD_LBFGS, static_cast<unsigned>(control.size())), nlopt_destroy);
    nlopt_set_min_objective(optimiser.get(), evaluate, &problem);
    nlopt_set_ftol_rel(optimiser.get(), 1e-9);
    nlopt_set_maxeval(optimiser.get(), lattice->setting.evaluations);
    double energy = 0.0;
    nlopt_optimize(optimiser.get(), control.data(), &energy);
    lattice_energy(*lattice, now, problem.beyond, problem.driven, control, problem.x, nullptr);
    for (size_t i = 0; i < now.x.size(); ++i) {
      if (now.driven[i]) continue;
      now.v[i] = 1.0 / h * (problem.x[i] - now.x[i]);
      now.x[i] = problem.x[i];
    }
  };
}

}  // namespace thew::tools
