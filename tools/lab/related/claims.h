// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/lab/related/study.h"

namespace thew::tools {

/// What the paper says of its related work or of itself, and what our figures say to it.
struct RelatedClaim {
  std::string claim, figures;
  std::string verdict;  ///< "true", "false", "only ..." (where, or among what), "not run"
  /// "printed": a figure or picture of the paper says it; "its authors": the method's own paper
  /// does; "paraphrase": the sense of its sidebar, whose words are not at hand; "ours".
  std::string source = {};
};
std::vector<RelatedClaim> judge_claims(const Study& study);

}  // namespace thew::tools
