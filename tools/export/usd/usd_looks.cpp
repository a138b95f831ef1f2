// SPDX-License-Identifier: Apache-2.0
//
// The materials of a character's file as USD's preview surfaces: base colour and its image, metal,
// roughness, emission, alpha. Other images are not carried over.
#include "tools/export/usd/usd_scene.h"

namespace thew::tools {
namespace {

constexpr const char* kLooks = "/Bake/Looks/";

// By material; names in USD are no free text.
std::vector<std::string> look_names(const SkinLooks& looks) {
  std::vector<std::string> names;
  std::set<std::string> taken;
  for (const SkinMaterial& material : looks.materials) {
    names.push_back(prim_name(material.name, taken));
  }
  return names;
}

template <std::size_t n>
UsdData numbers(const std::array<float, n>& values) {
  return std::vector<float>(values.begin(), values.end());
}

UsdData number(float value) { return std::vector<float>{value}; }

UsdAttribute shader_id(const std::string& id) {
  return {.name = "info:id", .type = UsdType::kToken, .value = id, .uniform = true};
}

UsdAttribute connected(const std::string& name, UsdType type, const std::string& to) {
  UsdAttribute attribute{name, type};
  attribute.target = to;
  return attribute;
}

// The reader of texture coordinates, and the image that they lead into.
void add_texture(const SkinMaterial& material, const std::string& file, const std::string& path,
                 UsdPrim& prim) {
  UsdPrim reader{"Coordinates", "Shader"};
  reader.attributes = {shader_id("UsdPrimvarReader_float2"),
                       {"inputs:varname", UsdType::kString, "st"},
                       {"outputs:result", UsdType::kFloat2}};
  UsdPrim texture{"Texture", "Shader"};
  texture.attributes = {
      shader_id("UsdUVTexture"),
      {"inputs:file", UsdType::kAsset, file},
      {"inputs:scale", UsdType::kFloat4, numbers(material.colour)},
      {"inputs:sourceColorSpace", UsdType::kToken, "sRGB"},
      connected("inputs:st", UsdType::kFloat2, path + "/Coordinates.outputs:result"),
      {"inputs:wrapS", UsdType::kToken, "repeat"},
      {"inputs:wrapT", UsdType::kToken, "repeat"},
      {"outputs:a", UsdType::kFloat},
      {"outputs:rgb", UsdType::kFloat3}};
  prim.children.push_back(std::move(texture));
  prim.children.push_back(std::move(reader));
}

UsdPrim describe_look(const SkinLooks& looks, const SkinMaterial& material, const std::string& name,
                      const std::string& images) {
  const std::string path = kLooks + name;
  const auto& [red, green, blue, alpha] = material.colour;
  UsdPrim prim{name, "Material"};
  prim.full_name = material.name;
  prim.attributes = {
      connected("outputs:surface", UsdType::kToken, path + "/Surface.outputs:surface")};
  UsdPrim surface{"Surface", "Shader"};
  const auto add = [&](UsdAttribute attribute) {
    surface.attributes.push_back(std::move(attribute));
  };
  add(shader_id("UsdPreviewSurface"));
  if (material.image < 0) {
    add({"inputs:diffuseColor", UsdType::kColour, numbers(std::array{red, green, blue})});
  } else {
    add(connected("inputs:diffuseColor", UsdType::kColour, path + "/Texture.outputs:rgb"));
  }
  add({"inputs:emissiveColor", UsdType::kColour, numbers(material.emission)});
  add({"inputs:metallic", UsdType::kFloat, number(material.metallic)});
  if (material.see_through && material.image >= 0) {
    add(connected("inputs:opacity", UsdType::kFloat, path + "/Texture.outputs:a"));
  } else {
    add({"inputs:opacity", UsdType::kFloat, number(material.see_through ? alpha : 1.0f)});
  }
  add({"inputs:opacityThreshold", UsdType::kFloat, number(material.cut)});
  add({"inputs:roughness", UsdType::kFloat, number(material.roughness)});
  add({"outputs:surface", UsdType::kToken});
  prim.children.push_back(std::move(surface));
  if (material.image >= 0) {
    const auto image = static_cast<std::size_t>(material.image);
    add_texture(material, images + looks.images[image].name, path, prim);
  }
  return prim;
}

}  // namespace

UsdPrim describe_looks(const SkinLooks& looks, const std::string& images) {
  UsdPrim scope{"Looks", "Scope"};
  const std::vector<std::string> names = look_names(looks);
  for (std::size_t i = 0; i < names.size(); ++i) {
    scope.children.push_back(describe_look(looks, looks.materials[i], names[i], images));
  }
  return scope;
}

void bind_look(const SkinLooks& looks, int look, UsdPrim& prim) {
  if (look < 0) return;
  UsdAttribute binding{"material:binding", UsdType::kToken};
  binding.target = kLooks + look_names(looks)[static_cast<std::size_t>(look)];
  binding.relationship = true;
  prim.attributes.push_back(std::move(binding));
  prim.bound = true;
}

}  // namespace thew::tools
