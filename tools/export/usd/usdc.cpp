// SPDX-License-Identifier: Apache-2.0
#include "tools/export/usd/crate.h"
#include "tools/export/usd/usd.h"

namespace thew::tools {
namespace {

template <typename T>
std::string_view memory_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), sizeof(T) * values.size()};
}

Crate::Rep keep(Crate& crate, const UsdTypeFacts& type, const UsdData& data) {
  if (const auto* token = std::get_if<std::string>(&data)) return crate.token(*token);
  if (const auto* number = std::get_if<double>(&data)) return crate.number(*number);
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

void add_attribute(Crate& crate, int prim, const UsdAttribute& attribute) {
  Crate::Fields fields = {{"typeName", crate.token(facts_of(attribute.type).name)}};
  if (attribute.custom) fields.emplace_back("custom", Crate::inlined(Crate::kBool, 1));
  if (attribute.uniform) {
    fields.emplace_back("variability", Crate::inlined(Crate::kVariability, 1));
  }
  if (!attribute.interpolation.empty()) {
    fields.emplace_back("interpolation", crate.token(attribute.interpolation));
  }
  fields.emplace_back("default", attribute.kept);
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

void add_prim(Crate& crate, int parent, const UsdPrim& prim) {
  Crate::Fields fields = {{"specifier", Crate::inlined(Crate::kSpecifier, 0)},  // def
                          {"typeName", crate.token(prim.type)}};
  if (!prim.kind.empty()) fields.emplace_back("kind", crate.token(prim.kind));
  if (!prim.full_name.empty()) {
    fields.emplace_back("customData", crate.strings({{"name", prim.full_name}}));
  }
  std::vector<std::string> attributes, children;
  for (const UsdAttribute& attribute : prim.attributes) attributes.push_back(attribute.name);
  for (const UsdPrim& child : prim.children) children.push_back(child.name);
  if (!attributes.empty()) fields.emplace_back("properties", crate.tokens(attributes));
  if (!children.empty()) fields.emplace_back("primChildren", crate.tokens(children));
  const int number = crate.add(parent, prim.name, Crate::Spec::kPrim, fields);
  for (const UsdAttribute& attribute : prim.attributes) add_attribute(crate, number, attribute);
  for (const UsdPrim& child : prim.children) add_prim(crate, number, child);
}

}  // namespace

void write_usdc(const Shot& shot, UsdLayer& layer, ExportFile& out) {
  Crate crate(out);
  keep_values(shot, layer.root, [&](const UsdAttribute& attribute, const UsdData& data) {
    return keep(crate, facts_of(attribute.type), data);
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
  add_prim(crate, root, layer.root);
  crate.finish();
}

}  // namespace thew::tools
