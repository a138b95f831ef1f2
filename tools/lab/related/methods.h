// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/lab/rivals/body.h"

namespace thew::tools {

/// A method at one value of what its paper leaves to the user.
struct RelatedDial {
  std::string label;  ///< "modulus 1e4 Pa"; may be empty
  std::function<Stepper(const RivalBody& body, double drag)> make;
  /// The same without what holds the volume; empty: it has no such part.
  std::function<Stepper(const RivalBody& body, double drag)> bare = {};
  /// In place of both where the method has no step: J, of the body stretched along its axes.
  std::function<double(const RivalBody& body, const Vec3& stretch)> energy = {}, bare_energy = {};
};
/// A method of the paper's sidebar, of its evaluation, or of today.
struct RelatedMethod {
  std::string name;       ///< "Promayon 1997"
  std::string what;       ///< in a few words
  bool solid = false;     ///< filled with tetrahedra
  bool has_step = true;   ///< no: each frame by itself, the same for any step
  bool meets = true;      ///< obstacles stop it; no: it only follows what is driven
  bool implicit = false;  ///< elements with a system to solve: few steps, each dear
  std::vector<RelatedDial> dials = {};
  std::string of = {};  ///< key of the one scene that it is for; empty: all
};
constexpr const char* kOurs = "Hong 2006, mended";  ///< the method that is compared with all others
/// Promayon's dial whose velocities do not know of the projection.
constexpr const char* kUnaware = "velocities as they are";
/// In the order of the table. The first dial of each is what `quick` takes alone.
std::vector<RelatedMethod> related_methods(bool quick);

}  // namespace thew::tools
