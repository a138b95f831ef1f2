// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/lab/failure/cell.h"
#include "tools/lab/failure/loads.h"

namespace thew::tools {

/// A way of Thew's to step.
struct ThewMethod {
  const char* integrator;
  int iterations;
  std::vector<double> steps;  ///< s, from fine to coarse; quasi_static knows none
};
const std::vector<ThewMethod>& thew_methods();

/// What the rungs make of a run: the highest that any frame needed.
struct ThewRun {
  MapCell cell;  ///< not judged yet
  Points last;   ///< where it ends; empty: it did not come to its end
  std::string rung;
};
/// Runs all phases at a step of h seconds; `rungs`: as a bake does, what stands in for a failed
/// step included.
ThewRun run_thew_cell(const MapBody& body, Load load, double value, const ThewMethod& method,
                      double h, bool rungs);

}  // namespace thew::tools
