// SPDX-License-Identifier: Apache-2.0
// Scenes from files and from arrays, and their simulation step by step.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <mutex>

#include "sim/api/scene_data.h"
#include "sim/scene/reader.h"
#include "sim/solver/drive.h"
#include "thew/simulation.h"
#include "tools/python/arrays.h"
#include "tools/python/module.h"

namespace thew::python {
namespace {

// The definitions of thew/__init__.py, field by field.

template <typename T>
T field(py::handle of, const char* name) {
  try {
    return of.attr(name).cast<T>();
  } catch (const py::cast_error&) {
    throw Error(ErrorCode::kUsage, py::type::of(of).attr("__name__").cast<std::string>() + ": " +
                                       name + " is " + py::repr(of.attr(name)).cast<std::string>() +
                                       ", which is of another kind; help(thew) says which");
  }
}

Mesh mesh_of(py::handle given) {
  if (given.is_none()) return {};
  if (!py::isinstance<py::sequence>(given) || py::len(given) != 2) {
    throw Error(ErrorCode::kUsage, "a mesh is a pair (positions, triangles); give both");
  }
  const auto parts = py::reinterpret_borrow<py::sequence>(given);
  return {rows_of_three<double>(parts[0], "positions"), rows_of_three<int>(parts[1], "triangles")};
}

std::vector<double> numbers_of(py::handle given, const char* what) {
  if (given.is_none()) return {};
  const auto array = numbers_in<double>(given, what);
  return {array.data(), array.data() + array.size()};
}

Maps maps_of(py::handle given) {
  Maps maps;
  for (const auto& [name, values] : given.attr("maps").cast<std::map<std::string, py::object>>()) {
    maps[name] = numbers_of(values, name.c_str());
  }
  return maps;
}

JointActivation by_joint_of(py::handle given) {
  if (given.is_none()) return {};
  return {.joint = field<std::string>(given, "joint"),
          .curve = field<std::vector<std::array<double, 2>>>(given, "curve"),
          .speed = field<std::vector<std::array<double, 2>>>(given, "speed"),
          .load = field<double>(given, "load"),
          .load_body = field<std::string>(given, "load_body"),
          .load_at = field<Vector3>(given, "load_at")};
}

Body body_of(py::handle given) {
  Body body{.name = field<std::string>(given, "name"),
            .parent = field<std::string>(given, "parent")};
  const py::object joint = given.attr("joint");
  if (joint.is_none()) return body;
  const auto kind = field<std::string>(joint, "kind");
  if (kind != "fixed" && kind != "hinge" && kind != "slider") {
    throw Error(ErrorCode::kUsage, "body \"" + body.name + "\": its joint's kind is \"" + kind +
                                       "\"; give fixed, hinge or slider");
  }
  const auto range = field<std::array<double, 2>>(joint, "range");
  body.joint = {.kind = kind == "hinge"    ? Joint::Kind::kHinge
                        : kind == "slider" ? Joint::Kind::kSlider
                                           : Joint::Kind::kFixed,
                .name = field<std::string>(joint, "name"),
                .position = field<Vector3>(joint, "position"),
                .axis = field<Vector3>(joint, "axis"),
                .lower = range[0],
                .upper = range[1]};
  return body;
}

Wrap wrap_of(py::handle given) {
  return {.segment = field<int>(given, "segment"),
          .body = field<std::string>(given, "body"),
          .centre = field<Vector3>(given, "centre"),
          .axis = field<Vector3>(given, "axis"),
          .radius = field<double>(given, "radius"),
          .turn = field<double>(given, "turn")};
}

Muscle muscle_of(py::handle given) {
  Muscle muscle{.name = field<std::string>(given, "name")};
  muscle.mesh = mesh_of(given.attr("mesh"));
  for (auto& [body, position] :
       field<std::vector<std::pair<std::string, Vector3>>>(given, "path")) {
    muscle.path.push_back({body, position});
  }
  for (const py::handle wrap : given.attr("wraps")) muscle.wraps.push_back(wrap_of(wrap));
  muscle.belly = field<std::array<double, 2>>(given, "belly");
  muscle.weights = numbers_of(given.attr("weights"), "weights");
  muscle.stiffness = field<double>(given, "stiffness");
  muscle.f_max = field<double>(given, "f_max");
  muscle.activation = field<std::vector<std::array<double, 2>>>(given, "activation");
  muscle.by_joint = by_joint_of(given.attr("by_joint"));
  muscle.maps = maps_of(given);
  return muscle;
}

SceneDefinition definition_of(py::handle given) {
  SceneDefinition scene{.name = field<std::string>(given, "name"),
                        .fps = field<double>(given, "fps"),
                        .first_frame = field<std::array<int, 2>>(given, "frames")[0],
                        .last_frame = field<std::array<int, 2>>(given, "frames")[1],
                        .settle = field<double>(given, "settle"),
                        .gravity = field<Vector3>(given, "gravity"),
                        .size = field<double>(given, "size")};
  for (const py::handle body : given.attr("bodies")) scene.bodies.push_back(body_of(body));
  for (const py::handle muscle : given.attr("muscles")) scene.muscles.push_back(muscle_of(muscle));
  for (const py::handle bone : given.attr("bones")) {
    scene.bones.push_back({field<std::string>(bone, "name"), field<std::string>(bone, "body"),
                           mesh_of(bone.attr("mesh"))});
  }
  if (const py::object clip = given.attr("clip"); !clip.is_none()) {
    scene.clip = {field<std::vector<std::string>>(clip, "joints"),
                  numbers_of(clip.attr("frames"), "a clip's frames"),
                  numbers_of(clip.attr("values"), "a clip's values")};
  }
  if (const py::object skin = given.attr("skin"); !skin.is_none()) {
    scene.skin = {mesh_of(skin.attr("mesh")), field<bool>(skin, "keeps_volume"), maps_of(skin)};
  }
  if (const py::object solver = given.attr("solver"); !solver.is_none()) {
    scene.solver = {field<std::string>(solver, "integrator"), field<int>(solver, "substeps"),
                    field<int>(solver, "iterations")};
  }
  return scene;
}

std::unique_ptr<PythonScene> define_scene(py::handle given) {
  const SceneDefinition definition = definition_of(given);
  const py::gil_scoped_release released;
  auto made = std::make_unique<PythonScene>(PythonScene{Scene(definition), {}});
  made->file.name = definition.name;
  made->file.fps = definition.fps;
  made->file.solver.integrator = definition.solver.integrator;
  made->file.solver.substeps = definition.solver.substeps;
  return made;
}

std::unique_ptr<PythonScene> read_scene(const std::filesystem::path& file,
                                        const std::vector<std::string>& settings) {
  const py::gil_scoped_release released;
  return std::make_unique<PythonScene>(
      PythonScene{Scene::read(file, settings), sim::read_scene(file, settings)});
}

// By joint that can move: rad, or m of sliders.
std::map<std::string, double> pose_at(const PythonScene& scene, double frame) {
  const sim::Model& model = SceneData::of(scene.scene).model;
  std::vector<double> values;
  sim::joints_at(model, (frame - model.first_frame) / model.fps, values);
  std::map<std::string, double> named;
  for (int i = 0; i < model.skeleton.size(); ++i) {
    if (model.skeleton.joint_types[i] == sim::Skeleton::JointType::kFixed) continue;
    named[model.skeleton.joint_names[i]] = values[i];
  }
  return named;
}

/// One thread at a time uses a simulation: the others wait.
struct PythonSimulation {
  PythonSimulation(const PythonScene& of, int threads) : simulation(of.scene, threads) {}

  // Without the GIL, so that other threads of Python run on meanwhile.
  template <typename Work>
  auto alone(const Work& work) {
    const py::gil_scoped_release released;
    const std::lock_guard lock(mutex);
    return work(simulation);
  }

  std::mutex mutex;
  Simulation simulation;
};

}  // namespace

void define_scenes(py::module_& module) {
  py::class_<PythonScene>(module, "Scene")
      .def(py::init(&define_scene))
      .def_static("read", &read_scene)
      .def("pose", &pose_at)
      .def_property_readonly("info", [](const PythonScene& of) {
        const SceneInfo& info = of.scene.info();
        py::dict out;
        out["name"] = info.name;
        out["fps"] = info.fps;
        out["frames"] = py::make_tuple(info.first_frame, info.last_frame);
        out["joints"] = info.joints;
        out["meshes"] = info.meshes;
        out["warnings"] = info.warnings;
        return out;
      });
  py::class_<PythonSimulation>(module, "Simulation")
      .def(py::init<const PythonScene&, int>(), py::call_guard<py::gil_scoped_release>())
      .def(
          "settle", [](PythonSimulation& s) { s.alone([](Simulation& one) { one.settle(); }); },
          "From the rest pose to the clip's first pose, and to rest there: the first frame, as a "
          "bake has it. Does nothing the second time.")
      .def(
          "step",
          [](PythonSimulation& s) { return s.alone([](Simulation& one) { return one.step(); }); },
          "To the next frame, after settle() where that was not called; returns its number. The "
          "clip is held beyond its end.")
      .def(
          "step_to",
          [](PythonSimulation& s, double time) {
            s.alone([time](Simulation& one) { one.step_to(time); });
          },
          py::arg("time"), "The same to a time in s, 0 at the first frame.")
      .def_property_readonly(
          "time",
          [](PythonSimulation& s) { return s.alone([](Simulation& one) { return one.time(); }); },
          "s, 0 at the first frame; negative before it.")
      .def(
          "positions",
          [](PythonSimulation& s, const std::string& mesh) {
            return take_points(s.alone([&](Simulation& one) { return one.positions(mesh); }));
          },
          py::arg("mesh"), "[N, 3], m, in world space, now: of a mesh of Scene.meshes.")
      .def(
          "triangles",
          [](PythonSimulation& s, const std::string& mesh) {
            std::vector<int> all = s.alone([&](Simulation& one) { return one.triangles(mesh); });
            const auto rows = static_cast<py::ssize_t>(all.size() / 3);
            return take(std::move(all), {rows, 3});
          },
          py::arg("mesh"), "[T, 3]: its triangles, which never change.")
      .def(
          "joints",
          [](PythonSimulation& s) { return s.alone([](Simulation& one) { return one.joints(); }); },
          "By Scene.joints: rad, or m of sliders.")
      .def(
          "measures",
          [](PythonSimulation& s) {
            return s.alone([](Simulation& one) { return one.measures(); });
          },
          "What a bake states of each frame, measured now: \"length/NAME\" (m) and so on.");
}

}  // namespace thew::python
