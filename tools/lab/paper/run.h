// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "sim/cache/cache.h"
#include "sim/scene/define_model.h"
#include "sim/solver/state.h"
#include "tools/lab/base/measures.h"

namespace thew::tools {

/// One run of a scene, frame by frame, on one thread.
struct PaperRun {
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const Model> model;
  State state;                        ///< at the last frame
  double seconds = 0.0;               ///< CPU, a frame, the mean of all
  double volume_error = 0.0;          ///< |V/V0 - 1|, largest of all frames and bodies
  std::vector<double> volume_errors;  ///< the same by body
  double penetration = 0.0;           ///< m, largest of all frames: free nodes inside bones
  double pressing = 0.0;  ///< nodes of the first body that press on something, mean of frames
  std::vector<int> frames;
  std::vector<double> volume;       ///< V/V0 of the first body by frame
  std::vector<double> zone_radius;  ///< m, of the first body by frame
  std::map<int, State> kept;        ///< at the asked frames
};
struct PaperAsk {
  std::filesystem::path scene;
  std::vector<std::string> overrides;
  int last = 0;           ///< frame; 0: the scene's own
  std::vector<int> keep;  ///< frames whose states are kept
  bool measures = false;  ///< penetration too; not to be timed
};
/// Read and settled, to be run more than once.
struct PaperScene {
  PaperAsk ask;
  std::shared_ptr<const Scene> scene;
  std::shared_ptr<const Model> model;
  State start;
};
PaperScene ready_scene(const PaperAsk& ask);
PaperRun run_scene(const PaperScene& scene);
PaperRun run_scene(const PaperAsk& ask);
/// Only timed, several scenes in turn, frame by frame, so that what else the machine does meets all
/// of them alike: CPU seconds a frame by scene, the mean over frames of each one's median over the
/// repetitions.
std::vector<double> time_scenes(const std::vector<PaperScene>& scenes, int repetitions,
                                const std::function<void()>& on_run);

std::vector<Vec3> points_of(const Points& rows);

/// What of a state is drawn.
struct PaperView {
  std::string name;      ///< of the scene's views, "" for the first
  bool bones = true;     ///< drawn too
  bool weights = false;  ///< muscles coloured by the weights that the volume is moved with,
  std::vector<double> values =
      {};  ///< or by these of the first one's nodes, scaled to their largest
};
/// As Renderer takes it.
struct PaperPicture {
  int width, height;
  SceneView view;
  std::vector<BakeMesh> meshes;
  std::vector<std::vector<Vec3>> positions;
};
PaperPicture picture_of(const PaperRun& run, const State& state, const PaperView& view);
/// The same view, another surface.
PaperPicture picture_of(const Scene& scene, const TriMesh& mesh);

}  // namespace thew::tools
