// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "rig/character.h"

namespace thew::rig {

// Functions that the readers of all character formats share. Private to the library; to be called
// in a child process.

/// For each vertex its influences: (link, weight), see SkinWeights.
using Influences = std::vector<std::vector<std::pair<int, double>>>;

inline constexpr int kMaxBodies = 10000;  ///< far above any rig; bounds memory and time

/// Sets unique names of bodies. Where several have one name, which Blender allows a mesh and a
/// bone, bodies without a mesh come first, and the later ones get "_2" and so on.
void name_bodies(const std::vector<std::string>& plain, const std::vector<char>& has_mesh,
                 Skeleton& skeleton);

/// Appends a part to the mesh of the character. `vertices` are in the file's frame of the mesh, and
/// `to_world` takes them to the bind pose; one that mirrors reverses the winding of the triangles.
/// Returns the index of the first vertex. Throws Error(kInput) if the transform is singular or a
/// vertex is not finite.
int append_part(const std::filesystem::path& file, const MeshPart& about,
                const std::vector<Vec3>& vertices, const std::vector<Triangle>& triangles,
                const Affine& to_world, Influences& influences, Character& character);

/// Attaches vertices from `first` on that have no weights to `body`, whose transform in the bind
/// pose is `bind`. Adds a warning if the mesh is `skinned`.
void attach_unweighted(const std::filesystem::path& file, int first, int body, const Affine& bind,
                       bool skinned, Influences& influences, Character& character);

/// Takes away parts that are a coarser level of detail of another: of names that are the same but
/// for "LOD" and a number ("Body_LOD1" beside "Body_LOD0" or "Body"), by node or by mesh, all but
/// the lowest number. Adds a warning. To be called before put_weights().
void leave_out_coarser(const std::filesystem::path& file, Influences& influences,
                       Character& character);

/// Stores the influences in the skin of the character, scaled so that the weights of each vertex
/// sum to 1. Adds a warning if sums differ from 1 by more than 1 %.
void put_weights(const std::filesystem::path& file, const Influences& influences,
                 Character& character);

/// Sets size_doubt if the largest extent of the mesh is outside 0.3 to 3 m.
void note_size(const std::filesystem::path& file, Character& character);

}  // namespace thew::rig
