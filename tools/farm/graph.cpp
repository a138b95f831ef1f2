// SPDX-License-Identifier: Apache-2.0
#include "tools/farm/graph.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <span>

#include "sim/cache/own_files.h"
#include "tools/base/options.h"
#include "tools/export/sequence.h"

namespace thew::tools {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

// What is asked for is more than the pilot took: its frames are the first ones, which are often the
// calm ones. A time that is too short costs a round (TERM, 75, again), too little memory the task.
constexpr double kMemoryTimes = 1.5, kMemoryMore = 128.0;  // MiB
constexpr double kTimeTimes = 4.0, kTimeMore = 120.0;      // s

int power_of_two(double least) {
  int power = 1;
  while (power < least && power < (1 << 30)) power *= 2;
  return power;
}

// "1-10", "1-19x2" or a list, as --frames reads it.
std::string frames_text(std::span<const int> frames) {
  if (frames.size() == 1) return std::to_string(frames.front());
  const int step = frames[1] - frames[0];
  bool even = true;
  for (std::size_t i = 1; i < frames.size(); ++i) even = even && frames[i] - frames[i - 1] == step;
  if (even) {
    return std::to_string(frames.front()) + "-" + std::to_string(frames.back()) +
           (step == 1 ? "" : "x" + std::to_string(step));
  }
  std::string list;
  for (const int frame : frames) list += (list.empty() ? "" : ",") + std::to_string(frame);
  return list;
}

/// Adds the tasks of one bake.
struct BakePlanner {
  const Jobs& jobs;
  const ShotBake& bake;
  const Cost& cost;
  Graph& graph;

  Words words_of(const std::string& command, const fs::path& input, const fs::path& out) const {
    Words words = {command, input.string()};
    if (!out.empty()) words.insert(words.end(), {"--out", out.string()});
    return words;
  }
  // What all that reads the scene says of it.
  void add_scene(Words& words, std::span<const int> frames) const {
    for (const std::string& set : bake.overrides) words.insert(words.end(), {"--set", set});
    words.insert(words.end(),
                 {"--frames", frames_text(frames), "--threads", std::to_string(jobs.threads)});
  }
  Words bake_words(const fs::path& out, std::span<const int> frames, const Words& more) const {
    Words words = words_of("bake", bake.scene, out);
    add_scene(words, frames);
    words.insert(words.end(), more.begin(), more.end());
    words.insert(words.end(), {"--bounds", "warn", "--resume"});
    return words;
  }
  int add(const std::string& step, Words words, std::vector<int> after, double seconds,
          int part = 1) const {
    words.insert(words.end(), {"--progress", "plain"});
    Task task{bake.name, bake.shot, step, part, std::move(words), std::move(after)};
    task.seconds = seconds;
    task.memory_mib = power_of_two(kMemoryTimes * cost.memory_mib + kMemoryMore);
    task.minutes = power_of_two((kTimeTimes * seconds + kTimeMore) / 60.0);
    graph.tasks.push_back(std::move(task));
    return static_cast<int>(graph.tasks.size()) - 1;
  }

  bool draws_apart() const { return jobs.pictures > 0 && bake.has_views; }
  /// The command that writes the last report.
  Words last_words() const {
    const fs::path chunks = chunks_folder();
    if (draws_apart() || !is_chunked()) return bake_words(bake.folder, bake.frames, {});
    return bake_words(bake.folder, bake.frames, {"--join", chunks.string()});
  }
  bool is_chunked() const {
    return bake.stands_alone && jobs.chunk > 0 &&
           bake.frames.size() > static_cast<std::size_t>(jobs.chunk);
  }
  fs::path chunks_folder() const { return bake.folder.string() + ".chunks"; }

  template <typename Add>
  void for_each_range(int size, const Add& add_range) const {
    const std::span<const int> all(bake.frames);
    int part = 0;
    for (std::size_t i = 0; i < all.size(); i += static_cast<std::size_t>(size)) {
      add_range(++part, all.subspan(i, std::min(all.size() - i, static_cast<std::size_t>(size))));
    }
  }

  // The frames, and what of them is done by whom.
  int add_frames() const {
    const auto count = static_cast<double>(bake.frames.size());
    const double simulated = bake.stands_alone ? count : bake.simulated;
    const double drawn = bake.has_views && !draws_apart() ? count * cost.picture : 0.0;
    Words more;
    if (draws_apart()) more.push_back("--no-render");
    if (!is_chunked()) {
      return add("bake", bake_words(bake.folder, bake.frames, more), {},
                 cost.setup + simulated * cost.frame + drawn);
    }
    std::vector<int> chunks;
    for_each_range(jobs.chunk, [&](int part, std::span<const int> frames) {
      chunks.push_back(add("chunk",
                           bake_words(chunks_folder() / std::to_string(part), frames, {"--chunk"}),
                           {}, cost.setup + static_cast<double>(frames.size()) * cost.frame, part));
    });
    more.insert(more.end(), {"--join", chunks_folder().string()});
    return add("join", bake_words(bake.folder, bake.frames, more), chunks,
               cost.setup + count * cost.copy + drawn);
  }

  void add_all() const {
    const int baked = add_frames();
    const fs::path cache = bake.folder / "bake.h5";
    const auto count = static_cast<double>(bake.frames.size());
    if (draws_apart()) {
      std::vector<int> drawn;
      for_each_range(jobs.pictures, [&](int part, std::span<const int> frames) {
        Words words = words_of("render", cache, bake.folder / "frames");
        words.insert(words.end(), {"--scene", bake.scene.string()});
        add_scene(words, frames);
        words.push_back("--chunk");
        drawn.push_back(add("pictures", words, {baked},
                            cost.setup + static_cast<double>(frames.size()) * cost.picture, part));
      });
      add("finish", last_words(), drawn, cost.setup + count * cost.copy);
    }
    int part = 0;
    for (const std::string& name : jobs.exports) {
      add("export", {"export", cache.string(), (bake.folder / name).string()}, {baked},
          cost.setup + count * cost.copy, ++part);
    }
  }
};

bool is_baked(const fs::path& folder, const Words& words) {
  std::ifstream file(folder / "report.json");
  const auto report = nlohmann::json::parse(file, nullptr, false);
  if (!report.is_object() || !report.contains("origin") || !report["origin"].is_object()) {
    return false;
  }
  const auto command = report["origin"].find("command");
  return command != report["origin"].end() && command->is_string() &&
         (command->get<std::string>() + " ").find(" " + command_text(words) + " ") !=
             std::string::npos;
}

bool is_done(const Jobs& jobs, const BakePlanner& planner) {
  const fs::path& folder = planner.bake.folder;
  if (!is_baked(folder, planner.last_words())) return false;
  const auto is_written = [](const fs::path& file) {
    std::error_code error;
    return fs::exists(file, error) && sim::own_file(file);
  };
  return std::all_of(jobs.exports.begin(), jobs.exports.end(), [&](const std::string& name) {
    return is_written(folder / name) ||
           is_written(sequence_file(folder / name, planner.bake.frames.back()));
  });
}

void add_report(const Jobs& jobs, Graph& graph) {
  Words words = {"report"};
  for (const ShotBake& bake : jobs.bakes) words.push_back(bake.folder.string());
  words.insert(words.end(), {"--html", (jobs.out / "report.html").string(), "--json",
                             (jobs.out / "report.json").string()});
  std::vector<bool> waited_for(graph.tasks.size(), false);
  for (const Task& task : graph.tasks) {
    for (const int other : task.after) waited_for[static_cast<std::size_t>(other)] = true;
  }
  Task task;
  task.step = "report";
  task.part = 1;
  task.words = std::move(words);
  for (std::size_t i = 0; i < graph.tasks.size(); ++i) {
    if (!waited_for[i]) task.after.push_back(static_cast<int>(i));
  }
  task.seconds = 0.05 * static_cast<double>(jobs.bakes.size());
  task.memory_mib = 1024;
  task.minutes = power_of_two((kTimeTimes * task.seconds + kTimeMore) / 60.0);
  graph.tasks.push_back(std::move(task));
}

}  // namespace

std::string name_of(const Task& task) {
  std::string name = task.bake + (task.bake.empty() ? "" : "/") + task.step;
  std::replace(name.begin(), name.end(), '/', '.');
  return name + "." + std::to_string(task.part);
}

Graph plan_tasks(const Jobs& jobs, const Costs& costs) {
  Graph graph;
  graph.threads = jobs.threads;
  graph.bakes = static_cast<int>(jobs.bakes.size());
  const Cost unknown;
  for (const ShotBake& bake : jobs.bakes) {
    const auto cost = costs.find(bake.costs_as);
    const BakePlanner planner{jobs, bake, cost == costs.end() ? unknown : cost->second, graph};
    if (is_done(jobs, planner)) {
      ++graph.done;
    } else {
      planner.add_all();
    }
  }
  add_report(jobs, graph);
  return graph;
}

}  // namespace thew::tools
