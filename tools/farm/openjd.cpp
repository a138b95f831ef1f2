// SPDX-License-Identifier: Apache-2.0
//
// Open Job Description, template schemas 2023-09. A step depends on whole steps, never on single
// tasks: so a shot is a job, and each step of each of its bakes is a step. The tasks of a step
// differ in some words only; these are its task parameters, named after their options.
#include <algorithm>
#include <cctype>
#include <map>
#include <nlohmann/json.hpp>

#include "sim/cache/durable_file.h"
#include "tools/base/printing.h"
#include "tools/farm/engines.h"

namespace thew::tools {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr std::size_t kLongestRange = 1000;  // the schema allows 1024 values
constexpr std::size_t kLongestName = 64, kLongestValue = 1024;
constexpr int kNotice = 45;  // s between TERM and KILL: time for the frame that is being solved

/// The folders that the templates give as parameters, so that a farm can map them.
struct Places {
  std::string bakes, scenes;
};

// The word with its folder as a parameter.
std::string mapped(const std::string& word, const Places& places) {
  if (word.find("{{") != std::string::npos) {
    throw Error(ErrorCode::kUsage, word + ": Open Job Description has no way to say {{; rename it");
  }
  const auto below = [&](const std::string& folder, const char* parameter, std::string& out) {
    if (word != folder && !word.starts_with(folder + "/")) return false;
    out = std::string("{{Param.") + parameter + "}}" + word.substr(folder.size());
    return true;
  };
  std::string text = word;
  if (!below(places.bakes, "Bakes", text)) below(places.scenes, "Scenes", text);
  return text;
}

std::vector<std::string> words_of(const Task& task, const Places& places) {
  std::vector<std::string> words;
  for (const std::string& word : task.words) {
    const bool style = !words.empty() && words.back() == "--progress";
    words.push_back(style ? "openjd" : mapped(word, places));
  }
  return words;
}

// "--frames" -> "Frames", "Frames2" where that is taken.
std::string parameter_name(const std::string& before, const ordered_json& definitions) {
  std::string name;
  for (const char c : before) {
    if (std::isalpha(static_cast<unsigned char>(c))) name += c;
  }
  if (name.empty() || !before.starts_with("--")) name = "file";
  name[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(name[0])));
  const std::string plain = name;
  const auto taken = [&](const ordered_json& one) { return one["name"] == name; };
  for (int k = 2; std::any_of(definitions.begin(), definitions.end(), taken); ++k) {
    name = plain + std::to_string(k);
  }
  return name;
}

// The folders that words have in common. They stay outside of parameters: what a job parameter of
// type PATH is becomes known where a task runs, too late for the list of a task parameter's values.
std::size_t common_folders(const std::vector<std::vector<std::string>>& tasks, std::size_t word) {
  const std::string& first = tasks.front()[word];
  std::size_t same = first.size();
  for (const auto& words : tasks) {
    const auto end =
        std::mismatch(first.begin(), first.end(), words[word].begin(), words[word].end());
    same = std::min(same, static_cast<std::size_t>(end.first - first.begin()));
  }
  const std::size_t slash = first.rfind('/', same == 0 ? 0 : same - 1);
  return slash == std::string::npos || slash >= same ? 0 : slash + 1;
}

// Words that are the same in all tasks stand as they are; the others become parameters, which are
// combined task by task.
ordered_json script_of(const std::vector<std::vector<std::string>>& tasks,
                       ordered_json& definitions) {
  ordered_json args = ordered_json::array();
  for (std::size_t w = 0; w < tasks.front().size(); ++w) {
    const std::string& like = tasks.front()[w];
    const auto same = [&](const auto& words) { return words[w] == like; };
    if (std::all_of(tasks.begin(), tasks.end(), same)) {
      args.push_back(like);
      continue;
    }
    ordered_json values = ordered_json::array();
    const std::size_t folders = common_folders(tasks, w);
    for (const auto& words : tasks) values.push_back(words[w].substr(folders));
    for (const auto& value : values) {
      if (value.get_ref<const std::string&>().size() <= kLongestValue) continue;
      throw Error(ErrorCode::kUsage, value.get<std::string>().substr(0, 40) +
                                         "...: is longer than the 1024 characters of a task "
                                         "parameter; give evenly spaced frames or shorter names");
    }
    const std::string name = parameter_name(tasks.front()[w - 1], definitions);
    definitions.push_back({{"name", name}, {"type", "STRING"}, {"range", values}});
    args.push_back(like.substr(0, folders) + "{{Task.Param." + name + "}}");
  }
  return {{"actions",
           {{"onRun",
             {{"command", "{{Param.Thew}}"},
              {"args", args},
              {"cancelation",
               {{"mode", "NOTIFY_THEN_TERMINATE"}, {"notifyPeriodInSeconds", kNotice}}}}}}}};
}

/// The steps of a job as they are added.
struct Steps {
  const Graph& graph;
  Places places;
  ordered_json steps = ordered_json::array();
  std::map<int, std::string> step_of;  ///< name, by task

  std::string name_of_step(const Task& task) const {
    std::string name = std::to_string(steps.size() + 1) + " " + task.step + " " + task.bake;
    return name.substr(0, kLongestName);
  }

  /// Tasks `first` and on, alike but for some words.
  void add(int first, std::size_t count) {
    const Task& like = graph.tasks[static_cast<std::size_t>(first)];
    ordered_json step = {{"name", name_of_step(like)}};
    std::vector<std::string> names;
    std::vector<std::vector<std::string>> words;
    for (std::size_t i = 0; i < count; ++i) {
      const Task& task = graph.tasks[static_cast<std::size_t>(first) + i];
      words.push_back(words_of(task, places));
      step_of[first + static_cast<int>(i)] = step["name"];
      for (const int other : task.after) {
        const auto found = step_of.find(other);
        if (found == step_of.end()) continue;  // of another job: the report's
        if (std::find(names.begin(), names.end(), found->second) == names.end()) {
          names.push_back(found->second);
        }
      }
    }
    for (const std::string& name : names) step["dependencies"].push_back({{"dependsOn", name}});
    step["hostRequirements"]["amounts"] = {
        {{"name", "amount.worker.vcpu"}, {"min", graph.threads}},
        {{"name", "amount.worker.memory"}, {"min", like.memory_mib}}};
    ordered_json definitions = ordered_json::array();
    const ordered_json script = script_of(words, definitions);
    if (!definitions.empty()) {
      std::string combination;
      for (const auto& one : definitions) {
        combination += (combination.empty() ? "" : ", ") + one["name"].get<std::string>();
      }
      step["parameterSpace"] = {{"taskParameterDefinitions", definitions},
                                {"combination", "(" + combination + ")"}};
    }
    step["script"] = script;
    steps.push_back(std::move(step));
  }
};

fs::path write_job(const std::string& name, const Steps& steps, const fs::path& program,
                   const fs::path& folder, bool overwrite) {
  const auto path = [&](const char* parameter, const std::string& place, const char* flow) {
    return ordered_json{{"name", parameter},
                        {"type", "PATH"},
                        {"objectType", "DIRECTORY"},
                        {"dataFlow", flow},
                        {"default", fs::path(place).lexically_relative(folder).string()}};
  };
  const ordered_json job = {{"specificationVersion", "jobtemplate-2023-09"},
                            {"name", name},
                            {"parameterDefinitions",
                             {{{"name", "Thew"}, {"type", "STRING"}, {"default", program.string()}},
                              path("Bakes", steps.places.bakes, "INOUT"),
                              path("Scenes", steps.places.scenes, "IN")}},
                            {"steps", steps.steps}};
  fs::path file = folder / "template.json";
  sim::create_folders(folder);
  sim::claim({file}, overwrite);
  sim::write_durably(file, json_text(job, 1) + "\n");
  return file;
}

}  // namespace

std::vector<fs::path> write_openjd(const Graph& graph, const Jobs& jobs, const fs::path& program,
                                   const fs::path& folder, bool overwrite) {
  const fs::path here = fs::absolute(folder).lexically_normal();
  const Places places{jobs.out.string(), jobs.file.parent_path().string()};
  std::vector<fs::path> files;
  const std::size_t count = graph.tasks.size();
  for (std::size_t i = 0; i < count;) {
    const std::string shot = graph.tasks[i].shot;
    Steps steps{graph, places, ordered_json::array(), {}};
    while (i < count && graph.tasks[i].shot == shot) {
      const Task& first = graph.tasks[i];
      const auto alike = [&](const Task& task) {
        return task.bake == first.bake && task.step == first.step;
      };
      std::size_t end = i + 1;
      while (end < count && end - i < kLongestRange && alike(graph.tasks[end])) ++end;
      steps.add(static_cast<int>(i), end - i);
      i = end;
    }
    const fs::path bundle = shot.empty() ? here / "report" : here / "shots" / shot;
    files.push_back(write_job(shot.empty() ? "thew report" : "thew " + shot, steps, program, bundle,
                              overwrite));
  }
  return files;
}

}  // namespace thew::tools
