// SPDX-License-Identifier: Apache-2.0
// An exporter of your own: a sequence in the Object File Format (.off), which most mesh programs
// read: exporter BAKE.h5 FOLDER
// Writes FOLDER/MESH.FRAME.off for each mesh and frame, in m, +Y up, in the order of the mesh's
// file.
#include <thew/thew.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <limits>

namespace {

// The format: its name; how many vertices, faces and edges (0: not counted); a line for each
// vertex; a line for each face, which begins with how many corners it has.
void write_off(const std::filesystem::path& file, const std::vector<double>& positions,
               const std::vector<int>& triangles) {
  std::ofstream off(file);
  off.precision(std::numeric_limits<double>::max_digits10);
  off << "OFF\n" << positions.size() / 3 << ' ' << triangles.size() / 3 << " 0\n";
  for (std::size_t i = 0; i < positions.size(); i += 3) {
    off << positions[i] << ' ' << positions[i + 1] << ' ' << positions[i + 2] << '\n';
  }
  for (std::size_t i = 0; i < triangles.size(); i += 3) {
    off << "3 " << triangles[i] << ' ' << triangles[i + 1] << ' ' << triangles[i + 2] << '\n';
  }
  if (off.flush()) return;
  throw thew::Error(thew::ErrorCode::kOutput, file.string() + ": cannot be written");
}

std::string name_of(const thew::BakedMesh& mesh, int frame) {
  char number[16];
  std::snprintf(number, sizeof number, ".%04d.off", frame);
  return mesh.name + number;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return std::fprintf(stderr, "usage: exporter BAKE.h5 FOLDER\n"), 2;
  try {
    const std::filesystem::path folder = argv[2];
    std::filesystem::create_directories(folder);
    const thew::Bake bake(argv[1]);
    for (const thew::BakedMesh& mesh : bake.contents().meshes) {
      for (const int frame : bake.contents().frames) {
        write_off(folder / name_of(mesh, frame), bake.positions(mesh.name, frame),
                  mesh.rest.triangles);
      }
    }
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "%s\n", error.what()), 1;
  }
}
