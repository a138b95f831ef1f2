// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/numpy.h>

#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "thew/mesh.h"

namespace thew::python {

namespace py = pybind11;

/// Any array or sequence of numbers, as ours are: by rows, without gaps.
template <typename T>
py::array_t<T, py::array::c_style> numbers_in(py::handle given, const char* what) {
  const auto array = py::array::ensure(given);
  const char kind = array ? array.dtype().kind() : '?';
  const bool whole = kind == 'i' || kind == 'u';
  if (!whole && (kind != 'f' || std::is_integral_v<T>)) {
    throw Error(ErrorCode::kUsage, std::string(what) + ": are no " +
                                       (std::is_integral_v<T> ? "whole " : "") +
                                       "numbers; give an array of them");
  }
  return py::array_t<T, py::array::c_style | py::array::forcecast>(array);
}

/// Rows of three, or nothing.
template <typename T>
std::vector<T> rows_of_three(py::handle given, const char* what) {
  const auto array = numbers_in<T>(given, what);
  if (array.size() != 0 && (array.ndim() != 2 || array.shape(1) != 3)) {
    throw Error(ErrorCode::kUsage,
                std::string(what) + ": are no array of [N, 3]; give rows of three");
  }
  return {array.data(), array.data() + array.size()};
}

template <typename T>
py::array_t<T> read_only(py::array_t<T> array) {
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

/// The numbers of `values` themselves, of which `owner` lives as long as the array does.
template <typename T>
py::array_t<T> view(const std::vector<T>& values, std::vector<py::ssize_t> shape,
                    py::handle owner) {
  return read_only(py::array_t<T>(std::move(shape), values.data(), owner));
}

/// The numbers of `values`, which the array owns from now on.
template <typename T>
py::array_t<T> take(std::vector<T> values, std::vector<py::ssize_t> shape) {
  auto kept = std::make_unique<std::vector<T>>(std::move(values));
  const T* first = kept->data();
  const py::capsule owner(kept.release(),
                          [](void* one) { delete static_cast<std::vector<T>*>(one); });
  return py::array_t<T>(std::move(shape), first, owner);
}

/// [N, 3]
inline py::array_t<double> take_points(std::vector<double> points) {
  const auto rows = static_cast<py::ssize_t>(points.size() / 3);
  return take(std::move(points), {rows, 3});
}

}  // namespace thew::python
