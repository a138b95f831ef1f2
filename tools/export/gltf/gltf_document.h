// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rig/import/gltf_source.h"
#include "tools/export/gltf/glb.h"

namespace thew::tools {

// Changes to a glTF document that was read, with all that does not change left at its place.

/// The document of a file. What is wrong in it throws nlohmann's exceptions, here and below.
Glb open_document(const GltfSource& source);

/// Gives each node of these a mesh of its own, where it shares one with others.
void separate_meshes(Glb& glb, const std::vector<int>& nodes);

/// Takes skin, weights and tangents from the mesh of a node, and the morph targets that it had:
/// all of these are of its bind pose.
void make_static(Glb& glb, int node);
/// Removes skins that no node names.
void remove_unused_skins(Glb& glb);
/// Removes the channels of animations that set the weights of these nodes' morph targets.
void remove_weight_channels(Glb& glb, const std::vector<int>& nodes);

/// Removes accessors and views to which nothing points any more, and their bytes.
void drop_unused(Glb& glb);

/// The morph targets that a mesh has in the file.
std::size_t count_targets(const nlohmann::ordered_json& mesh);

/// A member that is an object or a list, made where it is missing.
nlohmann::ordered_json& object_at(nlohmann::ordered_json& parent, const char* key);
nlohmann::ordered_json& list_at(nlohmann::ordered_json& parent, const char* key);

}  // namespace thew::tools
