// SPDX-License-Identifier: Apache-2.0
//
// thew new on a figure of boxes, as games have them: each rigid, closed, and ending at a joint.
#include "tests/unit/tools/fit/new_figure.h"

namespace thew::tests {
namespace {

// From one place to another, on one joint.
void add_box(const Vec3& from, const Vec3& to, double half_width, std::uint8_t joint,
             Figure::Mesh& mesh) {
  const Vec3 a = half_width * (to - from).unitOrthogonal();
  const Vec3 b = half_width * (to - from).normalized().cross(a / half_width);
  const int first = static_cast<int>(mesh.positions.size());
  for (const Vec3& end : {from, to}) {
    for (const Vec3& corner : {Vec3(-a - b), Vec3(a - b), Vec3(a + b), Vec3(b - a)}) {
      mesh.positions.push_back(end + corner);
      mesh.joints.push_back({joint, 0, 0, 0});
      mesh.weights.push_back({1.0f, 0.0f, 0.0f, 0.0f});
    }
  }
  const auto add_face = [&](int p, int q, int r, int s) {
    mesh.triangles.push_back({first + p, first + q, first + r});
    mesh.triangles.push_back({first + p, first + r, first + s});
  };
  add_face(3, 2, 1, 0);
  add_face(4, 5, 6, 7);
  for (int k = 0; k < 4; ++k) add_face(k, (k + 1) % 4, (k + 1) % 4 + 4, k + 4);
}

Figure of_boxes() {
  Figure figure;
  Figure::Mesh boxes;
  boxes.name = "Boxes";
  const auto place = [&](int joint) { return figure.joints[joint].place; };
  add_box(place(0), place(1) + Vec3(0.0, 0.2, 0.0), 0.12, 0, boxes);
  for (const int arm : {3, 7}) {
    add_box(place(arm), place(arm + 1), 0.06, static_cast<std::uint8_t>(arm), boxes);
    add_box(place(arm + 1), place(arm + 2), 0.055, static_cast<std::uint8_t>(arm + 1), boxes);
    add_box(place(arm + 2), 1.5 * place(arm + 2) - 0.5 * place(arm + 1), 0.05,
            static_cast<std::uint8_t>(arm + 2), boxes);
  }
  figure.meshes = {boxes};
  return figure;
}

// A way out of the flesh through the end of a box is none: muscles were threads at the elbow.
TEST_F(NewScene, MusclesGoOnFromBoxToBox) {
  of_boxes().write(folder / "boxes.gltf");
  NewOptions options = asked(folder / "boxes.gltf", "both");
  options.out = folder / "scene" / "boxes.toml";
  ASSERT_EQ(new_command(options), ExitCode::kDone);
  const Model model = build_model(read_scene(options.out, {"skin.enabled=false"}));
  ASSERT_EQ(model.muscles.size(), 24u);
  double right = 0.0, left = 0.0;
  for (const Muscle& muscle : model.muscles) {
    (muscle.name.ends_with("_right") ? right : left) += muscle.rest_volume;
  }
  std::printf("%.0f and %.0f cm3\n", 1e6 * right, 1e6 * left);
  // Of the boxes' flesh, a tenth at least.
  EXPECT_GT(std::min(right, left), 0.1 * 0.12 * 0.12 * 0.48);
}

}  // namespace
}  // namespace thew::tests
