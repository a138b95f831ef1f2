// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "rig/math.h"
#include "sim/scene/define_model.h"
#include "sim/scene/model.h"
#include "sim/scene/reader.h"
#include "sim/settle.h"
#include "sim/solver/state_archive.h"
#include "sim/step.h"
#include "tests/unit/rig/temp.h"
#include "tools/cli/commands.h"

namespace thew::tests {

namespace fs = std::filesystem;

inline const fs::path kFigure = fs::path(THEW_SOURCE_DIR) / "tests/scenes/figure/figure.gltf";

class NewScene : public TempFolder {
 protected:
  fs::path data(const char* name) { return fs::path(THEW_SHARED_DATA) / name; }
  NewOptions asked(const fs::path& character, const std::string& side, double scale = 1.0) {
    NewOptions options;
    options.character = character;
    options.out = folder / "character.toml";
    options.side = side;
    options.scale = scale;
    options.force = true;
    return options;
  }
};

struct Found {
  fs::path file;
  double scale;
};
// The project's own and, of the real inputs, those that are there.
inline std::vector<Found> characters() {
  std::vector<Found> found = {{kFigure, 1.0}};
  for (const auto& [name, scale] : {std::pair("cesium_man.gltf", 1.0), {"robot.glb", 0.4}}) {
    const fs::path file = fs::path(THEW_SHARED_DATA) / name;
    if (fs::exists(file)) {
      found.push_back({file, scale});
    } else {
      std::printf("%s is not there\n", name);
    }
  }
  return found;
}

// The new scene, settled.
struct MadeArm {
  Model model;
  Parallel parallel{1};
  State state;
  StageSeconds seconds;

  explicit MadeArm(const NewOptions& options, const std::vector<std::string>& overrides = {}) {
    EXPECT_EQ(new_command(options), ExitCode::kDone);
    model = build_model(read_scene(options.out, overrides));
    state = initial_state(model);
    settle(model, parallel, state);
  }
  void step(int frame) { step_frame(model, frame / 24.0, parallel, state, seconds); }
};

// Muscles, carried, and bones where the skin is tied to them: model.skinned->rest is the skin
// there.
struct TiedPose {
  std::vector<std::vector<Vec3>> muscles, bones;

  explicit TiedPose(const Model& model) {
    Pose pose;
    forward_kinematics(model.skeleton, model.character->skin_pose, pose);
    pose_limbs(model.skeleton, model.character->forearms, model.character->scapulae, pose);
    for (const Muscle& muscle : model.muscles) {
      Points x;
      carried_positions(muscle.shape, carry_pose(muscle.shape, pose), muscle.swells, x);
      muscles.emplace_back();
      for (const Point& p : x) muscles.back().push_back(to_vec(p));
    }
    for (const Bone& bone : model.bones) {
      bones.emplace_back();
      for (const Vec3& p : bone.in_body.vertices) bones.back().push_back(pose[bone.body] * p);
    }
  }
};

// Solid angle of the surface seen from p, over that of a sphere: 0 outside of all its shapes.
inline double winding(const TriMesh& mesh, const Vec3& p) {
  double sum = 0.0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[t[0]] - p, b = mesh.vertices[t[1]] - p,
               c = mesh.vertices[t[2]] - p;
    const double x = a.norm(), y = b.norm(), z = c.norm();
    sum +=
        2.0 * std::atan2(a.dot(b.cross(c)), x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y);
  }
  return sum / (4.0 * kPi);
}

// m, to the nearest point of any triangle: over its plane if that lies in it, else of its edges.
inline double distance(const TriMesh& mesh, const Vec3& p) {
  double least = 1.0;
  for (const Triangle& t : mesh.triangles) {
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    const Vec3 normal = (b - a).cross(c - a).normalized();
    bool over = true;
    for (const auto& [from, to] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)}) {
      const Vec3 edge = to - from, away = p - from;
      over = over && normal.dot(edge.cross(away)) >= 0.0;
      const double along = std::clamp(away.dot(edge) / edge.squaredNorm(), 0.0, 1.0);
      least = std::min(least, (away - along * edge).norm());
    }
    if (over) least = std::min(least, std::abs(normal.dot(p - a)));
  }
  return least;
}

inline std::string from_base64(const std::string& text) {
  const std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned value = 0;
  int bits = 0;
  for (size_t i = 0; i < text.size() && text[i] != '='; ++i) {
    value = value << 6 | static_cast<unsigned>(digits.find(text[i]));
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes.push_back(static_cast<char>(value >> bits & 255));
  }
  return bytes;
}

}  // namespace thew::tests
