// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/lab/failure/cell.h"
#include "tools/lab/failure/loads.h"
#include "tools/lab/related/methods.h"

namespace thew::tools {

/// Methods of others that can run a body by itself between planes or hands, at the first of their
/// dials; those of elements only where the body is filled.
std::vector<RelatedMethod> map_rivals(const MapBody& body);
/// Steps that a method is mapped at, s, from fine to coarse.
std::vector<double> rival_steps(const RelatedMethod& method);
/// Weights are Thew's alone.
bool can_load(Load load);

/// Runs all phases at a step of h seconds, with the scene's stiffness as far as the method has it.
/// The cell is not judged yet; `last`: where the surface ends.
MapCell run_rival_cell(const MapBody& body, Load load, double value, const RelatedMethod& method,
                       double h, Points& last);

}  // namespace thew::tools
