// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "tools/lab/related/arm.h"
#include "tools/lab/related/measure.h"

namespace thew::tools {

constexpr const char *kThew = "Thew, explicit", *kThewBare = "Thew, no volume",
                     *kThewImplicit = "Thew, implicit", *kThewMuscle = "Thew, its muscle";

/// All methods in one scene.
struct StudiedScene {
  RelatedScene scene;
  Truth truth;                       ///< no surface: none was asked for
  std::vector<RelatedSweep> sweeps;  ///< by method; no runs: the method is not for this scene
  std::vector<RelatedRun> thew;      ///< Thew itself
  bool whole = true;                 ///< false: each method at one dial, for cost and volume
};
struct Study {
  bool quick = false;
  std::vector<RelatedMethod> methods;
  std::vector<StudiedScene> scenes;
  std::vector<double> momentum, stiffening;  ///< by method, at its best dial; -1: has none
  std::vector<ArmSection> arm;

  /// Index of a method or a scene; -1: it is not there.
  int method(const std::string& name) const;
  int scene(const std::string& key) const;
  /// The best run of a method in a scene, or its cheapest; null: none.
  const RelatedRun* best(const std::string& name, const std::string& key) const;
  const RelatedRun* cheapest(const std::string& name, const std::string& key) const;
  /// Thew's own, the first of that name that did not fail.
  const RelatedRun* thew(const std::string& name, const std::string& key) const;
};
/// Runs everything; `done` is called after each of study_steps() parts.
/// `scenes`: of the paper; `arm`: the arm's.
Study run_study(const std::filesystem::path& scenes, const std::filesystem::path& arm, bool quick,
                const std::function<void()>& done);
int study_steps(bool quick);

}  // namespace thew::tools
