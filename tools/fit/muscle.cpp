// SPDX-License-Identifier: Apache-2.0
//
// A muscle of the template on a character's arm: its path, its belly, its table in the scene.
#include <algorithm>
#include <cstdio>
#include <numeric>

#include "rig/text.h"
#include "tools/base/obj_text.h"
#include "tools/fit/target.h"

namespace thew::tools {

namespace fs = std::filesystem;

namespace {

// A tendon of a slender arm, whose nodes lie closer than contact tells apart, is made so much
// thicker that they do not; what would have to be more than that is a thread.
constexpr double kSoundEdge = 1.2;    // of the least edge
constexpr double kMostThicker = 5.0;  // times
constexpr int kSteps = 4;             // of evening out the nodes of a ring

double shortest_edge(const std::vector<Vec3>& ring) {
  double least = 1e3;
  for (size_t k = 0; k < ring.size(); ++k) {
    least = std::min(least, (ring[(k + 1) % ring.size()] - ring[k]).norm());
  }
  return least;
}

// A ring's nodes moved along it, so that they lie at equal distances at share 1.
std::vector<Vec3> spread(const std::vector<Vec3>& ring, double share) {
  const size_t n = ring.size();
  std::vector<double> at = {0.0};  // m around, of the nodes and of the first again
  for (size_t k = 0; k < n; ++k) at.push_back(at[k] + (ring[(k + 1) % n] - ring[k]).norm());
  std::vector<Vec3> out;
  for (size_t k = 0, edge = 0; k < n; ++k) {
    const double place = (1.0 - share) * at[k] + share * at[n] * k / n;
    while (edge + 1 < n && at[edge + 1] < place) ++edge;
    const double length = at[edge + 1] - at[edge];
    const double u = length > 0.0 ? std::min((place - at[edge]) / length, 1.0) : 0.0;
    out.push_back((1.0 - u) * ring[edge] + u * ring[(edge + 1) % n]);
  }
  return out;
}

}  // namespace

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (char c : text) {
    if (c == '"' || c == '\\') out.push_back('\\');
    out.push_back(c);
  }
  return out + "\"";
}

std::string points_text(const std::vector<PathPoint>& points,
                        const std::function<std::string(int body)>& name_of) {
  std::string text = "path = [\n";
  for (const PathPoint& point : points) {
    const std::string body = quoted(name_of(point.body)), at = metres(point.position, ", ");
    text += point.with < 0 ? "  [" + body + ", " + at + "],\n"
                           : "  { body = " + body + ", at = [" + at +
                                 "], with = " + quoted(name_of(point.with)) +
                                 ", share = " + metres(point.share) + " },\n";
  }
  return text + "]\n";
}

std::string weights_text(const std::vector<std::array<double, 2>>& keys) {
  for (const char* preset : {"left", "even", "right"}) {
    if (preset_profile(preset).keys == keys) return quoted(preset);
  }
  std::string text;
  for (const auto& [u, w] : keys) {
    text += (text.empty() ? "[" : ", [") + metres(u) + ", " + metres(w) + "]";
  }
  return "{ profile = [" + text + "] }";
}

std::string wraps_text(const std::vector<WrapCylinder>& wraps,
                       const std::function<std::string(int body)>& name_of) {
  std::string text;
  for (const WrapCylinder& wrap : wraps) {
    text += std::string(text.empty() ? "" : ",\n  ") +
            "{ segment = " + std::to_string(wrap.segment) +
            ", body = " + quoted(name_of(wrap.body)) + ", centre = [" + metres(wrap.centre, ", ") +
            "], axis = [" + metres(wrap.axis, ", ") + "], radius = " + metres(wrap.radius) +
            ", turn = " + metres(wrap.turn) + " }";
  }
  if (wraps.size() > 1) text = "\n  " + text + ",\n";
  return wraps.empty() ? "" : "wrap = [" + text + "]\n";
}

TriMesh mapped_mesh(const Target& to, TriMesh mesh) {
  for (Vec3& p : mesh.vertices) p = to.mapped(p);
  if (to.fit.mirrored) {
    for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  }
  return mesh;
}

namespace {

// Ring by ring, so that tendons keep their thickness in a narrow hand.
void move_into_hand(const Target& to, TriMesh& tube) {
  const std::vector<Vec3> before = tube.vertices;
  for (Vec3& p : tube.vertices) p = to.in_hand(p);
  for (const Ring& of : rings_of(tube)) {
    const auto begin = before.begin() + of.first, end = begin + of.nodes;
    const Vec3 middle = std::accumulate(begin, end, Vec3(Vec3::Zero())) / of.nodes;
    const Vec3 by = to.in_hand(middle) - middle;
    for (int k = of.first; k < of.first + of.nodes; ++k) tube.vertices[k] = before[k] + by;
  }
}

}  // namespace

TriMesh mapped_muscle(const Target& to, const TriMesh& mesh) {
  TriMesh out = mapped_mesh(to, mesh);
  const double least = kSoundEdge * least_edge(to.fit);
  for (const Ring& of : rings_of(out)) {
    const auto begin = out.vertices.begin() + of.first, end = begin + of.nodes;
    std::vector<Vec3> ring(begin, end);
    // Along the ring first, which leaves its shape as it is; a ring too small for that is a
    // tendon's.
    for (int step = 1; step <= kSteps && shortest_edge(ring) < least; ++step) {
      ring = spread(std::vector<Vec3>(begin, end), 1.0 * step / kSteps);
    }
    const double thicker = least / shortest_edge(ring);
    if (thicker > 1.0 && thicker <= kMostThicker) {
      const Vec3 middle = std::accumulate(begin, end, Vec3(Vec3::Zero())) / of.nodes;
      for (Vec3& p : ring) p = middle + thicker * (p - middle);
    }
    std::copy(ring.begin(), ring.end(), begin);
  }
  if (to.in_hand) move_into_hand(to, out);
  return out;
}

namespace {

MusclePath template_path(const Template& from, const SceneMuscle& muscle) {
  MusclePath path;
  for (const ScenePathPoint& point : muscle.path) {
    PathPoint& added =
        path.points.emplace_back(PathPoint{find_body(from.skeleton, point.body), point.position});
    if (!point.with.empty()) {
      share_turn(find_body(from.skeleton, point.with), point.share, from.rest, added);
    }
  }
  for (const SceneWrap& wrap : muscle.wraps) {
    path.wraps.push_back({wrap.segment, find_body(from.skeleton, wrap.body), wrap.centre,
                          wrap.axis.normalized(), wrap.radius, wrap.turn});
  }
  return path;
}

MusclePath mapped_path(const Target& to, MusclePath path) {
  std::vector<Vec3> points;     // in the template
  std::vector<double> heights;  // of them, over its humerus
  for (PathPoint& point : path.points) {
    points.push_back(to.from.rest[point.body] * point.position);
    heights.push_back(points.back().y() - to.from.humerus.y());
    const Vec3 world = to.placed(points.back());
    point.body = to.body_of(point.body);
    point.position = to.rest[point.body].inverse() * world;
    if (point.with >= 0) share_turn(to.body_of(point.with), point.share, to.rest, point);
  }
  for (WrapCylinder& wrap : path.wraps) {
    const Transform& place = to.from.rest[wrap.body];
    const Vec3 before = place * wrap.centre, world = to.mapped(before);
    const Vec3 axis = to.fit.hang.linear() * to.fit.frame * (place.linear() * wrap.axis);
    // By the girth on the path's side, as the bone there: by the mean of all sides the flesh would
    // be carried through that, and contact would throw it to and fro.
    const Vec3 middle = 0.5 * (points[wrap.segment] + points[wrap.segment + 1]) - before;
    const Vec3 out = wrap.radius * (place.linear() * wrap.axis).cross(Vec3::UnitY()).normalized();
    wrap.radius = (to.mapped(before + (out.dot(middle) > 0.0 ? out : Vec3(-out))) - world).norm();
    wrap.body = to.body_of(wrap.body);
    wrap.centre = to.rest[wrap.body].inverse() * world;
    wrap.axis = (to.rest[wrap.body].linear().transpose() * axis).normalized();
    if (to.fit.mirrored) wrap.turn = -wrap.turn;
  }
  hold_at_elbow(to.fit, to.arm, to.rest, heights, path);
  hold_at_shoulder(to.arm, to.rest, path);
  return path;
}

// The same places along the mapped path, in its own metres.
std::array<double, 2> mapped_belly(const Target& to, const MusclePath& before,
                                   const MusclePath& after, const std::array<double, 2>& belly) {
  const TracedPath traced = trace_path(before, to.from.rest);
  std::vector<double> s = {0.0}, mapped = {0.0};
  for (size_t i = 1; i < traced.points.size(); ++i) {
    const Vec3 &a = traced.points[i - 1], &b = traced.points[i];
    s.push_back(s.back() + (b - a).norm());
    mapped.push_back(mapped.back() + (to.placed(b) - to.placed(a)).norm());
  }
  const double length = trace_path(after, to.rest).length;
  std::array<double, 2> out;
  for (int k = 0; k < 2; ++k) {
    const double at = belly[k] / traced.length * s.back();
    size_t i = 1;
    while (i + 1 < s.size() && s[i] < at) ++i;
    const double u = s[i] > s[i - 1] ? (at - s[i - 1]) / (s[i] - s[i - 1]) : 0.0;
    out[k] =
        std::clamp((mapped[i - 1] + u * (mapped[i] - mapped[i - 1])) / mapped.back(), 0.0, 1.0) *
        length;
  }
  return out;
}

}  // namespace

std::string muscle_text(const Target& to, const SceneMuscle& muscle, const std::string& name,
                        const fs::path& mesh, const MappedSize& size) {
  const MusclePath before = template_path(to.from, muscle), after = mapped_path(to, before);
  const std::array<double, 2> belly = mapped_belly(to, before, after, muscle.belly);
  char note[160];
  std::snprintf(note, sizeof note,
                "# %.2f cm3 at rest, %.2f of the template's; %.1f mm or more under the skin\n",
                1e6 * size.volume, size.volume_ratio, 1e3 * size.fat);
  std::string text = note + std::string("[[muscle]]\nname = ") + quoted(name) +
                     "\nmesh = " + quoted(mesh.string()) + "\n";
  text += points_text(after.points, [&](int body) { return to.name_of(body); });
  text += wraps_text(after.wraps, [&](int body) { return to.name_of(body); });
  // Force goes with the section, fibres with the length.
  const double along = (belly[1] - belly[0]) / (muscle.belly[1] - muscle.belly[0]);
  const double section = size.volume_ratio / along;
  // No twist_from: on a character's arm the twist is the shoulder's too, and rolls of 90 degrees
  // wring so short a tendon.
  return text + "belly = [" + metres(belly[0]) + ", " + metres(belly[1]) +
         "]\nweights = " + weights_text(muscle.weights.keys) +
         "\nf_max = " + number_text(muscle.f_max * section) +
         "\nfibre_length = " + metres(muscle.fibre_length * along) + "\n\n";
}

}  // namespace thew::tools
