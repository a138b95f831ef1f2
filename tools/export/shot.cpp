// SPDX-License-Identifier: Apache-2.0
#include "tools/export/shot.h"

#include <unistd.h>

#include <algorithm>

#include "rig/skeleton.h"
#include "rig/text.h"
#include "sim/cache/version.h"
#include "tools/base/bake_mesh.h"
#include "tools/base/output_file.h"
#include "tools/base/progress.h"
#include "tools/base/signals.h"

namespace thew::tools {
namespace {

std::vector<std::string> names_of(const BakeInfo& info) {
  std::vector<std::string> names;
  for (const BakeMesh& mesh : info.meshes) names.push_back(mesh.name);
  return names;
}

int find_mesh(const BakeInfo& info, const std::string& name) {
  const std::vector<std::string> names = names_of(info);
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) {
    const std::string near = nearest_name(name, names);
    throw Error(ErrorCode::kUsage,
                "--mesh " + name + ": the bake has no such mesh; " +
                    (near.empty() ? "" : "did you mean \"" + printable(near) + "\"? ") + "it has " +
                    names_text(names));
  }
  return static_cast<int>(found - names.begin());
}

std::vector<Vec3> chosen_of(const Shot& shot, std::size_t m, std::vector<Vec3> positions) {
  if (!shot.is_own(m)) return positions;
  std::vector<Vec3> own;
  for (const int v : shot.own->from) own.push_back(positions[v]);
  return own;
}

int find_frame(const BakeInfo& info, const std::string& asked, int frame) {
  const auto found = std::lower_bound(info.frames.begin(), info.frames.end(), frame);
  if (found == info.frames.end() || *found != frame) {
    throw Error(ErrorCode::kUsage, "--frames " + asked + ": frame " + std::to_string(frame) +
                                       " is not in the bake, which has " +
                                       std::to_string(info.frames.size()) + " from " +
                                       std::to_string(info.frames.front()) + " to " +
                                       std::to_string(info.frames.back()) + "; choose among these");
  }
  return static_cast<int>(found - info.frames.begin());
}

}  // namespace

Shot choose_shot(const BakeReader& reader, const std::vector<std::string>& names,
                 const std::string& frames) {
  const BakeInfo& info = reader.info();
  Shot shot{reader, {}, {}};
  for (const std::string& name : names.empty() ? names_of(info) : names) {
    const int mesh = find_mesh(info, name);
    if (std::find(shot.meshes.begin(), shot.meshes.end(), mesh) == shot.meshes.end()) {
      shot.meshes.push_back(mesh);
    }
  }
  shot.smooth.resize(info.meshes.size());
  for (const int mesh : shot.meshes) shot.smooth[mesh] = shaded_vertices(info.meshes[mesh]);
  for (const int frame : frames.empty() ? info.frames : parse_frames(frames)) {
    shot.places.push_back(find_frame(info, frames, frame));
  }
  return shot;
}

void for_each_frame(const Shot& shot, const std::function<void(const ShotFrame&)>& work) {
  Progress progress(shot.progress, "exporting", static_cast<int>(shot.places.size()), stderr);
  int done = 0;
  for (const int place : shot.places) {
    stop_if_interrupted();
    BakeFrame baked = shot.reader.read(place);
    ShotFrame frame{place, baked.frame, {}, {}, std::move(baked.bodies)};
    for (std::size_t m = 0; m < shot.meshes.size(); ++m) {
      frame.positions.push_back(chosen_of(shot, m, std::move(baked.positions[shot.meshes[m]])));
      frame.lines.push_back(std::move(baked.lines[shot.meshes[m]]));
    }
    work(frame);
    progress.step(++done, frame.frame);
  }
}

std::vector<ShotFrame> all_frames(const Shot& shot) {
  std::vector<ShotFrame> frames;
  for_each_frame(shot, [&](const ShotFrame& frame) { frames.push_back(frame); });
  return frames;
}

std::vector<std::vector<Vec3>> velocities(const Shot& shot, int place) {
  const std::vector<int>& frames = shot.info().frames;
  const int before = std::max(place - 1, 0);
  const int after = std::min(place + 1, static_cast<int>(frames.size()) - 1);
  const BakeFrame a = shot.reader.read(before), b = shot.reader.read(after);
  const double seconds = std::max(b.frame - a.frame, 1) / shot.info().fps;
  std::vector<std::vector<Vec3>> result;
  for (std::size_t m = 0; m < shot.meshes.size(); ++m) {
    const std::vector<Vec3> from = chosen_of(shot, m, a.positions[shot.meshes[m]]),
                            to = chosen_of(shot, m, b.positions[shot.meshes[m]]);
    auto& velocity = result.emplace_back(from.size());
    for (std::size_t v = 0; v < velocity.size(); ++v) {
      velocity[v] = (to[v] - from[v]) / seconds;
    }
  }
  return result;
}

std::vector<std::pair<std::string, const std::vector<double>*>> metrics_of(const Shot& shot,
                                                                           const BakeMesh& mesh) {
  std::vector<std::pair<std::string, const std::vector<double>*>> metrics;
  const std::vector<std::string>& names = shot.info().metric_names;
  for (const std::string metric : {"activation", "length", "penetration"}) {
    const bool skin = mesh.kind == BakeMesh::Kind::kSkin;
    const auto found =
        std::find(names.begin(), names.end(), skin ? "skin_" + metric : metric + "/" + mesh.name);
    if (found == names.end()) continue;
    metrics.emplace_back(metric, &shot.reader.metric(static_cast<int>(found - names.begin())));
  }
  return metrics;
}

std::vector<Vec3> unit_normals(const Shot& shot, std::size_t m,
                               const std::vector<Vec3>& positions) {
  const std::vector<int>& first = shot.smooth[shot.meshes[m]];
  TriMesh joined{positions, shot.mesh(m).rest.triangles};
  for (Triangle& triangle : joined.triangles) {
    for (int& vertex : triangle) vertex = first[vertex];
  }
  std::vector<Vec3> normals = vertex_normals(joined);
  for (std::size_t i = 0; i < normals.size(); ++i) normals[i] = normals[first[i]];
  for (Vec3& normal : normals) {
    if (normal.isZero(0.0)) normal = Vec3::UnitY();
  }
  return normals;
}

const BakeMesh& only_mesh(const Shot& shot, const std::string& format) {
  if (shot.meshes.size() != 1) {
    throw Error(ErrorCode::kUsage,
                format + " holds one mesh and the bake has " + std::to_string(shot.meshes.size()) +
                    "; choose with --mesh: " + names_text(names_of(shot.info())));
  }
  return shot.mesh(0);
}

Facts facts_of(const Shot& shot) {
  std::vector<std::string> frames;
  const std::size_t last = shot.places.size() - 1;
  const bool all = shot.frame(last) - shot.first_frame() == static_cast<int>(last);
  return {{"program", std::string("Thew ") + kVersion},
          {"scene", one_line(shot.info().scene_name)},
          {"bake_hash", shot.info().hash},
          {"units", "m"},
          {"up_axis", "Y"},
          {"fps", digits(shot.info().fps)},
          {"first_frame", std::to_string(shot.first_frame())},
          {"last_frame", std::to_string(shot.frame(last))},
          {"frame_count", std::to_string(shot.places.size()) + (all ? "" : ", not every frame")},
          {"vertex_order", shot.own ? "of the skin that of the file of --onto, else as in the bake"
                                    : "as in the bake, which is the input's"}};
}

std::string facts_as_lines(const Shot& shot, const std::string& mark) {
  std::string text;
  for (const auto& [name, value] : facts_of(shot)) text += mark + name + ": " + value + "\n";
  return text;
}

std::string one_line(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < ' ' || c == 127) c = ' ';
  }
  return text;
}

}  // namespace thew::tools
