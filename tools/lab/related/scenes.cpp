// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/related/scenes.h"

#include "rig/math.h"
#include "tools/lab/elements/fem_ball.h"
#include "tools/lab/elements/fem_bar.h"
#include "tools/lab/paper/ball.h"

namespace thew::tools {
namespace {

constexpr double kQuarterTurn = 1.57079632679489661923;
constexpr double kProbe = 0.03, kDepth = 0.02;  // m: radius, and how deep it comes to lie
constexpr double kNearer = 0.03;                // m, each end of the flexed muscle
// Nearly incompressible: penalty over shear is a thousand.
const FemMaterial kTrueMaterial{.neo_hookean = true, .shear = kShear, .penalty = 1e6};

double share_at(double time) { return std::clamp(time, 0.0, 1.0); }

PaperScene ready(const std::filesystem::path& file, std::vector<std::string> overrides) {
  PaperAsk ask;
  ask.scene = file;
  ask.overrides = std::move(overrides);
  return ready_scene(ask);
}

Vec3 beyond_planes(double share, const Vec3& p) {
  const double depth = std::abs(p.y()) - kBallRadius * (1.0 - 0.5 * share);
  return {0, depth > 0.0 ? std::copysign(depth, p.y()) : 0.0, 0};
}

Vec3 beyond_probes(double share, const Vec3& p) {
  const double at = kBallRadius + kProbe - kDepth * share;
  const Vec3 in = Vec3(0, std::copysign(at, p.y()), 0) - p;
  const double length = in.norm();
  return length < kProbe ? Vec3((kProbe / length - 1.0) * in) : Vec3(Vec3::Zero());
}

// Where a node that starts at `rest` is driven to.
Vec3 turned(double share, const Vec3& rest) {
  return rest.y() > 0.0 ? Vec3(rotation_about(Vec3::UnitY(), kQuarterTurn * share) * rest) : rest;
}

Vec3 nearer(double share, const Vec3& rest) {
  return rest - Vec3(std::copysign(kNearer * share, rest.x()), 0, 0);
}

using Way = Vec3 (*)(double share, const Vec3&);

void drive_by(Way way, RelatedScene& scene) {
  scene.around.drive = [way, held = scene.held](double time, const std::vector<Vec3>& rest,
                                                Points& x) {
    for (size_t i = 0; i < rest.size(); ++i) {
      if (held(rest[i])) x[i] = to_point(way(share_at(time), rest[i]));
    }
  };
  scene.truth.drive = [way](double share, FemBody& body) {
    for (size_t i = 0; i < body.rest.size(); ++i) {
      if (body.fixed[3 * i] && body.fixed[3 * i + 1] && body.fixed[3 * i + 2]) {
        body.x[i] = way(share, body.rest[i]);
      }
    }
  };
}

void stop_by(Way way, RelatedScene& scene) {
  scene.around.beyond = [way](double time, const Vec3& p) { return way(share_at(time), p); };
  scene.truth.beyond = way;
}

TruthScene ball_truth(int meshes) {
  TruthScene truth;
  truth.meshes = meshes;
  truth.coarsest = 8;
  truth.round = [](int n) { return round_ellipsoid(kBallRadius, kBallRadius, n); };
  return truth;
}

RelatedScene ball_scene(PaperScene ours, int tetrahedra, int truth_meshes) {
  RelatedScene scene;
  scene.ours = std::move(ours);
  scene.surface = scene.ours.model->muscles[0].rest;
  scene.solid = fill_ball(scene.surface, tetrahedra);
  scene.truth = ball_truth(truth_meshes);
  scene.size = kBallRadius;
  return scene;
}

// Kuhn's tetrahedra of n^3 cells of the cube: corners for a method, quadratic for the truth.
FemBody quadratic_cube(int n) {
  FemBody body;
  body.order = 2;
  body.material = kTrueMaterial;
  std::map<LatticePoint, int> index;
  const auto node = [&](const LatticePoint& at) {
    const auto [found, added] = index.try_emplace(at, static_cast<int>(body.rest.size()));
    if (!added) return found->second;
    body.rest.push_back(0.1 / n * Vec3(at[0], at[1], at[2]) - Vec3::Constant(0.1));
    bool outside = false;
    for (const int k : at) outside = outside || k == 0 || k == 2 * n;
    body.surface.push_back(outside);
    for (int k = 0; k < 3; ++k) body.fixed.push_back(at[1] == 0 || at[1] == 2 * n);
    return found->second;
  };
  const auto place = [](const LatticePoint& p) {
    return LatticePoint{2 * p[0], 2 * p[1], 2 * p[2]};
  };
  for (int cell = 0; cell < n * n * n; ++cell) {
    add_kuhn_cell({cell % n, cell / n % n, cell / (n * n)}, place, node, body);
  }
  prepare(body);
  return body;
}

TetMesh corners_of(const FemBody& body) {
  TetMesh mesh;
  std::vector<int> at(body.rest.size(), -1);
  for (int e = 0; e < body.count(); ++e) {
    Tetrahedron& t = mesh.tetrahedra.emplace_back();
    for (int k = 0; k < 4; ++k) {
      int& to = at[body.elements[10 * e + k]];
      if (to < 0) {
        to = static_cast<int>(mesh.vertices.size());
        mesh.vertices.push_back(body.rest[body.elements[10 * e + k]]);
      }
      t[k] = to;
    }
  }
  return mesh;
}

}  // namespace

RelatedScene squeezed_ball(const std::filesystem::path& scenes, int triangles, int tetrahedra,
                           int truth_meshes) {
  RelatedScene scene = ball_scene(
      ready(scenes / "ball.toml", {"scene.frames=1-46", "muscle.ball.damping=10",
                                   "muscle.ball.mesh=ball_" + std::to_string(triangles) + ".obj"}),
      tetrahedra, truth_meshes);
  scene.name = "ball squeezed";
  scene.key = "ball_" + std::to_string(triangles);
  stop_by(beyond_planes, scene);
  return scene;
}

RelatedScene pressed_ball(const std::filesystem::path& scenes, int truth_meshes) {
  RelatedScene scene =
      ball_scene(ready(scenes / "pressed.toml", {}), kPrintedBalls[0].tetrahedra, truth_meshes);
  scene.name = "ball pressed locally";
  scene.key = "pressed";
  stop_by(beyond_probes, scene);
  return scene;
}

RelatedScene twisted_cube(const std::filesystem::path& scenes, int truth_meshes) {
  RelatedScene scene;
  scene.ours =
      ready(scenes / "cube_twist.toml", {"scene.frames=1-46", "muscle.cube.damping=10",
                                         "rig.clip.keys.twist=[[1, 0], [31, 90], [46, 90]]"});
  scene.name = "cube twisted by 90 degrees";
  scene.key = "cube";
  scene.surface = scene.ours.model->muscles[0].rest;
  scene.solid = corners_of(quadratic_cube(8));
  scene.held = [](const Vec3& p) { return std::abs(p.y()) > 0.0999; };
  drive_by(turned, scene);
  scene.truth.meshes = truth_meshes;
  scene.truth.coarsest = 2;
  scene.truth.body = quadratic_cube;
  return scene;
}

RelatedScene flexed_muscle(const std::filesystem::path& scenes, int truth_meshes) {
  RelatedScene scene;
  const BarShape shape;
  scene.ours = ready(scenes / "flexed.toml", {});
  scene.as_muscle = PaperAsk{scenes / "flexed_path.toml", {}, 0, {}, false};
  scene.name = "muscle flexed";
  scene.key = "flexed";
  scene.surface = scene.ours.model->muscles[0].rest;
  scene.size = shape.half.y();
  // An ellipsoid is a ball stretched, and so are the tetrahedra that fill it.
  TriMesh ball = scene.surface;
  for (Vec3& p : ball.vertices) p = p.cwiseQuotient(shape.half);
  scene.solid = fill_ball(ball, kPrintedBalls[0].tetrahedra);
  for (Vec3& p : scene.solid.vertices) p = p.cwiseProduct(shape.half);
  scene.held = [shape](const Vec3& p) { return std::abs(p.x()) >= shape.held - 1e-9; };
  drive_by(nearer, scene);
  scene.truth.meshes = truth_meshes;
  scene.truth.coarsest = 4;
  scene.truth.axis = 0;
  scene.truth.round = [shape](int n) {
    return round_spindle(shape.half.y(), shape.half.x(), shape.held, n, 3 * n);
  };
  scene.truth.drive_round = [](double share, RoundBody& body) {
    for (size_t i = 0; i < body.rest.size(); ++i) {
      const bool held = body.fixed[i][0] && body.fixed[i][1] && body.rest[i][1] > 0.0;
      if (held) body.x[i] = {body.rest[i][0], body.rest[i][1] - kNearer * share};
    }
  };
  return scene;
}

RivalBody body_of(const RelatedScene& scene, bool solid) {
  RivalBody body =
      solid ? solid_body(scene.solid, kDensity) : surface_body(scene.surface, kDensity);
  for (size_t i = 0; scene.held && i < body.rest.size(); ++i) {
    body.driven[i] = scene.held(body.rest[i]);
  }
  return body;
}

}  // namespace thew::tools
