// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sim/cache/cache.h"
#include "tools/render/camera.h"

namespace thew::tools {

/// What changes from frame to frame.
struct DrawVertex {
  float position[3], normal[3];
};

/// What does not. `coordinate`: muscles (u, cos angle, sin angle, belly 1..0), so that it can be
/// interpolated across the seam; others their rest position (m).
struct DrawConstant {
  float coordinate[4];
  float weight;
  std::uint8_t tint[4];  ///< RGB and nothing
};

/// One mesh as it is drawn: its own vertices, then one on each edge if it is refined.
struct DrawMesh {
  std::vector<Triangle> triangles;        ///< as they are shaded
  std::vector<std::array<int, 2>> edges;  ///< none: it is not refined
  std::size_t first_vertex = 0, vertex_count = 0;
};

using ShownKinds = std::array<bool, 4>;  ///< by BakeMesh::Kind

Vec3 position_of(const DrawVertex& vertex);

/// All meshes in one array, by kind: muscles, bones, skin, props.
struct DrawGeometry {
  std::vector<DrawMesh> meshes;
  std::vector<DrawConstant> constants;
  std::vector<std::uint32_t> indices;
  std::array<std::size_t, 5> first_index{};  ///< by BakeMesh::Kind, and the end
  std::array<bool, 4> closed{true, true, true,
                             true};  ///< by kind: closed and outward, no back is seen
  std::vector<DrawVertex> vertices;
  float largest_weight = 2.0f;  ///< end of the colour scale: twice even, or the largest
};

/// Triangles are cut in four where a mesh's edges are flatter than `flat` (m) at rest, in the mean.
DrawGeometry make_draw_geometry(const std::vector<BakeMesh>& meshes, double flat = 0.0);

/// As a cache of single precision holds them: a bake draws what is drawn from its cache again.
std::vector<std::vector<Vec3>> as_in_cache(std::vector<std::vector<Vec3>> positions);

/// A mesh as it was sent last.
struct SentMesh {
  bool ever = false;
  std::vector<Vec3> positions;  ///< as in a cache
  Bounds bounds;
};

/// Whether that is another place than it was sent from; then it is taken for sent from there.
bool moves(const std::vector<Vec3>& to, SentMesh& sent);

/// Vertices of one mesh at `positions`: area-weighted smooth normals, and edge points on the cubic
/// of PN triangles (Vlachos 2001).
void place_vertices(const DrawMesh& mesh, const std::vector<Vec3>& positions,
                    DrawGeometry& geometry);

/// Slim quads facing `eye`, from each muscle vertex along its normal, `unit` metres long per weight
/// and `width` wide per metre of distance from the eye; two triangles each. After place_vertices.
std::vector<DrawVertex> weight_quads(const std::vector<BakeMesh>& meshes,
                                     const DrawGeometry& geometry, const Vec3& eye, double unit,
                                     double width);

}  // namespace thew::tools
