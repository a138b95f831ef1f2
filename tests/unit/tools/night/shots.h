// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>

#include "tests/unit/rig/temp.h"
#include "tools/cli/commands.h"
#include "tools/night/night.h"

namespace thew::tests {

/// A report as a bake writes it, in short: 10 s, 15 s of processors, 2 frames.
inline nlohmann::ordered_json some_report(double penetration, double limit = 5e-4) {
  return {{"thew", "0.1.0"},
          {"scene", "arm"},
          {"fps", 24},
          {"frames", {1, 2}},
          {"hash", "aa"},
          {"solver", {{"integrator", "local_global"}}},
          {"worst",
           {{{"quantity", "penetration"},
             {"measured", penetration},
             {"frame", 2},
             {"part", "brachialis"}}}},
          {"rungs", nlohmann::ordered_json::array()},
          {"origin",
           {{"scene_hash", "5c"},
            {"directory", "/home/a show"},
            {"command", "thew bake arm.toml --out out"},
            {"date", "2026-11-24T23:00:00Z"}}},
          {"seconds", {{"total", 10.0}, {"muscles", 6.0}, {"skin", 4.0}}},
          {"cpu_seconds", {{"total", 15.0}, {"muscles", 12.0}, {"skin", 3.0}}},
          {"bounds",
           {{{"quantity", "penetration"},
             {"measured", penetration},
             {"limit", limit},
             {"met", penetration <= limit}}}},
          {"warnings", {"joint \"elbow\": 12 mm off"}}};
}

class ManyBakes : public TempFolder {
 protected:
  void put(const std::string& shot, const nlohmann::ordered_json& report) const {
    write("show/" + shot + "/report.json", report.dump(1));
  }
  Night read() const {
    Night night;
    night.name = "show";
    night.shots = find_shots({folder / "show"});
    return night;
  }
  static const NightShot& named(const Night& night, const std::string& name) {
    for (const NightShot& shot : night.shots) {
      if (shot.name == name) return shot;
    }
    throw std::out_of_range("no shot " + name);
  }
  static std::size_t times(const std::string& text, const std::string& word) {
    std::size_t count = 0;
    for (std::size_t at = 0; (at = text.find(word, at)) != std::string::npos; at += word.size()) {
      ++count;
    }
    return count;
  }
};

}  // namespace thew::tests
