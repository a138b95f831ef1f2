// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/cache/cache.h"
#include "tools/base/options.h"

namespace thew::tools {

/// Polygons: so many corners each, whose vertices stand one after another.
struct Faces {
  std::vector<int> counts, corners;
};

/// Texture coordinates, v up. The k-th corner of the faces has values[corners[k]]. Empty: none.
struct Uvs {
  std::vector<std::array<float, 2>> values;
  std::vector<int> corners;
};

/// A material of the metal and roughness kind, as glTF and USD's preview surface have it.
struct SkinMaterial {
  std::string name;
  std::array<float, 4> colour = {1, 1, 1, 1};  ///< base colour, linear, and alpha
  std::array<float, 3> emission = {0, 0, 0};
  float metallic = 1, roughness = 1;
  float cut = 0;             ///< alpha below it is not drawn; 0: there is no such limit
  bool see_through = false;  ///< alpha counts
  int image = -1;            ///< by which the colour is multiplied; -1: none
};
struct SkinImage {
  std::string name;  ///< of a file, with its ending; no two have the same
  std::string bytes;
};

/// What a character's file says of the bake's skin beside its shape.
struct SkinLooks {
  struct Part {
    std::string material;
    std::vector<int> faces;
    int look = -1;  ///< in `materials`; -1: the file gives none
  };
  Uvs uvs;
  std::vector<SkinMaterial> materials = {};
  std::vector<SkinImage> images = {};  ///< PNG or JPEG
  std::string unread = {};  ///< why the file's materials were left out; "": they were not
  int look = -1;            ///< of the whole, where there are no parts
  std::vector<Part> parts;  ///< by material, where there are more than one
  std::vector<int> smooth;  ///< as Shot::smooth
};

/// A mesh in place of the bake's own, of whose vertices it has some, in its order: own_mesh.h.
struct OwnMesh {
  int instead_of = -1;  ///< place in the bake's
  BakeMesh mesh;        ///< at rest; its triangles are fans of the faces
  Faces faces;
  std::vector<int> from;  ///< by vertex, the bake's
};

/// What of a bake is exported: some of its meshes, some of its frames.
struct Shot {
  const BakeReader& reader;
  std::vector<int> meshes;  ///< places in the bake's
  std::vector<int> places;  ///< of the frames among the bake's, rising
  ProgressStyle progress = ProgressStyle::kNone;
  /// By the bake's mesh and vertex, the first vertex that is shaded as one with it.
  std::vector<std::vector<int>> smooth = {};
  bool fields = false;   ///< by node and frame: fibre directions, stretch of the skin
  SkinLooks looks = {};  ///< empty where the bake's skin is no character's or its file is not found
  std::optional<OwnMesh> own = {};

  const BakeInfo& info() const { return reader.info(); }
  bool is_own(std::size_t m) const { return own && own->instead_of == meshes[m]; }
  const BakeMesh& mesh(std::size_t m) const {
    return is_own(m) ? own->mesh : info().meshes[meshes[m]];
  }
  int frame(std::size_t i) const { return info().frames[places[i]]; }
  int first_frame() const { return frame(0); }
};

/// `names` empty: all meshes; `frames` as on the command line, "" for all. Error(kUsage) with what
/// the bake has where it lacks one of them.
Shot choose_shot(const BakeReader& reader, const std::vector<std::string>& names,
                 const std::string& frames);

/// Positions of vertices and, where the format is given them, their normals of length 1.
struct Shape {
  std::vector<Vec3> positions, normals;
};

struct ShotFrame {
  int place = 0;  ///< in the bake
  int frame = 0;
  std::vector<std::vector<Vec3>> positions;  ///< by chosen mesh, m
  std::vector<std::vector<Vec3>> lines;      ///< of action, by chosen mesh, m; empty: it has none
  std::vector<BodyFrame> bodies;             ///< of the bake's character
};

/// In the order of time; tells how far it is and ends with Error(kRetry) on a signal.
void for_each_frame(const Shot& shot, const std::function<void(const ShotFrame&)>& work);
/// For the formats that are not written frame by frame.
std::vector<ShotFrame> all_frames(const Shot& shot);

/// m/s, by chosen mesh: the difference of the bake's frames before and after over their time, at
/// the first and the last frame that to the neighbour. A bake of one frame stands still.
std::vector<std::vector<Vec3>> velocities(const Shot& shot, int place);

/// What the bake has measured of a mesh and other programs may use, by name, values by place of the
/// frame: of a muscle its activation, the length of its whole path (m), and the depth of its
/// deepest node in another muscle or bone (m, "penetration"); of the skin that depth alone.
std::vector<std::pair<std::string, const std::vector<double>*>> metrics_of(const Shot& shot,
                                                                           const BakeMesh& mesh);

/// Of the m-th mesh, one a vertex, of length 1: a vertex without area gets up.
std::vector<Vec3> unit_normals(const Shot& shot, std::size_t m, const std::vector<Vec3>& positions);

/// The only mesh that is chosen. Error(kUsage) with the choice where there are more.
const BakeMesh& only_mesh(const Shot& shot, const std::string& format);

/// What each export states of itself, name and text: units, axis, fps, first frame, vertex order…
using Facts = std::vector<std::pair<std::string, std::string>>;
Facts facts_of(const Shot& shot);
/// The same as lines, each after `mark`.
std::string facts_as_lines(const Shot& shot, const std::string& mark);

/// Without line breaks or other control characters.
std::string one_line(std::string text);

}  // namespace thew::tools
