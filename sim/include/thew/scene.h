// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "thew/mesh.h"

namespace thew {

// A scene from arrays. All lengths are in m, all angles in rad, +Y is up. Meshes, paths and bodies
// are given in the rest pose, in which all joint values are 0 and all bodies' axes are the world's.
// What is left out keeps its default. Vertices keep the order in which they are given, everywhere.

/// x, y, z.
using Vector3 = std::array<double, 3>;

/// How a body hangs on its parent.
struct Joint {
  enum class Kind {
    kFixed,
    kHinge,  ///< turns about the axis by its value (rad)
    kSlider  ///< shifts along the axis by its value (m)
  };
  Kind kind = Kind::kFixed;
  std::string name = {};             ///< that a clip calls it by; of hinges and sliders
  Vector3 position = {};             ///< of the body's frame, in its parent's
  Vector3 axis = {0, 0, 1};          ///< in the body's frame, of any length but 0
  double lower = -3.2, upper = 3.2;  ///< that its value may take
};
/// A rigid part of the rig. The first one is the root, with its frame at the world's origin; every
/// other comes after its parent.
struct Body {
  std::string name;
  std::string parent = {};  ///< "": it is the root
  Joint joint = {};
};
/// The motion: values of some joints in some frames, between which they run smoothly without
/// overshoot, and beyond which they are held. Joints that it does not name stay at 0.
struct Clip {
  std::vector<std::string> joints;
  std::vector<double> frames;  ///< rising
  std::vector<double> values;  ///< frame by frame, one for each joint
};

/// A point that a muscle's path passes through, fixed to a body.
struct PathPoint {
  std::string body;
  Vector3 position = {};  ///< in the body's frame
};
/// A cylinder fixed to a body, around which the path bends between its points `segment` and
/// `segment + 1`.
struct Wrap {
  int segment = 0;
  std::string body;
  Vector3 centre = {}, axis = {0, 0, 1};  ///< in the body's frame
  double radius = 0.0;
  double turn = 1.0;  ///< +1: counter-clockwise around it, seen from the axis' tip; or -1
};
/// Numbers by vertex of a mesh, by what they are of.
using Maps = std::map<std::string, std::vector<double>>;
/// How hard a muscle pulls by what a joint does: the sum of the curves and of the part of a load
/// that it holds, within 0 to 1.
struct JointActivation {
  std::string joint = {};                         ///< "": there is none
  std::vector<std::array<double, 2>> curve = {};  ///< (degrees, or m of a slider; activation)
  std::vector<std::array<double, 2>> speed = {};  ///< (degrees/s or m/s; activation)
  double load = 0.0;                              ///< kg, that hangs at a point of a body
  std::string load_body = {};
  Vector3 load_at = {};  ///< in the body's frame
};
struct Muscle {
  std::string name;
  Mesh mesh = {};  ///< closed, outward; vertices in one place are joined for the simulation
  std::vector<PathPoint> path = {};  ///< from origin to insertion, two points at least
  std::vector<Wrap> wraps = {};
  /// Along the path: where the belly begins and ends. Both 0: a tenth of the path from its ends.
  std::array<double, 2> belly = {0.0, 0.0};
  /// By vertex, 0 or more, in any unit: how much of the volume correction it takes (Hong et al.
  /// 2006, W in eqs 9 to 14). Empty: all alike.
  std::vector<double> weights = {};
  double stiffness = 1000.0;                           ///< N/m, of its surface across the fibres
  double f_max = 0.0;                                  ///< N, with which it can pull of itself
  std::vector<std::array<double, 2>> activation = {};  ///< (frame, 0 to 1), frames rising
  JointActivation by_joint = {};                       ///< in place of that
  /// "stiffness" (N/m) in place of the one above; "thickness" (m) that contact keeps free.
  Maps maps = {};
};
/// A rigid mesh fixed to a body. No two vertices in one place.
struct Bone {
  std::string name;
  std::string body;
  Mesh mesh = {};  ///< in the body's frame; closed, outward
};
/// A skin over muscles and bones. No two vertices in one place.
struct Skin {
  Mesh mesh = {};             ///< closed, outward; empty: there is no skin
  bool keeps_volume = false;  ///< what it encloses stays what it is at rest
  /// "fat" (m), by which the rest shape is moved over the flesh; "slide" (0 to 1), where 0 sticks
  /// to the flesh and 1 slides freely.
  Maps maps = {};
};
struct Solver {
  std::string integrator = "local_global";  ///< or explicit, xpbd, quasi_static
  int substeps = 1;                         ///< in each frame
  int iterations = 3;                       ///< in each substep
};
struct SceneDefinition {
  std::string name = "scene";
  double fps = 24.0;
  int first_frame = 1, last_frame = 1;
  double settle = 2.0;  ///< s at most, before the first frame
  Vector3 gravity = {0, -9.81, 0};
  double size = 1.0;  ///< this arm's length over a grown man's: scales the method's own lengths
  std::vector<Body> bodies = {};
  Clip clip = {};
  std::vector<Muscle> muscles = {};
  std::vector<Bone> bones = {};
  Skin skin = {};
  Solver solver = {};
};

/// What a scene is.
struct SceneInfo {
  std::string name;
  double fps = 24.0;
  int first_frame = 1, last_frame = 1;
  std::vector<std::string> joints;    ///< those that can move
  std::vector<std::string> meshes;    ///< muscles, then bones, then "skin" where there is one
  std::vector<std::string> warnings;  ///< what it may mean otherwise than it says
};

struct SceneData;

/// All that does not change while a scene is simulated, read and checked. Simulations and bakes
/// share it: it may go before them.
class Scene {
 public:
  /// Reads a scene file and all files that it names. Each setting is a key and its value as the
  /// command's --set takes them: "solver.iterations=5". Error with file, line, cause and next move:
  /// kUsage for the scene or a setting, kInput for a file that it names.
  static Scene read(const std::filesystem::path& file,
                    const std::vector<std::string>& settings = {});
  /// From arrays, which are copied; no file is read. Error(kUsage) names the part that does not
  /// fit.
  explicit Scene(const SceneDefinition& definition);
  Scene(Scene&&) noexcept = default;
  Scene& operator=(Scene&&) noexcept = default;

  const SceneInfo& info() const;

 private:
  friend struct SceneData;
  explicit Scene(std::shared_ptr<const SceneData> data);

  std::shared_ptr<const SceneData> data_;
};

}  // namespace thew
