// SPDX-License-Identifier: Apache-2.0
//
// PC2 (little-endian): "POINTCACHE2\0", int32 version 1, int32 points, float32 first frame, float32
// frames between samples, int32 samples; then float32 x, y, z by sample and point.
// MDD (big-endian): int32 samples, int32 points, float32 seconds by sample; then as PC2.
#include <algorithm>
#include <functional>

#include "tools/base/output_file.h"
#include "tools/export/formats.h"
#include "tools/export/obj.h"

namespace thew::tools {
namespace {

template <typename T>
void put_big(std::string& bytes, T value) {
  const std::size_t at = bytes.size();
  put(bytes, value);
  std::reverse(bytes.begin() + static_cast<std::ptrdiff_t>(at), bytes.end());
}

// Frames from one sample to the next.
int even_step(const Shot& shot, const std::filesystem::path& file) {
  if (shot.places.size() == 1) return 1;
  const int step = shot.frame(1) - shot.frame(0);
  for (std::size_t i = 2; i < shot.places.size(); ++i) {
    if (shot.frame(i) - shot.frame(i - 1) != step) {
      throw Error(ErrorCode::kUsage, file.string() + ": PC2 holds frames at even steps and frame " +
                                         std::to_string(shot.frame(i)) + " breaks the step of " +
                                         std::to_string(step) +
                                         "; choose others with --frames, or write .mdd");
    }
  }
  return step;
}

// Blender shows the samples one after another, and reads neither PC2's frames nor, but for this
// mode, MDD's seconds: its place among them is Frame Scale * frame - Frame Start.
std::string blender_note(const Shot& shot) {
  const int step = shot.places.size() > 1 ? shot.frame(1) - shot.frame(0) : 1;
  for (std::size_t i = 1; i < shot.places.size(); ++i) {
    if (shot.frame(i) - shot.frame(i - 1) != step) return "Time Mode to Time, Frame Start to 0";
  }
  std::string note = "Frame Start to " + digits(1.0 * shot.first_frame() / step);
  if (step > 1) note += ", Frame Scale to " + digits(1.0 / step);
  return note;
}

// Some vertices of a mesh, and the triangles between them.
BakeMesh some_of(const BakeMesh& mesh, const std::vector<int>& vertices) {
  if (vertices.empty()) return mesh;
  BakeMesh some{mesh.name, mesh.kind, {}, {}, {}};
  std::vector<int> place(mesh.rest.vertices.size(), -1);
  for (const int vertex : vertices) {
    place[vertex] = static_cast<int>(some.rest.vertices.size());
    some.rest.vertices.push_back(mesh.rest.vertices[vertex]);
  }
  for (const Triangle& t : mesh.rest.triangles) {
    const Triangle moved = {place[t[0]], place[t[1]], place[t[2]]};
    if (moved[0] >= 0 && moved[1] >= 0 && moved[2] >= 0) some.rest.triangles.push_back(moved);
  }
  return some;
}

std::string rest_text(const BakeMesh& mesh, bool double_precision) {
  std::string text = "o " + one_line(mesh.name) + "\n";
  for (const Vec3& p : mesh.rest.vertices) {
    text += "v " + (double_precision ? digits<double>(p) : digits<float>(p)) + "\n";
  }
  for (const Triangle& t : mesh.rest.triangles) {
    text += "f";
    for (const int vertex : t) text += " " + std::to_string(vertex + 1);
    text += "\n";
  }
  return text;
}

// Of all points, or of some.
void for_each_point(const std::vector<Vec3>& points, const std::vector<int>& vertices,
                    const std::function<void(const Vec3&)>& work) {
  if (vertices.empty()) {
    for (const Vec3& p : points) work(p);
  }
  for (const int vertex : vertices) work(points[vertex]);
}

Exported finish(const Shot& shot, ExportFile& out, const std::filesystem::path& file,
                const std::vector<int>& vertices) {
  WrittenFiles written;
  out.finish();
  written.add(file);
  const std::filesystem::path rest = rest_file(file);
  ExportFile rest_out(rest);
  rest_out.append(facts_as_lines(shot, "# ") + "# rest mesh, for " + file.filename().string() +
                  "\n");
  rest_out.append(vertices.empty()
                      ? obj_text(shot, obj_faces(shot), {shot.mesh(0).rest.vertices})
                      : rest_text(some_of(shot.mesh(0), vertices), shot.info().double_precision));
  rest_out.finish();
  written.add(rest);
  return {written.keep(), "put the cache on the mesh of " + rest.filename().string() +
                              "; in Blender's Mesh Cache set " + blender_note(shot)};
}

}  // namespace

std::filesystem::path rest_file(const std::filesystem::path& cache) {
  return std::filesystem::path(cache).replace_extension(".rest.obj");
}

Exported export_pc2(const Shot& shot, const std::filesystem::path& file,
                    const std::vector<int>& vertices) {
  const std::size_t points =
      vertices.empty() ? only_mesh(shot, "PC2").rest.vertices.size() : vertices.size();
  std::string bytes = "POINTCACHE2";
  bytes += '\0';
  put<std::int32_t>(bytes, 1);
  put(bytes, static_cast<std::int32_t>(points));
  put(bytes, static_cast<float>(shot.first_frame()));
  put(bytes, static_cast<float>(even_step(shot, file)));
  put(bytes, static_cast<std::int32_t>(shot.places.size()));
  ExportFile out(file);
  out.append(bytes);
  for_each_frame(shot, [&](const ShotFrame& frame) {
    bytes.clear();
    for_each_point(frame.positions[0], vertices, [&](const Vec3& p) { put_floats(bytes, p); });
    out.append(bytes);
  });
  return finish(shot, out, file, vertices);
}

Exported export_mdd(const Shot& shot, const std::filesystem::path& file,
                    const std::vector<int>& vertices) {
  const std::size_t points =
      vertices.empty() ? only_mesh(shot, "MDD").rest.vertices.size() : vertices.size();
  std::string bytes;
  put_big(bytes, static_cast<std::int32_t>(shot.places.size()));
  put_big(bytes, static_cast<std::int32_t>(points));
  for (std::size_t i = 0; i < shot.places.size(); ++i) {
    put_big(bytes, static_cast<float>(shot.frame(i) / shot.info().fps));
  }
  ExportFile out(file);
  out.append(bytes);
  for_each_frame(shot, [&](const ShotFrame& frame) {
    bytes.clear();
    for_each_point(frame.positions[0], vertices, [&](const Vec3& p) {
      for (int axis = 0; axis < 3; ++axis) put_big(bytes, static_cast<float>(p[axis]));
    });
    out.append(bytes);
  });
  return finish(shot, out, file, vertices);
}

}  // namespace thew::tools
