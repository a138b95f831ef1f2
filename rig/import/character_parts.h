// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "rig/character.h"

namespace thew::rig {

// What the readers of characters share. Private to the library; to be called in a child process.

/// By vertex: (link, weight).
using Influences = std::vector<std::vector<std::pair<int, double>>>;

inline constexpr int kMostBodies = 10000;

/// Names of bodies, each once: where two share one, as Blender lets a mesh and a bone, those
/// without a mesh come first, and the others get "_2" and so on.
void name_bodies(const std::vector<std::string>& plain, const std::vector<char>& has_mesh,
                 Skeleton& skeleton);

/// `mesh` and its triangles go to `place`, a mirroring one turns triangles about. The index of the
/// first vertex. `part` is in the file's frame of the mesh. Error(kInput) where a place is none.
int append_part(const std::filesystem::path& file, const MeshPart& about,
                const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles,
                const Affine& place, Influences& influences, Character& character);

/// Vertices from `first` on that nobody weighted go with a body that lies at `bind`.
void hold_unweighted(const std::filesystem::path& file, int first, int body, const Affine& bind,
                     bool skinned, Influences& influences, Character& character);

/// The weights of each vertex, made to sum to 1; a warning where they do not.
void put_weights(const std::filesystem::path& file, const Influences& influences,
                 Character& character);

/// What of a character is not as large as a person is.
void note_size(const std::filesystem::path& file, Character& character);

}  // namespace thew::rig
