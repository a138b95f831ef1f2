// SPDX-License-Identifier: Apache-2.0
// A bake that is made, and one that is read.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>

#include "sim/cache/durable_file.h"
#include "sim/cache/own_files.h"
#include "tools/base/commit.h"
#include "tools/base/options.h"
#include "tools/base/printing.h"
#include "tools/cli/bake_folder.h"
#include "tools/cli/bake_report.h"
#include "tools/report/viewer.h"
// The public types last: see sim/api/scene_data.h.
#include "sim/api/scene_data.h"
#include "thew/cache.h"
#include "tools/python/arrays.h"
#include "tools/python/module.h"

namespace thew::python {
namespace {

namespace fs = std::filesystem;

/// What thew.bake() is told.
struct Order {
  const PythonScene& scene;
  fs::path out;
  std::vector<int> frames;
  py::object progress;  ///< None, or called with (frame, done, of)
  bool resume = true;
  tools::CommandOptions options = {};  ///< as the command would have them
};

tools::BakeStart look_into(const Order& order, const sim::BakeInfo& info) {
  if (order.resume) return tools::look_into_folder(order.options, info);
  sim::create_folders(order.out);
  sim::claim({order.out / "report.json", order.out / "report.html"}, false);
  return tools::BakeStart::kAnew;
}

// Of a cache that is complete, whose report a kill has taken; but for its seconds.
sim::BakeResult read_result(const sim::Model& model, const sim::BakeReader& reader, int threads) {
  sim::BakeResult result;
  result.hash = reader.info().hash;
  result.threads = threads;
  result.resumed_frames = static_cast<int>(reader.info().frames.size());
  const std::vector<std::string>& names = reader.info().metric_names;
  std::vector<double> numbers(names.size());
  for (int f = 0; f < result.resumed_frames; ++f) {
    for (std::size_t m = 0; m < names.size(); ++m) {
      numbers[m] = reader.metric(static_cast<int>(m))[f];
    }
    result.measures.push_back(sim::unflatten(model, names, numbers));
  }
  return result;
}

bool has_report_of(const fs::path& folder, const std::string& hash) {
  std::ifstream file(folder / "report.json");
  const auto report = nlohmann::json::parse(file, nullptr, false);
  return report.is_object() && report.value("hash", nlohmann::json()) == hash;
}

// As the command writes it with --no-render.
void report(const Order& order, const sim::Model& model, const sim::BakeResult& result,
            const sim::Seconds& total) {
  sim::Scene scene = order.scene.file;
  const bool of_arrays = scene.file.empty();
  if (of_arrays) scene.file = scene.name;
  tools::Report report = tools::make_report(scene, model, order.options, order.frames, result);
  if (of_arrays) report.origin.scene = "arrays";
  // The scene's know of overlaps at rest, beyond the model's.
  const std::vector<std::string>& warnings = order.scene.scene.info().warnings;
  const auto known = static_cast<std::ptrdiff_t>(model.warnings.size());
  report.warnings.insert(report.warnings.begin() + known, warnings.begin() + known, warnings.end());
  const sim::BakeSeconds& bake = result.seconds;
  report.seconds = {.total = total,
                    .setup = bake.setup,
                    .settle = bake.settle,
                    .measure = bake.measure,
                    .report = {},
                    .rig = bake.step.rig,
                    .muscles = bake.step.muscles,
                    .contact = bake.step.contact,
                    .skin = bake.step.skin,
                    .write = bake.write,
                    .render = {}};
  report.files = tools::files_beside_report(order.out, {});
  tools::write_report(order.out, report, {},
                      tools::report_viewer(sim::BakeReader(order.out / "bake.h5")));
  tools::list_report(order.out, "");
}

// Without the GIL, but for what Python is asked.
void run(const Order& order) {
  const py::gil_scoped_release released;
  sim::StopWatch watch;
  const SceneData& data = SceneData::of(order.scene.scene);
  const sim::BakeOutput output{data.double_precision, data.text, order.options.command,
                               order.options.directory};
  const sim::BakeInfo info = sim::bake_info(data.model, order.frames, output);
  const fs::path cache = order.out / "bake.h5";
  if (look_into(order, info) == tools::BakeStart::kComplete) {
    const sim::BakeReader reader(cache);
    if (has_report_of(order.out, reader.info().hash)) return;
    return report(order, data.model, read_result(data.model, reader, order.options.threads), {});
  }
  Interrupts interrupts;
  const int all = static_cast<int>(order.frames.size());
  int done = 0;
  const auto on_frame = [&](const sim::BakeFrame& frame) {
    interrupts.check();
    ++done;
    if (order.progress.is_none()) return true;
    const py::gil_scoped_acquire held;
    return !order.progress(frame.frame, done, all).is(py::bool_(false));
  };
  const sim::BakeResult result = sim::bake(data.model,
                                           {.folder = order.out,
                                            .frames = order.frames,
                                            .threads = order.options.threads,
                                            .resume = order.resume,
                                            .output = output,
                                            .stop = [&] { return interrupts.check(), false; }},
                                           on_frame);
  report(order, data.model, result, watch.lap());
}

std::string arguments_of_python() {
  std::vector<std::string> words = {"python3"};
  for (const py::handle word : py::module_::import("sys").attr("argv")) {
    words.push_back(py::str(word));
  }
  return tools::command_text(words);
}

fs::path bake(const PythonScene& scene, const fs::path& out, const std::string& frames, int threads,
              const py::object& progress, bool resume) {
  Order order{scene, out, {}, progress, resume};
  const SceneInfo& info = scene.scene.info();
  if (!frames.empty()) {
    order.frames = tools::parse_frames(frames, info.first_frame, info.last_frame);
  }
  for (int f = info.first_frame; frames.empty() && f <= info.last_frame; ++f) {
    order.frames.push_back(f);
  }
  std::error_code nowhere;
  order.options.out = out;
  order.options.resume = resume;
  order.options.threads = tools::thread_count(threads);
  order.options.command = arguments_of_python();
  order.options.directory = fs::current_path(nowhere).string();
  order.options.commit = tools::kCommit;
  run(order);
  return out / "bake.h5";
}

/// One thread at a time reads a bake: the others wait.
struct PythonBake {
  explicit PythonBake(const fs::path& file) : bake(file) {}

  std::vector<double> positions(const std::string& mesh, int frame) {
    const std::lock_guard lock(mutex);
    return bake.positions(mesh, frame);
  }
  std::size_t place_of(const std::string& mesh) const {
    const auto& meshes = bake.contents().meshes;
    const auto found = std::find_if(meshes.begin(), meshes.end(),
                                    [&](const BakedMesh& one) { return one.name == mesh; });
    return static_cast<std::size_t>(found - meshes.begin());
  }

  std::mutex mutex;
  Bake bake;
};

/// Without the GIL: a reader in this process waits for what other threads have it do, and they may
/// wait for the GIL.
struct CloseBake {
  void operator()(PythonBake* bake) const {
    const py::gil_scoped_release released;
    delete bake;
  }
};

py::array_t<double> all_positions(PythonBake& of, const std::string& mesh) {
  const BakeContents& contents = of.bake.contents();
  const std::size_t place = of.place_of(mesh);
  const auto frames = static_cast<py::ssize_t>(contents.frames.size());
  const auto numbers = static_cast<py::ssize_t>(
      place < contents.meshes.size() ? contents.meshes[place].rest.positions.size() : 0);
  py::array_t<double> out({frames, numbers / 3, py::ssize_t{3}});
  double* to = out.mutable_data();
  const py::gil_scoped_release released;
  Interrupts interrupts;
  for (const int frame : contents.frames) {
    interrupts.check();
    const std::vector<double> one = of.positions(mesh, frame);
    std::memcpy(to, one.data(), one.size() * sizeof(double));
    to += numbers;
  }
  return out;
}

py::dict contents_of(const py::object& self) {
  const BakeContents& contents = self.cast<PythonBake&>().bake.contents();
  py::dict out, meshes;
  constexpr const char* kKinds[] = {"muscle", "bone", "skin", "prop"};
  for (const BakedMesh& mesh : contents.meshes) {
    const auto rows = [](const auto& flat) { return static_cast<py::ssize_t>(flat.size() / 3); };
    meshes[py::str(mesh.name)] =
        py::make_tuple(kKinds[static_cast<int>(mesh.kind)],
                       view(mesh.rest.positions, {rows(mesh.rest.positions), 3}, self),
                       view(mesh.rest.triangles, {rows(mesh.rest.triangles), 3}, self),
                       view(mesh.weights, {static_cast<py::ssize_t>(mesh.weights.size())}, self));
  }
  out["scene"] = contents.scene;
  out["hash"] = contents.hash;
  out["fps"] = contents.fps;
  out["frames"] = view(contents.frames, {static_cast<py::ssize_t>(contents.frames.size())}, self);
  out["meshes"] = meshes;
  out["measures"] = contents.measures;
  return out;
}

}  // namespace

void define_bakes(py::module_& module) {
  py::class_<PythonBake, std::unique_ptr<PythonBake, CloseBake>>(module, "Bake")
      .def(py::init([](const fs::path& file) {
        const py::gil_scoped_release released;
        return std::unique_ptr<PythonBake, CloseBake>(new PythonBake(file));
      }))
      .def_property_readonly("contents", &contents_of)
      .def("all_positions", &all_positions)
      .def("positions",
           [](PythonBake& of, const std::string& mesh, int frame) {
             std::vector<double> points;
             {
               const py::gil_scoped_release released;
               points = of.positions(mesh, frame);
             }
             return take_points(std::move(points));
           })
      .def("measure", [](const PythonBake& of, const std::string& name) {
        std::vector<double> values = of.bake.measure(name);
        const auto frames = static_cast<py::ssize_t>(values.size());
        return take(std::move(values), {frames});
      });
  module.def("bake", &bake);
}

}  // namespace thew::python
