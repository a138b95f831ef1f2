// SPDX-License-Identifier: Apache-2.0
#include "tools/compare/geometry.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>

#include "tools/base/bake_mesh.h"
#include "tools/base/signals.h"
#include "tools/base/text.h"

namespace thew::tools {
namespace {

const BakeMesh* find_mesh(const std::vector<BakeMesh>& meshes, const std::string& name) {
  const auto found = std::find_if(meshes.begin(), meshes.end(),
                                  [&](const BakeMesh& mesh) { return mesh.name == name; });
  return found == meshes.end() ? nullptr : &*found;
}

std::string millimetres(double metres) { return readable(1e3 * metres) + " mm"; }

/// m; and which node.
struct Farthest {
  double distance = 0.0;
  int node = 0;
};

Farthest farthest(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  Farthest most;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double distance = (a[i] - b[i]).norm();
    if (distance > most.distance) most = {distance, static_cast<int>(i)};
  }
  return most;
}

template <typename T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  if (a.size() != b.size()) return false;
  return a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

bool same_surface(const BakeMesh& a, const BakeMesh& b, double tolerance) {
  return a.kind == b.kind && a.rest.vertices.size() == b.rest.vertices.size() &&
         a.rest.triangles == b.rest.triangles &&
         farthest(a.rest.vertices, b.rest.vertices).distance <= tolerance;
}

/// What is wrong with the surface of a mesh that both have; "" where nothing is.
std::string surface_fault(const BakeMesh& expected, const BakeMesh& actual, double tolerance) {
  const std::string name = expected.name;
  const auto number = [](std::size_t n) { return std::to_string(n); };
  const TriMesh &a = expected.rest, &b = actual.rest;
  if (expected.kind != actual.kind) {
    return name + " is a " + kind_name(actual.kind) + ", expected a " + kind_name(expected.kind);
  }
  if (a.vertices.size() != b.vertices.size() || a.triangles.size() != b.triangles.size()) {
    return name + " has " + number(b.vertices.size()) + " vertices and " +
           number(b.triangles.size()) + " triangles, expected " + number(a.vertices.size()) +
           " and " + number(a.triangles.size());
  }
  const auto other = std::mismatch(a.triangles.begin(), a.triangles.end(), b.triangles.begin());
  if (other.first != a.triangles.end()) {
    return name + ": triangle " + number(other.first - a.triangles.begin()) +
           " joins other vertices than expected; the topology or the vertex order changed";
  }
  const Farthest most = farthest(a.vertices, b.vertices);
  if (most.distance <= tolerance) return "";
  return name + ": its rest shape is " + millimetres(most.distance) +
         " from the expected one at vertex " + std::to_string(most.node);
}

// The name under which EXPECTED has what ACTUAL calls otherwise; "" where it has no such surface.
std::string former_name(const BakeMesh& actual, const BakeInfo& expected, double tolerance) {
  for (const BakeMesh& mesh : expected.meshes) {
    if (mesh.name != actual.name && same_surface(mesh, actual, tolerance)) return mesh.name;
  }
  return "";
}

std::string weight_fault(const BakeMesh& expected, const BakeMesh& actual) {
  // Weights are of the order of 1, and a golden keeps them as float32.
  constexpr double kWeightTolerance = 1e-5;
  if (expected.weights.size() != actual.weights.size()) {
    return expected.name + " has " + std::to_string(actual.weights.size()) + " weights, expected " +
           std::to_string(expected.weights.size());
  }
  double most = 0.0;
  std::size_t at = 0, changed = 0;
  for (std::size_t i = 0; i < expected.weights.size(); ++i) {
    const double difference = std::abs(expected.weights[i] - actual.weights[i]);
    if (difference > kWeightTolerance) ++changed;
    if (difference > most) most = difference, at = i;
  }
  if (changed == 0) return "";
  return expected.name + ": the weight of vertex " + std::to_string(at) + " is " +
         readable(actual.weights[at], 6) + ", expected " + readable(expected.weights[at], 6) +
         (changed > 1 ? "; " + std::to_string(changed) + " weights differ" : "");
}

void compare_mesh_sets(const BakeInfo& expected, const BakeInfo& actual, double tolerance,
                       std::vector<std::string>& faults) {
  const auto call = [&](const BakeMesh& mesh) {
    return std::string(kind_name(mesh.kind)) + " \"" + mesh.name + "\"";
  };
  for (const BakeMesh& mesh : expected.meshes) {
    if (!find_mesh(actual.meshes, mesh.name)) faults.push_back(call(mesh) + " is missing");
  }
  for (const BakeMesh& mesh : actual.meshes) {
    const BakeMesh* old = find_mesh(expected.meshes, mesh.name);
    if (!old) {
      const std::string was = former_name(mesh, expected, tolerance);
      faults.push_back(call(mesh) +
                       (was.empty() ? " is new" : " is what was called \"" + was + "\""));
      continue;
    }
    const std::string fault = surface_fault(*old, mesh, tolerance);
    if (fault.empty()) {
      const std::string weights = weight_fault(*old, mesh);
      if (!weights.empty()) faults.push_back(weights);
      continue;
    }
    const std::string was = former_name(mesh, expected, tolerance);
    const BakeMesh* partner = find_mesh(actual.meshes, was);
    const bool swapped = partner && former_name(*partner, expected, tolerance) == mesh.name;
    if (swapped && was < mesh.name) continue;  // said already
    faults.push_back(was.empty() ? fault
                     : swapped   ? mesh.name + " and " + was + " are swapped"
                                 : mesh.name + " has the surface of " + was);
  }
}

std::vector<int> chosen(const std::vector<int>& all, const std::vector<int>& wanted) {
  if (wanted.empty()) return all;
  std::vector<int> some;
  std::set_intersection(all.begin(), all.end(), wanted.begin(), wanted.end(),
                        std::back_inserter(some));
  return some;
}

void compare_frame_sets(const std::vector<int>& expected, const std::vector<int>& actual,
                        GeometryComparison& result) {
  std::vector<int> missing, added;
  std::set_intersection(expected.begin(), expected.end(), actual.begin(), actual.end(),
                        std::back_inserter(result.frames));
  std::set_difference(expected.begin(), expected.end(), actual.begin(), actual.end(),
                      std::back_inserter(missing));
  std::set_difference(actual.begin(), actual.end(), expected.begin(), expected.end(),
                      std::back_inserter(added));
  const auto fault = [&](const std::vector<int>& frames, const std::string& what) {
    if (frames.empty()) return;
    result.faults.push_back((frames.size() == 1 ? "frame " : "frames ") + frame_list(frames) +
                            (frames.size() == 1 ? " is " : " are ") + what);
  };
  fault(missing, "missing");
  fault(added, "not expected");
}

int index_of(const std::vector<int>& frames, int frame) {
  return static_cast<int>(std::lower_bound(frames.begin(), frames.end(), frame) - frames.begin());
}

// Against a cache of float32 the other side is rounded alike, so that rounding is no distance.
void round_to_float(BakeFrame& frame) {
  for (auto& mesh : frame.positions) {
    for (Vec3& p : mesh) p = p.unaryExpr(&as_float);
  }
}

void compare_positions(const BakeReader& expected, const BakeReader& actual,
                       GeometryComparison& result) {
  const auto &old = expected.info().meshes, &now = actual.info().meshes;
  std::vector<std::pair<std::size_t, std::size_t>> pairs;  // of meshes with as many nodes
  for (std::size_t i = 0; i < old.size(); ++i) {
    const BakeMesh* mesh = find_mesh(now, old[i].name);
    if (!mesh || mesh->rest.vertices.size() != old[i].rest.vertices.size()) continue;
    pairs.emplace_back(i, mesh - now.data());
    result.meshes.push_back({});
    result.meshes.back().name = old[i].name;
  }
  result.rounded = expected.info().double_precision != actual.info().double_precision;
  result.same_hash = expected.info().hash == actual.info().hash;
  result.exact = result.same_hash && !result.rounded;
  for (const auto& [i, k] : pairs) {
    result.exact = result.exact && same_bits(old[i].rest.vertices, now[k].rest.vertices) &&
                   same_bits(old[i].weights, now[k].weights);
  }
  for (const int frame : result.frames) {
    stop_if_interrupted();
    BakeFrame a = expected.read(index_of(expected.info().frames, frame));
    BakeFrame b = actual.read(index_of(actual.info().frames, frame));
    if (result.rounded) round_to_float(expected.info().double_precision ? a : b);
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      MeshDistance& mesh = result.meshes[k];
      const auto &x = a.positions[pairs[k].first], &y = b.positions[pairs[k].second];
      const Farthest most = farthest(x, y);
      mesh.by_frame.push_back(most.distance);
      result.exact = result.exact && same_bits(x, y);
      for (std::size_t i = 0; i < x.size(); ++i) mesh.rms += (x[i] - y[i]).squaredNorm();
      if (most.distance <= mesh.largest) continue;
      mesh.largest = most.distance, mesh.frame = frame, mesh.node = most.node;
    }
  }
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const double count = static_cast<double>(old[pairs[k].first].rest.vertices.size()) *
                         static_cast<double>(std::max<std::size_t>(1, result.frames.size()));
    result.meshes[k].rms = std::sqrt(result.meshes[k].rms / count);
  }
  std::stable_sort(result.meshes.begin(), result.meshes.end(),
                   [](const auto& a, const auto& b) { return a.largest > b.largest; });
}

}  // namespace

GeometryComparison compare_geometry(const BakeReader& expected, const BakeReader& actual,
                                    const std::vector<int>& frames, double tolerance) {
  const BakeInfo &old = expected.info(), &now = actual.info();
  GeometryComparison result;
  result.tolerance = tolerance;
  result.same_scene = old.scene_hash == now.scene_hash;
  if (old.fps != now.fps) {
    result.faults.push_back(readable(now.fps, 6) + " frames a second, expected " +
                            readable(old.fps, 6));
  }
  compare_mesh_sets(old, now, tolerance, result.faults);
  compare_frame_sets(chosen(old.frames, frames), chosen(now.frames, frames), result);
  if (result.frames.empty()) result.faults.push_back("there is no frame to compare");
  compare_positions(expected, actual, result);
  result.exact = result.exact && result.faults.empty();
  return result;
}

}  // namespace thew::tools
