// SPDX-License-Identifier: Apache-2.0
#include "sim/maps/node_map.h"

#include <algorithm>
#include <cmath>

#include "muscles/weights.h"
#include "rig/import/character_import.h"
#include "rig/limits.h"
#include "rig/math.h"
#include "rig/text.h"

namespace thew::sim {
namespace {

// Bytes: a larger file is not what was meant.
constexpr std::size_t kFileLimit = std::size_t{16} << 20;

[[noreturn]] void refuse(const NodeMap& map, const std::string& what) {
  throw Error(ErrorCode::kUsage, map.location + ": " + map.noun + ": " + what);
}

// One value for each vertex of the mesh as it is simulated, or of its file, in which several
// vertices may have one position.
std::vector<double> by_order(const NodeMap& map, const std::vector<double>& given,
                             const TriMesh& rest, const std::vector<int>& map_back) {
  const size_t nodes = rest.vertices.size();
  if (given.size() == nodes) return given;
  if (!map_back.empty() && given.size() == map_back.size()) {
    std::vector<double> values(nodes, 0.0);
    for (size_t i = given.size(); i-- > 0;) values[map_back[i]] = given[i];
    return values;
  }
  refuse(map, std::to_string(given.size()) + " values for a mesh of " + std::to_string(nodes) +
                  " vertices; give one per vertex, in the file's order, or x y z value in each "
                  "line of a file");
}

std::vector<double> by_point(const NodeMap& map, const std::vector<Vec3>& points,
                             const std::vector<double>& at_points, const TriMesh& rest) {
  std::vector<double> values;
  int lost = 0;
  double farthest = 0.0;
  std::string first;
  for (const Vec3& p : rest.vertices) {
    size_t best = 0;
    double least = 1e300;
    for (size_t k = 0; k < points.size(); ++k) {
      const double d = (points[k] - p).squaredNorm();
      if (d < least) least = d, best = k;
    }
    values.push_back(at_points[best]);
    if (std::sqrt(least) <= map.tolerance) continue;
    if (lost++ == 0) first = point_text(p);
    farthest = std::max(farthest, std::sqrt(least));
  }
  if (lost == 0) return values;
  refuse(map, std::to_string(lost) + " of " + std::to_string(values.size()) +
                  " vertices, first at " + first + ", have no value within " +
                  number_text(map.tolerance) + " m; paint them, or give a tolerance of " +
                  number_text(1.01 * farthest));
}

// v = base + sum_k w_k (v_k - base) / max(1, sum_k w_k), with w = 1 in the middle of a ball and 0
// from its rim on. A value that is the base everywhere comes out as it is, without rounding.
std::vector<double> by_place(const NodeMap& map, const TriMesh& rest) {
  std::vector<double> values;
  for (const Vec3& p : rest.vertices) {
    double sum = 0.0, whole = 0.0;
    for (const NodeMap::Place& place : map.places) {
      const double w = 1.0 - smoothstep(0.0, place.radius, (p - place.centre).norm());
      sum += w * (place.value - map.base);
      whole += w;
    }
    values.push_back(map.base + sum / std::max(1.0, whole));
  }
  return values;
}

// The colours or the attribute of a mesh, by vertex of it or of its file.
std::vector<double> painted_values(const NodeMap& map, const MappedMesh& on) {
  std::vector<double> values;
  if (on.character) {
    const std::string name = map.attribute.empty() ? "COLOR_0" : map.attribute;
    values = import_attribute(on.file, name, map.channel, *on.character);
  } else if (map.attribute.empty()) {
    if (on.imported.colours.empty()) {
      refuse(map,
             "a colour, but the mesh has no vertex colours; export it with them (PLY or glTF)");
    }
    for (const auto& colour : on.imported.colours) values.push_back(colour[map.channel]);
  } else {
    if (on.file.empty()) {
      refuse(map, "an attribute, but the mesh is of no file; name the one that has it");
    }
    values = import_attribute(on.file, map.attribute);
  }
  const auto [zero, one] = map.scale;
  for (double& value : values) value = zero == 0.0 ? one * value : zero + (one - zero) * value;
  return by_order(map, values, on.rest, on.imported.map_back);
}

std::vector<double> by_paint(const NodeMap& map, const MappedMesh& on) {
  if (map.painted.empty()) return painted_values(map, on);
  const ImportedMesh other = import_mesh(map.painted);
  std::vector<Vec3> points;
  for (const Vec3& p : other.mesh.vertices) points.push_back(on.to_rest * p);
  return by_point(map, points, painted_values(map, {other.mesh, other, map.painted}), on.rest);
}

std::vector<double> unchecked_values(const NodeMap& map, const MappedMesh& on) {
  if (!map.list.empty()) return by_order(map, map.list, on.rest, on.imported.map_back);
  if (!map.places.empty()) return by_place(map, on.rest);
  if (map.channel >= 0 || !map.attribute.empty()) return by_paint(map, on);
  if (!map.points.empty()) return by_point(map, map.points, map.at_points, on.rest);
  if (!on.u) refuse(map, "a profile, but it has no belly; give places or a list");
  return muscles::profile_weights({map.keys}, *on.u);
}

}  // namespace

std::vector<double> map_values(const NodeMap& map, const MappedMesh& on) {
  std::vector<double> values = unchecked_values(map, on);
  const auto [least, most] = map.bounds;
  for (size_t i = 0; i < values.size(); ++i) {
    if (on.character && std::isnan(values[i])) {
      values[i] = on.otherwise;
      continue;
    }
    if (values[i] >= least && values[i] <= most) continue;
    refuse(map, number_text(values[i]) + " at vertex " + std::to_string(i) + ", " +
                    point_text(on.rest.vertices[i]) + "; give " + number_text(least) + " to " +
                    number_text(most));
  }
  return values;
}

bool take_constant(std::vector<double>& values, double& number) {
  if (values.empty() ||
      std::any_of(values.begin(), values.end(), [&](double value) { return value != values[0]; })) {
    return false;
  }
  number = values[0];
  values.clear();
  return true;
}

void mirror_map(NodeMap& map) {
  for (NodeMap::Place& place : map.places) place.centre.x() *= -1.0;
  for (Vec3& point : map.points) point.x() *= -1.0;
}

void read_map_file(const std::filesystem::path& file, NodeMap& map) {
  const std::string text = read_whole(file, kFileLimit);
  std::size_t width = 0, line = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const auto words = split_words(std::string_view(text).substr(begin, end - begin));
    begin = end + 1;
    ++line;
    std::array<double, 4> values{};
    if (width == 0 && (words.size() == 1 || words.size() == 4)) width = words.size();
    bool good = width > 0 && words.size() == width;
    for (std::size_t k = 0; good && k < width; ++k) {
      const auto number = parse_number(words[k]);
      const bool is_value = k + 1 == width;
      good = number && (is_value ? *number >= map.bounds[0] && *number <= map.bounds[1]
                                 : std::abs(*number) <= kMaxCoordinate);
      if (good) values[k] = *number;
    }
    if (!good) {
      throw Error(ErrorCode::kInput,
                  file.string() + ":" + std::to_string(line) + ": is not a value of " + map.noun +
                      "; give one number from " + number_text(map.bounds[0]) + " to " +
                      number_text(map.bounds[1]) +
                      " a line, one line per vertex, or x y z value in each line, places within "
                      "10 km");
    }
    if (width == 1) {
      map.list.push_back(values[0]);
    } else {
      map.points.emplace_back(values[0], values[1], values[2]);
      map.at_points.push_back(values[3]);
    }
  }
  if (width == 0) {
    throw Error(ErrorCode::kInput, file.string() + ": is empty; give one value a line");
  }
}

}  // namespace thew::sim
