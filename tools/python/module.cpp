// SPDX-License-Identifier: Apache-2.0
// The module thew._thew: what Python cannot do itself. The package around it is thew/__init__.py.
#include "tools/python/module.h"

#include <exception>
#include <string>
#include <string_view>
#include <utility>

#include "thew/thew.h"
#include "tools/base/commit.h"
#include "tools/base/exit_code.h"
#include "tools/base/printing.h"

namespace thew::python {
namespace {

PyObject* error_type = nullptr;  // thew.Error, which the module holds

// Messages name options of the command, which are arguments here, of the same names.
std::string in_python(std::string message) {
  constexpr std::string_view kAnew = "bake anew with --overwrite";
  if (const std::size_t at = message.find(kAnew); at != message.npos) {
    message.replace(at, kAnew.size(), "bake anew with resume=False");
  }
  for (std::size_t at = 0; (at = message.find("--", at)) != message.npos;) {
    const bool begins = at == 0 || message[at - 1] == ' ' || message[at - 1] == '(';
    const bool is_name =
        at + 2 < message.size() && message[at + 2] >= 'a' && message[at + 2] <= 'z';
    if (begins && is_name) {
      message.erase(at, 2);
    } else {
      at += 2;
    }
  }
  return message;
}

void raise(ErrorCode code, const std::string& message) {
  const std::string text = in_python(message);
  const tools::ErrorParts parts = tools::split_error(text, {});
  // The bytes of a name need not be text.
  const auto words = [](const std::string& bytes) {
    return py::reinterpret_steal<py::object>(PyUnicode_DecodeUTF8(
        bytes.data(), static_cast<py::ssize_t>(bytes.size()), "surrogateescape"));
  };
  const auto words_or_none = [&](const std::string& bytes) {
    return bytes.empty() ? py::object(py::none()) : words(bytes);
  };
  const py::object error = py::reinterpret_borrow<py::object>(error_type)(words(text));
  error.attr("code") = static_cast<int>(tools::exit_code_of(code));
  error.attr("file") = words_or_none(parts.file);
  error.attr("line") = parts.line > 0 ? py::object(py::int_(parts.line)) : py::none();
  error.attr("message") = words(parts.message);
  error.attr("next") = words_or_none(parts.next);
  PyErr_SetObject(error_type, error.ptr());
}

void translate(std::exception_ptr thrown) {
  try {
    if (thrown) std::rethrow_exception(std::move(thrown));
  } catch (const Error& error) {
    raise(error.code(), error.what());
  } catch (const std::filesystem::filesystem_error& error) {
    raise(ErrorCode::kInput, error.path1().string() + ": " + error.code().message() +
                                 "; check the path and its permissions");
  }
}

void define_error(py::module_& module) {
  py::dict none;
  for (const char* name : {"code", "file", "line", "message", "next"}) none[name] = py::none();
  error_type = PyErr_NewExceptionWithDoc(
      "thew.Error",
      "What went wrong: str(error) is \"place: what is wrong with what; the next move\".\n\n"
      "code: 2 what was asked for, or the scene; 3 a file that is read; 4 one that cannot be\n"
      "written; 5 the solver could not go on; 75 cancelled, locked or short of memory: the same\n"
      "call may succeed. file, line: where, None where there is none. message, next: its parts.",
      PyExc_RuntimeError, none.ptr());
  module.attr("Error") = py::reinterpret_borrow<py::object>(error_type);
  py::register_exception_translator(translate);
}

void choose_import_mode(const std::string& mode) {
  if (mode != "isolated" && mode != "in_process") {
    throw Error(ErrorCode::kUsage, "mode is \"" + mode + "\"; give \"isolated\" or \"in_process\"");
  }
  const py::gil_scoped_release released;
  set_import_mode(mode == "isolated" ? ImportMode::kIsolated : ImportMode::kInProcess);
}

}  // namespace

void Interrupts::check() {
  const auto now = std::chrono::steady_clock::now();
  if (now < next_) return;
  next_ = now + std::chrono::milliseconds(50);
  const py::gil_scoped_acquire held;
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

void define_module(py::module_& module) {
  module.doc() = "What thew/__init__.py is made of; use that.";
  define_error(module);
  module.attr("version") = version();
  module.attr("commit") = tools::kCommit;
  module.def("set_import_mode", &choose_import_mode);
  define_scenes(module);
  define_bakes(module);
  define_commands(module);
}

}  // namespace thew::python

PYBIND11_MODULE(_thew, module) { thew::python::define_module(module); }
