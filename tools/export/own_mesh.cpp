// SPDX-License-Identifier: Apache-2.0
#include "tools/export/own_mesh.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numeric>

#include "rig/import/character_import.h"
#include "rig/text.h"
#include "tools/export/character_skin.h"

namespace thew::tools {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string_view>;

constexpr std::size_t kFileLimit = std::size_t{256} << 20;  // bytes
constexpr double kSamePoint = 1e-5;  // m; programs write OBJ with six digits after the point

/// What is read of an OBJ. Corners of all faces stand one after another.
struct ObjFile {
  std::vector<Vec3> vertices;
  Faces faces;
  std::vector<std::array<float, 2>> uvs;
  std::vector<int> uv_corners;         // -1: a corner has none
  std::vector<std::string> materials;  // by face
};

class ObjReader {
 public:
  explicit ObjReader(const fs::path& file) : file_(file) {}

  ObjFile read() {
    const std::string bytes = read_whole(file_, kFileLimit);
    for (std::size_t begin = 0; begin < bytes.size(); ++line_) {
      const std::size_t end = std::min(bytes.find('\n', begin), bytes.size());
      read_line(split_words(std::string_view(bytes).substr(begin, end - begin)));
      begin = end + 1;
    }
    if (obj_.faces.counts.empty()) {
      throw Error(ErrorCode::kInput,
                  file_.string() + ": holds no faces; export the mesh as OBJ with its faces");
    }
    return std::move(obj_);
  }

 private:
  [[noreturn]] void refuse(const std::string& what) const {
    throw Error(ErrorCode::kInput, file_.string() + ":" + std::to_string(line_) + ": " + what +
                                       "; export the mesh as OBJ again");
  }

  void read_line(const Words& words) {
    if (words.empty()) return;
    if (words.back() == "\\") refuse("the line goes on in the next, which is not read");
    if (words[0] == "v") {
      obj_.vertices.emplace_back(number(words, 1), number(words, 2), number(words, 3));
    } else if (words[0] == "vt") {
      obj_.uvs.push_back({static_cast<float>(number(words, 1)),
                          words.size() > 2 ? static_cast<float>(number(words, 2)) : 0.0f});
    } else if (words[0] == "usemtl") {
      material_ = words.size() > 1 ? std::string(words[1]) : "";
    } else if (words[0] == "f") {
      if (words.size() < 4) refuse("a face has fewer than three corners");
      for (std::size_t k = 1; k < words.size(); ++k) add_corner(words[k]);
      obj_.faces.counts.push_back(static_cast<int>(words.size()) - 1);
      obj_.materials.push_back(material_);
    }
  }

  double number(const Words& words, std::size_t k) const {
    const auto value = k < words.size() ? parse_number(words[k]) : std::nullopt;
    if (!value || !std::isfinite(*value)) {
      refuse(std::string(words[0]) + " needs a number as its word " + std::to_string(k));
    }
    return *value;
  }

  // "vertex", "vertex/uv", "vertex//normal" or "vertex/uv/normal".
  void add_corner(std::string_view word) {
    const std::size_t slash = std::min(word.find('/'), word.size());
    obj_.faces.corners.push_back(place(word.substr(0, slash), obj_.vertices.size(), "vertex"));
    std::string_view uv = word.substr(std::min(slash + 1, word.size()));
    uv = uv.substr(0, std::min(uv.find('/'), uv.size()));
    obj_.uv_corners.push_back(uv.empty() ? -1 : place(uv, obj_.uvs.size(), "vt"));
  }

  // Numbers count from 1, or from -1 backwards.
  int place(std::string_view word, std::size_t count, const std::string& what) const {
    int value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    const auto have = static_cast<std::int64_t>(count);
    const std::int64_t at = value < 0 ? have + value : std::int64_t{value} - 1;
    if (error != std::errc() || end != word.data() + word.size() || at < 0 || at >= have) {
      refuse("a face names " + what + " \"" + printable(word) + "\" of " + std::to_string(have));
    }
    return static_cast<int>(at);
  }

  const fs::path& file_;
  ObjFile obj_;
  std::string material_;
  std::size_t line_ = 1;
};

/// Finds the vertex of a mesh that lies at a place.
class Places {
 public:
  explicit Places(const std::vector<Vec3>& points) : points_(points), by_x_(points.size()) {
    std::iota(by_x_.begin(), by_x_.end(), 0);
    std::stable_sort(by_x_.begin(), by_x_.end(),
                     [&](int a, int b) { return points_[a].x() < points_[b].x(); });
  }

  /// The nearest within kSamePoint, of several as near the first; -1: there is none.
  int at(const Vec3& p) const {
    int nearest = -1;
    double least = kSamePoint;
    const auto begin = std::lower_bound(by_x_.begin(), by_x_.end(), p.x() - kSamePoint,
                                        [&](int v, double x) { return points_[v].x() < x; });
    for (auto v = begin; v != by_x_.end() && points_[*v].x() <= p.x() + kSamePoint; ++v) {
      const double apart = (points_[*v] - p).norm();
      if (apart > least || (apart == least && nearest >= 0 && nearest < *v)) continue;
      least = apart;
      nearest = *v;
    }
    return nearest;
  }

  double distance(const Vec3& p) const {
    double least = std::numeric_limits<double>::infinity();
    for (const Vec3& q : points_) least = std::min(least, (q - p).norm());
    return least;
  }

 private:
  const std::vector<Vec3>& points_;
  std::vector<int> by_x_;
};

/// For each vertex of an OBJ the skin's, -1 where there is none.
struct Match {
  std::vector<int> from;
  std::size_t found = 0;
  double scale = 1.0;  ///< m for a unit of the OBJ
  std::size_t pose = 0;
};

// The best in any of the poses and units.
Match find_match(const ObjFile& obj, const std::vector<std::vector<Vec3>>& poses, double unit) {
  Match best;
  for (std::size_t pose = 0; pose < poses.size(); ++pose) {
    const Places places(poses[pose]);
    for (const double scale : {1.0, unit, 0.01, 0.01 * unit}) {
      Match match{{}, 0, scale, pose};
      for (const Vec3& p : obj.vertices) {
        match.from.push_back(places.at(scale * p));
        if (match.from.back() >= 0) ++match.found;
      }
      if (best.from.empty() || match.found > best.found) best = std::move(match);
      if (best.found == obj.vertices.size()) return best;
    }
  }
  return best;
}

// The skin at rest, and in the character's bind pose where its file is there.
std::vector<std::vector<Vec3>> poses_of(const BakeInfo& info, const fs::path& character) {
  std::vector<std::vector<Vec3>> poses = {info.meshes[skin_mesh(info)].rest.vertices};
  if (character.empty()) return poses;
  std::vector<Vec3> bind = import_character(character, info.character.scale).mesh.vertices;
  if (bind.size() == poses[0].size()) poses.push_back(std::move(bind));
  return poses;
}

[[noreturn]] void refuse_vertex(const fs::path& file, const fs::path& character, const ObjFile& obj,
                                const Match& match, const std::vector<Vec3>& pose) {
  const std::size_t lost = std::find(match.from.begin(), match.from.end(), -1) - match.from.begin();
  throw Error(
      ErrorCode::kInput,
      file.string() + ": " + std::to_string(obj.vertices.size() - match.found) + " of " +
          std::to_string(obj.vertices.size()) + " vertices are none of the bake's skin; vertex " +
          std::to_string(lost + 1) + " lies " +
          number_text(1e3 * Places(pose).distance(match.scale * obj.vertices[lost])) +
          " mm from it; export the mesh in its bind pose, y up, without modifiers" +
          (character.empty() ? ", and leave the character's file where the scene has it" : ""));
}

std::vector<Triangle> fans(const Faces& faces) {
  std::vector<Triangle> triangles;
  std::size_t first = 0;
  for (const int count : faces.counts) {
    for (int k = 2; k < count; ++k) {
      triangles.push_back(
          {faces.corners[first], faces.corners[first + k - 1], faces.corners[first + k]});
    }
    first += count;
  }
  return triangles;
}

std::vector<SkinLooks::Part> parts_of(const std::vector<std::string>& materials) {
  std::vector<SkinLooks::Part> parts;
  for (std::size_t f = 0; f < materials.size(); ++f) {
    auto part = std::find_if(parts.begin(), parts.end(),
                             [&](const auto& of) { return of.material == materials[f]; });
    if (part == parts.end()) part = parts.insert(parts.end(), {materials[f], {}, -1});
    part->faces.push_back(static_cast<int>(f));
  }
  if (parts.size() < 2) parts.clear();
  return parts;
}

}  // namespace

void put_onto_own_mesh(const fs::path& file, const fs::path& character, Shot& shot) {
  const int skin = skin_mesh(shot.info());
  if (skin < 0) {
    throw Error(ErrorCode::kUsage,
                "--onto " + file.string() + ": the bake has no skin; leave it out");
  }
  ObjFile obj = ObjReader(file).read();
  const auto poses = poses_of(shot.info(), character);
  Match match = find_match(obj, poses, shot.info().character.scale);
  if (match.found < obj.vertices.size()) {
    refuse_vertex(file, character, obj, match, poses[match.pose]);
  }
  const BakeMesh& baked = shot.info().meshes[skin];
  OwnMesh own{skin, {baked.name, baked.kind, {}, {}, {}}, {}, std::move(match.from)};
  for (const int v : own.from) own.mesh.rest.vertices.push_back(baked.rest.vertices[v]);
  own.mesh.rest.triangles = fans(obj.faces);
  shot.looks = {};
  // Without them everywhere there are none: a corner has to have one.
  if (std::find(obj.uv_corners.begin(), obj.uv_corners.end(), -1) == obj.uv_corners.end()) {
    shot.looks.uvs = {std::move(obj.uvs), std::move(obj.uv_corners)};
  }
  shot.looks.parts = parts_of(obj.materials);
  own.faces = std::move(obj.faces);
  shot.smooth[skin].resize(own.from.size());
  std::iota(shot.smooth[skin].begin(), shot.smooth[skin].end(), 0);
  shot.own = std::move(own);
}

}  // namespace thew::tools
