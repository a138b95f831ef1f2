// SPDX-License-Identifier: Apache-2.0
// What commands do beside a bake; each returns what the command prints with --json.
#include "tools/cli/commands.h"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <nlohmann/json.hpp>
#include <set>

#include "tools/base/options.h"
#include "tools/base/printing.h"
#include "tools/python/module.h"

namespace thew::python {
namespace {

namespace fs = std::filesystem;

std::string compare(const fs::path& expected, const fs::path& actual, double millimetres,
                    const std::string& frames) {
  tools::CompareOptions options;
  options.distance = 1e-3 * millimetres;
  options.threads = tools::thread_count(0);
  if (!frames.empty()) options.frames = tools::parse_frames(frames);
  const py::gil_scoped_release released;
  return tools::comparison_as_json(tools::compare(expected, actual, options));
}

std::string export_bake(const fs::path& bake, const fs::path& out,
                        const std::vector<std::string>& meshes, const std::string& frames,
                        int basis, const fs::path& onto, const std::set<std::string>& flags) {
  tools::CommandOptions options;
  options.input = bake;
  options.out = out;
  options.frames = frames;
  options.overwrite = flags.contains("overwrite");
  options.progress = "none";
  const py::gil_scoped_release released;
  const tools::ExportChoice choice{onto, flags.contains("correctives"), flags.contains("quantized"),
                                   flags.contains("fields")};
  return tools::json_text(tools::export_bake(options, meshes, basis, choice), 0);
}

std::string fit(const fs::path& character, const fs::path& out, const std::string& side,
                std::optional<double> scale, const std::map<std::string, std::string>& map,
                const std::vector<std::string>& skin, bool overwrite) {
  const py::gil_scoped_release released;
  return tools::json_text(tools::new_scene({.character = character,
                                            .out = out,
                                            .map = map,
                                            .skin = skin,
                                            .side = side,
                                            .scale = scale,
                                            .force = overwrite},
                                           [](const std::string&) {}),
                          0);
}

}  // namespace

void define_commands(py::module_& module) {
  module.def("compare", &compare);
  module.def("export", &export_bake);
  module.def("fit", &fit);
}

}  // namespace thew::python
