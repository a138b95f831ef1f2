// SPDX-License-Identifier: Apache-2.0
#include "tools/farm/pilot.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "sim/cache/durable_file.h"
#include "tools/base/options.h"
#include "tools/base/printing.h"
#include "tools/base/signals.h"
#include "tools/base/temporary_folder.h"
#include "tools/farm/process.h"

namespace thew::tools {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr std::size_t kMostBytes = std::size_t{1} << 26;

fs::path file_of(const Jobs& jobs) { return jobs.out / "pilot.json"; }

void write_costs(const Jobs& jobs, const Costs& costs) {
  ordered_json json = ordered_json::object();
  for (const auto& [key, cost] : costs) {
    json[key] = {{"memory_mib", cost.memory_mib},
                 {"setup_seconds", cost.setup},
                 {"frame_seconds", cost.frame},
                 {"copy_seconds", cost.copy},
                 {"picture_seconds", cost.picture}};
  }
  sim::write_durably(file_of(jobs), json_text(json, 2) + "\n");
}

std::string frames_of_pilot(const Jobs& jobs, const ShotBake& bake) {
  // Of frames that stand alone the costly ones are anywhere; else all before are simulated as well.
  const std::size_t count = std::min(bake.frames.size(), static_cast<std::size_t>(jobs.pilot));
  std::string text;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at =
        bake.stands_alone && count > 1 ? i * (bake.frames.size() - 1) / (count - 1) : i;
    text += (text.empty() ? "" : ",") + std::to_string(bake.frames[at]);
  }
  return text;
}

Cost cost_of(const fs::path& report_file, const ShotBake& bake, double memory_mib) {
  std::ifstream file(report_file);
  const auto report = nlohmann::json::parse(file);
  const auto& seconds = report.at("seconds");
  const auto& frames = report.at("frames");
  const auto written = static_cast<double>(frames.size());
  const double simulated =
      bake.stands_alone ? written : frames.back().get<int>() - bake.frames.back() + bake.simulated;
  Cost cost;
  cost.memory_mib = memory_mib;
  for (const char* stage : {"setup", "settle", "report"})
    cost.setup += seconds.at(stage).get<double>();
  for (const char* stage : {"measure", "rig", "muscles", "contact", "skin", "write"}) {
    cost.frame += seconds.at(stage).get<double>() / simulated;
  }
  for (const char* stage : {"measure", "write"}) {
    cost.copy += seconds.at(stage).get<double>() / written;
  }
  cost.picture = seconds.at("render").get<double>() / written;
  return cost;
}

Cost measure(const Jobs& jobs, const ShotBake& bake, const fs::path& program) {
  const TemporaryFolder folder("pilot");
  std::vector<std::string> words = {program.string(), "bake", bake.scene.string(), "--out",
                                    (folder.path() / "bake").string()};
  for (const std::string& set : bake.overrides) words.insert(words.end(), {"--set", set});
  words.insert(words.end(),
               {"--frames", frames_of_pilot(jobs, bake), "--threads", std::to_string(jobs.threads),
                "--bounds", "warn", "--progress", "none"});
  const fs::path log = folder.path() / "log";
  const Ended ended = wait_for(start(words, log));
  stop_if_interrupted();
  if (ended.code != 0) {
    throw Error(ErrorCode::kUsage, bake.name + ": its pilot ended with " +
                                       std::to_string(ended.code) + ": " +
                                       sim::read_whole_file(log, kMostBytes) +
                                       "; mend it and run again: " + command_text(words));
  }
  return cost_of(folder.path() / "bake/report.json", bake, ended.memory_mib);
}

}  // namespace

Costs read_costs(const Jobs& jobs) {
  const fs::path file = file_of(jobs);
  Costs costs;
  if (!fs::exists(file)) return costs;
  try {
    const auto json = nlohmann::json::parse(sim::read_whole_file(file, kMostBytes));
    for (const auto& item : json.items()) {
      const auto read = [&](const char* name) {
        return std::clamp(item.value().at(name).get<double>(), 0.0, 1e9);
      };
      costs[item.key()] = {read("memory_mib"), read("setup_seconds"), read("frame_seconds"),
                           read("copy_seconds"), read("picture_seconds")};
    }
  } catch (const nlohmann::json::exception&) {
    throw Error(ErrorCode::kInput,
                file.string() + ": is not what a pilot writes; remove it and run again");
  }
  return costs;
}

Costs measure_costs(const Jobs& jobs, const fs::path& program, bool overwrite) {
  sim::create_folders(jobs.out);
  sim::claim({file_of(jobs)}, overwrite);
  Costs costs = read_costs(jobs);
  for (const ShotBake& bake : jobs.bakes) {
    if (costs.contains(bake.costs_as)) continue;
    std::fprintf(stderr, "thew: pilot: %s\n", bake.name.c_str());
    costs[bake.costs_as] = measure(jobs, bake, program);
    write_costs(jobs, costs);
  }
  return costs;
}

}  // namespace thew::tools
