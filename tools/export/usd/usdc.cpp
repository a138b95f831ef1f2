// SPDX-License-Identifier: Apache-2.0
#include <map>

#include "tools/export/usd/crate.h"
#include "tools/export/usd/usd.h"

namespace thew::tools {
namespace {

template <typename T>
std::string_view memory_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), sizeof(T) * values.size()};
}

Crate::Rep keep(Crate& crate, UsdType of, const UsdData& data) {
  const UsdTypeFacts& type = facts_of(of);
  if (const auto* text = std::get_if<std::string>(&data)) {
    if (of == UsdType::kString) return crate.string(*text);
    return of == UsdType::kAsset ? crate.asset(*text) : crate.token(*text);
  }
  if (const auto* number = std::get_if<double>(&data)) return crate.number(*number);
  if (const auto* floats = std::get_if<std::vector<float>>(&data); floats && !type.array) {
    if (of == UsdType::kFloat) return crate.number(floats->front());
    return crate.value(type.crate, memory_of(*floats));
  }
  if (const auto* floats = std::get_if<std::vector<float>>(&data)) {
    return crate.array(type.crate, floats->size() / type.width, memory_of(*floats));
  }
  if (const auto* ints = std::get_if<std::vector<std::int32_t>>(&data)) {
    return crate.array(type.crate, ints->size(), memory_of(*ints));
  }
  if (const auto* matrix = std::get_if<Eigen::Matrix4d>(&data)) {
    // By columns in memory: USD's vectors are rows, and so its matrices are ours transposed.
    return crate.value(type.crate, {reinterpret_cast<const char*>(matrix->data()), 16 * 8});
  }
  return crate.token_array(std::get<std::vector<std::string>>(data));
}

/// By path, the number that each prim and attribute will have: in the order in which they are
/// added.
using Numbers = std::map<std::string, int>;

void number_prims(const UsdPrim& prim, const std::string& above, Numbers& numbers) {
  const auto add = [&](const std::string& path) {
    numbers.emplace(path, static_cast<int>(numbers.size()) + 1);  // 0 is the root
  };
  const std::string path = above + "/" + prim.name;
  add(path);
  for (const UsdAttribute& attribute : prim.attributes) add(path + "." + attribute.name);
  for (const UsdPrim& child : prim.children) number_prims(child, path, numbers);
}

void add_attribute(Crate& crate, int prim, const UsdAttribute& attribute, const Numbers& numbers) {
  if (attribute.relationship) {
    crate.add(prim, attribute.name, Crate::Spec::kRelationship,
              {{"variability", Crate::inlined(Crate::kVariability, 1)},
               {"targetPaths", crate.paths({numbers.at(attribute.target)})}});
    return;
  }
  Crate::Fields fields = {{"typeName", crate.token(facts_of(attribute.type).name)}};
  if (attribute.custom) fields.emplace_back("custom", Crate::inlined(Crate::kBool, 1));
  if (attribute.uniform) {
    fields.emplace_back("variability", Crate::inlined(Crate::kVariability, 1));
  }
  if (!attribute.interpolation.empty()) {
    fields.emplace_back("interpolation", crate.token(attribute.interpolation));
  }
  if (attribute.has_value()) fields.emplace_back("default", attribute.kept);
  if (!attribute.target.empty()) {
    fields.emplace_back("connectionPaths", crate.paths({numbers.at(attribute.target)}));
  }
  if (!attribute.samples.empty()) {
    std::vector<double> times;
    std::vector<Crate::Rep> values;
    for (const UsdSample& sample : attribute.samples) {
      times.push_back(sample.frame);
      values.push_back(sample.value);
    }
    fields.emplace_back("timeSamples", crate.samples(times, values));
  }
  crate.add(prim, attribute.name, Crate::Spec::kAttribute, fields);
}

void add_prim(Crate& crate, int parent, const UsdPrim& prim, const Numbers& numbers) {
  Crate::Fields fields = {{"specifier", Crate::inlined(Crate::kSpecifier, 0)},  // def
                          {"typeName", crate.token(prim.type)}};
  if (!prim.kind.empty()) fields.emplace_back("kind", crate.token(prim.kind));
  if (!prim.full_name.empty()) {
    fields.emplace_back("customData", crate.strings({{"name", prim.full_name}}));
  }
  if (prim.bound) fields.emplace_back("apiSchemas", crate.prepended({"MaterialBindingAPI"}));
  std::vector<std::string> attributes, children;
  for (const UsdAttribute& attribute : prim.attributes) attributes.push_back(attribute.name);
  for (const UsdPrim& child : prim.children) children.push_back(child.name);
  if (!attributes.empty()) fields.emplace_back("properties", crate.tokens(attributes));
  if (!children.empty()) fields.emplace_back("primChildren", crate.tokens(children));
  const int number = crate.add(parent, prim.name, Crate::Spec::kPrim, fields);
  for (const UsdAttribute& attribute : prim.attributes) {
    add_attribute(crate, number, attribute, numbers);
  }
  for (const UsdPrim& child : prim.children) add_prim(crate, number, child, numbers);
}

}  // namespace

void write_usdc(const Shot& shot, UsdLayer& layer, ExportFile& out) {
  Crate crate(out);
  keep_values(shot, layer.root, [&](const UsdAttribute& attribute, const UsdData& data) {
    return keep(crate, attribute.type, data);
  });
  const int root = crate.add(-1, "", Crate::Spec::kRoot,
                             {{"customLayerData", crate.strings(layer.custom)},
                              {"defaultPrim", crate.token(layer.root.name)},
                              {"endTimeCode", crate.number(layer.last_frame)},
                              {"framesPerSecond", crate.number(layer.fps)},
                              {"metersPerUnit", crate.number(1.0)},
                              {"primChildren", crate.tokens({layer.root.name})},
                              {"startTimeCode", crate.number(layer.first_frame)},
                              {"timeCodesPerSecond", crate.number(layer.fps)},
                              {"upAxis", crate.token("Y")}});
  Numbers numbers;
  number_prims(layer.root, "", numbers);
  add_prim(crate, root, layer.root, numbers);
  crate.finish();
}

}  // namespace thew::tools
