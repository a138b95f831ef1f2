// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/lab/related/study.h"

namespace thew::tools {

/// What the paper says of its related work or of itself, and what our figures say to it.
struct RelatedClaim {
  std::string claim, figures,
      verdict;  ///< verdict: "true", "false", "only ..." (where, or among what), "not run"
};
std::vector<RelatedClaim> judge_claims(const Study& study);

}  // namespace thew::tools
