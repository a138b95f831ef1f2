// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rig/types.h"
#include "tools/base/median.h"
#include "tools/render/camera.h"

namespace thew::tools {

double cpu_seconds();  ///< of the calling thread

/// What the points lie in; the first `count` of them, 0: all.
Bounds bounds_of(const std::vector<Vec3>& points, std::size_t count = 0);

/// How far nodes are from where another run has them, over all that were added.
struct NodeDistance {
  double largest = 0.0, sum = 0.0, count = 0.0;  ///< mm, mm^2, nodes
  double rms() const;                            ///< mm
};
/// Adds the nodes of a muscle. The largest distance (mm) of these alone.
double add_distance(const Points& here, const Points& there, NodeDistance& out);

/// Reads a program's arguments and does its work: the exit code. An error is one line on standard
/// error, "PROGRAM: what is wrong".
int run_or_tell(const char* program, int (*run)(int argc, char** argv), int argc, char** argv);

}  // namespace thew::tools
