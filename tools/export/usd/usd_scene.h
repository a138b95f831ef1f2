// SPDX-License-Identifier: Apache-2.0
//
// A bake as USD has it: what both files of it hold, as text (usda.cpp) and as a crate (usdc.cpp).
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "tools/export/shot.h"

namespace thew::tools {

/// The types that a bake needs, a row of kUsdTypes each.
enum class UsdType {
  kInts,
  kFloats,
  kDouble,
  kFloat,
  kFloat2,
  kFloat3,
  kFloat4,
  kColour,
  kString,
  kAsset,
  kToken,
  kTokens,
  kFloat3s,
  kPoints,
  kNormals,
  kColours,
  kUvs,
  kVectors,
  kFloat2s,
  kMatrix
};

/// The text of a token, a string or a place; tokens; whole numbers; numbers one after another,
/// `width` of them a value.
using UsdData = std::variant<std::string, std::vector<std::string>, std::vector<std::int32_t>,
                             double, std::vector<float>, Eigen::Matrix4d>;

struct UsdTypeFacts {
  const char* name;
  std::size_t width;  ///< numbers in a value
  bool array;
  std::uint8_t crate;  ///< its number in a crate
};
const UsdTypeFacts& facts_of(UsdType type);

/// At which frame it has which value, by the number under which its writer keeps it.
struct UsdSample {
  int frame = 0;
  std::uint64_t value = 0;
};

struct UsdAttribute {
  std::string name;
  UsdType type;
  std::optional<UsdData> value = {};                                ///< without it the first one
  std::function<UsdData(std::size_t i, const ShotFrame&)> at = {};  ///< by frame; empty: constant
  std::string interpolation = {};                                   ///< of a primvar; else ""
  bool uniform = false;  ///< by schema not to change in time
  bool custom = false;   ///< of no schema
  /// Of directions, radians: a frame that the line between two samples says as closely as this has
  /// no sample. 0: every frame that differs has one.
  double between = 0;
  /// The path of an attribute that this one is connected to, or of a prim that this names, as no
  /// attribute but a relationship. Then there is no value.
  std::string target = {};
  bool relationship = false;
  bool has_value() const { return value || at; }
  /// As keep_values() has kept them.
  std::uint64_t kept = 0;
  std::vector<UsdSample> samples = {};
};

struct UsdPrim {
  std::string name, type;
  std::string kind = {};       ///< of a model, or ""
  std::string full_name = {};  ///< in the bake, where it may be no name in USD
  bool bound = false;          ///< to a material, by a schema that it has to name
  std::vector<UsdAttribute> attributes = {};
  std::vector<UsdPrim> children = {};
};

/// Facts of the layer, by USD's names; what is not its own goes into its customLayerData.
struct UsdLayer {
  double fps, first_frame, last_frame;
  Facts custom;
  UsdPrim root;
};

/// `images`: what stands before the names of images in their places.
UsdLayer describe_usd(const Shot& shot, const std::string& images);
/// The scope of the skin's materials, at /Bake/Looks; without any a prim without a name.
UsdPrim describe_looks(const SkinLooks& looks, const std::string& images);
/// Names a material of those for a mesh, or for a part of one.
void bind_look(const SkinLooks& looks, int look, UsdPrim& prim);
/// A prim's name is an identifier, and no two prims of a scope have the same.
std::string prim_name(const std::string& name, std::set<std::string>& taken);

/// Reads all frames and hands each value of each attribute to `keep`, which gives the same number
/// for the same value. A sample between two of the same value is left out, and one that the line
/// between two others says well enough (`between`); where all are the same there are none, and the
/// value is the default.
void keep_values(const Shot& shot, UsdPrim& root,
                 const std::function<std::uint64_t(const UsdAttribute&, const UsdData&)>& keep);

}  // namespace thew::tools
