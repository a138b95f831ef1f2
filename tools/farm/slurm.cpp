// SPDX-License-Identifier: Apache-2.0
//
// Bakes whose tasks are alike, step by step and in what they ask for, go together: the same step of
// all of them is an array, and an array waits for another one task by task (aftercorr).
#include <algorithm>
#include <map>

#include "sim/cache/durable_file.h"
#include "tools/base/options.h"
#include "tools/farm/engines.h"

namespace thew::tools {

extern const char* const kRunSh;
extern const char* const kSubmitSh;

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLongestArray = 1000;  // Slurm's default, MaxArraySize=1001

/// The tasks of a bake are `count` from `first` on.
struct BakeTasks {
  std::size_t first = 0, count = 0;
};

std::vector<BakeTasks> bakes_of(const Graph& graph) {
  std::vector<BakeTasks> bakes;
  std::string last;
  for (std::size_t i = 0; i < graph.tasks.size(); ++i) {
    const std::string& bake = graph.tasks[i].bake;
    if (bake.empty()) continue;
    if (bake != last) bakes.push_back({i, 0});
    last = bake;
    ++bakes.back().count;
  }
  return bakes;
}

// What two bakes have to have in common.
std::string shape_of(const Graph& graph, const BakeTasks& bake) {
  std::string shape;
  for (std::size_t i = bake.first; i < bake.first + bake.count; ++i) {
    const Task& task = graph.tasks[i];
    shape += task.step + std::to_string(task.part) + "," + std::to_string(task.memory_mib) + "," +
             std::to_string(task.minutes);
    for (const int other : task.after)
      shape += "<" + std::to_string(static_cast<std::size_t>(other) - bake.first);
    shape += ";";
  }
  return shape;
}

/// tasks.txt and arrays.txt as they grow.
struct Lists {
  const Graph& graph;
  std::string program;
  std::string tasks, arrays;
  int lines = 0;
  std::vector<std::string> array_of;  ///< by task

  void add_line(const Task& task) {
    std::vector<std::string> words = task.words;
    words.insert(words.begin(), program);
    tasks += command_text(words) + "\n";
    ++lines;
  }
  // NAME FIRST COUNT THREADS MEMORY MINUTES HOW [NAME...]
  void add_array(const std::string& name, std::size_t count, const Task& like, const char* how) {
    arrays += name + " " + std::to_string(lines + 1) + " " + std::to_string(count) + " " +
              std::to_string(graph.threads) + " " + std::to_string(like.memory_mib) + " " +
              std::to_string(like.minutes) + " " + (like.after.empty() ? "none" : how);
    std::vector<std::string> named;
    for (const int other : like.after) {
      const std::string& array = array_of[static_cast<std::size_t>(other)];
      if (std::find(named.begin(), named.end(), array) == named.end()) named.push_back(array);
    }
    for (const std::string& one : named) arrays += " " + one;
    arrays += "\n";
  }
  void add_group(const std::string& group, const std::vector<BakeTasks>& bakes) {
    for (std::size_t step = 0; step < bakes.front().count; ++step) {
      const Task& like = graph.tasks[bakes.front().first + step];
      const std::string name = group + "." + like.step + "." + std::to_string(like.part);
      add_array(name, bakes.size(), like, "aftercorr");
      for (const BakeTasks& bake : bakes) {
        const std::size_t task = bake.first + step;
        array_of[task] = name;
        add_line(graph.tasks[task]);
      }
    }
  }
};

// The next number, or the last one that was never submitted.
fs::path new_folder(const fs::path& folder) {
  int number = 1;
  while (fs::exists(folder / std::to_string(number) / "submitted.txt")) ++number;
  return folder / std::to_string(number);
}

}  // namespace

fs::path write_slurm(const Graph& graph, const fs::path& program, const fs::path& folder,
                     bool overwrite) {
  const fs::path here = new_folder(fs::absolute(folder).lexically_normal());
  Lists lists{graph, program.string(), "", "", 0, std::vector<std::string>(graph.tasks.size())};
  std::vector<std::string> shapes;  // as they come
  std::map<std::string, std::vector<BakeTasks>> groups;
  for (const BakeTasks& bake : bakes_of(graph)) {
    const std::string shape = shape_of(graph, bake);
    if (!groups.contains(shape)) shapes.push_back(shape);
    groups[shape].push_back(bake);
  }
  int group = 0;
  for (const std::string& shape : shapes) {
    const std::vector<BakeTasks>& bakes = groups[shape];
    for (std::size_t i = 0; i < bakes.size(); i += kLongestArray) {
      const auto begin = bakes.begin() + static_cast<std::ptrdiff_t>(i);
      const auto count = std::min(kLongestArray, bakes.size() - i);
      lists.add_group(std::to_string(++group), {begin, begin + static_cast<std::ptrdiff_t>(count)});
    }
  }
  lists.add_array("report", 1, graph.tasks.back(), "afterany");
  lists.add_line(graph.tasks.back());
  sim::create_folders(here / "logs");
  fs::path submit = here / "submit.sh";
  const fs::path run = here / "run.sh";
  sim::claim({submit, run, here / "tasks.txt", here / "arrays.txt"}, overwrite);
  sim::write_durably(here / "tasks.txt", lists.tasks);
  sim::write_durably(here / "arrays.txt", lists.arrays);
  sim::write_durably(run, kRunSh);
  sim::write_durably(submit, kSubmitSh);
  for (const fs::path& script : {run, submit}) {
    fs::permissions(script, fs::perms::owner_exec | fs::perms::group_exec | fs::perms::others_exec,
                    fs::perm_options::add);
  }
  return submit;
}

}  // namespace thew::tools
