// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

#include <chrono>
#include <filesystem>

#include "sim/scene/scene.h"
#include "thew/scene.h"  // after the internal headers: see sim/api/scene_data.h

namespace thew::python {

namespace py = pybind11;

/// A scene, and what its file says of a bake's report; empty of one from arrays.
struct PythonScene {
  thew::Scene scene;
  sim::Scene file;
};

void define_module(py::module_& module);
void define_scenes(py::module_& module);
void define_bakes(py::module_& module);
void define_commands(py::module_& module);

/// Throws what Python has to say: of Ctrl-C that is KeyboardInterrupt. Takes the GIL, and therefore
/// looks twenty times a second at most.
class Interrupts {
 public:
  void check();

 private:
  std::chrono::steady_clock::time_point next_{};
};

}  // namespace thew::python
