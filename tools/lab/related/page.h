// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/lab/base/table.h"
#include "tools/lab/chart/run.h"
#include "tools/lab/related/study.h"

namespace thew::tools {

/// Cost against error: every method of one scene, its best and its cheapest setting.
Chart chart_of(const Study& study, const std::string& scene);

Table summary_of(const Study& study);  ///< a row for each method
Table claims_of(const Study& study);
Table truths_of(const Study& study);
std::vector<Table> runs_of(const Study& study);  ///< by scene: every setting

/// Pages, tables and charts of a study, below `folder`; `place` names and claims a file.
void write_study(const Study& study, double seconds,
                 const std::function<std::filesystem::path(const std::string&)>& place);

}  // namespace thew::tools
