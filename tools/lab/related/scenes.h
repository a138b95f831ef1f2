// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "tools/lab/paper/run.h"
#include "tools/lab/related/truth.h"
#include "tools/lab/rivals/body.h"

namespace thew::tools {

/// A scene of Thew's and the same for all other methods: what moves the body, and where it then is.
/// It moves for a second and is held for half of one.
struct RelatedScene {
  std::string name, key;  ///< for people; for files and choices
  PaperScene ours;
  std::optional<PaperAsk> as_muscle;  ///< Thew's own with a path, where it is a muscle
  TriMesh surface;
  TetMesh solid;
  Surroundings around;
  std::function<bool(const Vec3& rest)> held;  ///< nodes that the surroundings drive; may be empty
  double size = 0.1;                           ///< m, what distances are a share of
  TruthScene truth;                            ///< no meshes: none

  int frames() const { return ours.model->last_frame - ours.model->first_frame; }
  double frame_seconds() const { return 1.0 / ours.model->fps; }
};

constexpr double kDrag = 10.0;       ///< 1/s, of all methods: the hold damps what the way stirred
constexpr double kDensity = 1060.0;  ///< kg/m^3
constexpr double kShear = 1000.0;    ///< Pa, of what has an inside

/// The ball of a row of table 1 between two planes.
RelatedScene squeezed_ball(const std::filesystem::path& scenes, int triangles, int tetrahedra,
                           int truth_meshes);
RelatedScene pressed_ball(const std::filesystem::path& scenes, int truth_meshes);
RelatedScene twisted_cube(const std::filesystem::path& scenes, int truth_meshes);
RelatedScene flexed_muscle(const std::filesystem::path& scenes, int truth_meshes);

/// The scene's body as a method needs it, driven nodes marked.
RivalBody body_of(const RelatedScene& scene, bool solid);

}  // namespace thew::tools
