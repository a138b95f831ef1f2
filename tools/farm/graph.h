// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tools/farm/jobs.h"
#include "tools/farm/pilot.h"

namespace thew::tools {

/// One call of thew.
struct Task {
  std::string bake;  ///< ShotBake::name; "" of the report, which is the last task
  std::string shot;
  std::string step;                 ///< "bake", "chunk", "join", "pictures", "finish", "export"
  int part = 0;                     ///< among those of the same step of the bake, from 1 on
  std::vector<std::string> words;   ///< after the program's name
  std::vector<int> after;           ///< tasks that have to be done; of the report: over
  double seconds = 0.0;             ///< by the pilot
  int memory_mib = 0, minutes = 0;  ///< to be asked for: powers of two
};

/// "walk.hero.fine.chunk.3"
std::string name_of(const Task& task);

struct Graph {
  int threads = 1;          ///< of a task
  std::vector<Task> tasks;  ///< each after those that it depends on
  int bakes = 0, done = 0;  ///< of all; of these left out, since they are complete
};

/// Bakes whose folder holds a report of this very command, and all exports, are left out.
Graph plan_tasks(const Jobs& jobs, const Costs& costs);

}  // namespace thew::tools
