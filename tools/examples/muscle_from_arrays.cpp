// SPDX-License-Identifier: Apache-2.0
// A muscle between two bodies, from arrays alone: a spindle over an elbow that flexes by one
// radian. No file is read or written. Prints its volume in each frame, and ends with 1 where that
// is not the rest's to 1e-12.
#include <thew/thew.h>

#include <cmath>
#include <cstdio>

namespace {

// Rings of `around` vertices along -y from the origin to the insertion, and a pole at both ends.
thew::Mesh spindle(const thew::Vector3& from, double length, double radius, int around, int rings) {
  constexpr double kPi = 3.14159265358979323846;
  thew::Mesh mesh;
  const auto vertex = [&](double x, double y, double z) {
    mesh.positions.insert(mesh.positions.end(), {from[0] + x, from[1] + y, from[2] + z});
  };
  const auto triangle = [&](int a, int b, int c) {
    mesh.triangles.insert(mesh.triangles.end(), {a, b, c});
  };
  vertex(0, 0, 0);
  for (int ring = 1; ring <= rings; ++ring) {
    const double u = static_cast<double>(ring) / (rings + 1), r = radius * std::sin(kPi * u);
    for (int k = 0; k < around; ++k) {
      const double angle = 2 * kPi * k / around;
      vertex(r * std::cos(angle), -u * length, r * std::sin(angle));
    }
  }
  vertex(0, -length, 0);
  const int last = rings * around + 1;
  for (int k = 0; k < around; ++k) {
    const int next = (k + 1) % around;
    triangle(0, 1 + next, 1 + k);
    for (int ring = 0; ring + 1 < rings; ++ring) {
      const int a = 1 + ring * around + k, b = 1 + ring * around + next;
      triangle(a, b, a + around);
      triangle(b, b + around, a + around);
    }
    triangle(last, last - around + k, last - around + next);
  }
  return mesh;
}

thew::SceneDefinition elbow() {
  thew::SceneDefinition scene{.name = "elbow", .last_frame = 24};
  scene.bodies = {{.name = "humerus"},
                  {.name = "ulna",
                   .parent = "humerus",
                   .joint = {.kind = thew::Joint::Kind::kHinge,
                             .name = "elbow",
                             .position = {0, -0.3, 0},
                             .upper = 2.4}}};
  scene.clip = {.joints = {"elbow"}, .frames = {1, 24}, .values = {0, 1}};
  scene.muscles = {{.name = "flexor",
                    .mesh = spindle({0.03, -0.03, 0}, 0.32, 0.018, 12, 15),
                    .path = {{"humerus", {0.03, -0.03, 0}}, {"ulna", {0.03, -0.05, 0}}}}};
  return scene;
}

}  // namespace

int main() {
  try {
    const thew::SceneDefinition definition = elbow();
    const thew::Mesh& mesh = definition.muscles[0].mesh;
    const double rest = thew::enclosed_volume(mesh.positions, mesh.triangles);
    thew::Simulation simulation{thew::Scene(definition)};
    double worst = 0.0;
    for (int frame = 1; frame < definition.last_frame;) {
      frame = simulation.step();
      const double volume = thew::enclosed_volume(simulation.positions("flexor"), mesh.triangles);
      std::printf("frame %2d: %.12f cm3\n", frame, 1e6 * volume);
      worst = std::fmax(worst, std::fabs(volume / rest - 1.0));
    }
    std::printf("farthest from the rest's volume: %.1e of it\n", worst);
    return worst < 1e-12 ? 0 : 1;
  } catch (const thew::Error& error) {
    return std::fprintf(stderr, "%s\n", error.what()), 1;
  }
}
