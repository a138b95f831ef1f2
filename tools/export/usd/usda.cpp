// SPDX-License-Identifier: Apache-2.0
//
// Each default stands before its samples: TinyUSDZ forgets samples that come first.
#include <unordered_map>

#include "sim/cache/hash.h"
#include "tools/base/output_file.h"
#include "tools/export/usd/usd.h"
#include "tools/export/usd/usd_scene.h"

namespace thew::tools {
namespace {

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : one_line(text)) {
    if (c == '"' || c == '\\') result += '\\';
    result += c;
  }
  return result + "\"";
}

// "1", or "(1, 2, 3)" where a value has more numbers.
template <typename T>
std::string tuples(const std::vector<T>& numbers, std::size_t width) {
  std::string text;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (i > 0) text += ", ";
    if (width > 1 && i % width == 0) text += "(";
    if constexpr (std::is_same_v<T, float>) {
      text += digits(numbers[i]);
    } else {
      text += std::to_string(numbers[i]);
    }
    if (width > 1 && i % width == width - 1) text += ")";
  }
  return text;
}

std::string matrix_text(const Eigen::Matrix4d& matrix) {
  std::string text = "(";
  for (int column = 0; column < 4; ++column) {  // USD's vectors are rows
    text += column == 0 ? " (" : ", (";
    for (int row = 0; row < 4; ++row) text += (row ? ", " : "") + digits(matrix(row, column));
    text += ")";
  }
  return text + " )";
}

std::string text_of(UsdType type, const UsdData& data) {
  const UsdTypeFacts& facts = facts_of(type);
  if (const auto* text = std::get_if<std::string>(&data)) {
    return type == UsdType::kAsset ? "@" + *text + "@" : quoted(*text);
  }
  if (const auto* number = std::get_if<double>(&data)) return digits(*number);
  if (const auto* matrix = std::get_if<Eigen::Matrix4d>(&data)) return matrix_text(*matrix);
  if (const auto* floats = std::get_if<std::vector<float>>(&data)) {
    const std::string text = tuples(*floats, facts.width);
    return facts.array ? "[" + text + "]" : text;
  }
  if (const auto* ints = std::get_if<std::vector<std::int32_t>>(&data)) {
    return "[" + tuples(*ints, 1) + "]";
  }
  std::string text;
  for (const std::string& token : std::get<std::vector<std::string>>(data)) {
    text += (text.empty() ? "" : ", ") + quoted(token);
  }
  return "[" + text + "]";
}

/// Each value once. A float takes its four bytes, and becomes text when it is written.
struct Values {
  std::vector<std::pair<UsdType, UsdData>> values;
  std::unordered_map<std::string, std::uint64_t> numbers;

  std::uint64_t keep(UsdType type, const UsdData& data) {
    std::string bytes;
    if (const auto* floats = std::get_if<std::vector<float>>(&data)) {
      bytes.assign(reinterpret_cast<const char*>(floats->data()), 4 * floats->size());
    } else {
      bytes = text_of(type, data);
    }
    const std::string key = static_cast<char>(type) + sim::hash_of(bytes);
    const auto [found, added] = numbers.try_emplace(key, values.size());
    if (added) values.emplace_back(type, data);
    return found->second;
  }
  std::string text(std::uint64_t number) const {
    return text_of(values[number].first, values[number].second);
  }
};

void write_attribute(ExportFile& out, const UsdAttribute& attribute, const Values& values,
                     const std::string& indent) {
  const std::string declared = std::string(attribute.custom ? "custom " : "") +
                               (attribute.uniform ? "uniform " : "") +
                               facts_of(attribute.type).name + " " + attribute.name;
  if (!attribute.target.empty()) {
    out.append(indent + (attribute.relationship ? "rel " + attribute.name : declared + ".connect") +
               " = <" + attribute.target + ">\n");
    return;
  }
  out.append(indent + declared);
  if (!attribute.has_value()) {
    out.append("\n");
    return;
  }
  out.append(" = " + values.text(attribute.kept));
  if (!attribute.interpolation.empty()) {
    out.append(" (\n" + indent + "    interpolation = " + quoted(attribute.interpolation) + "\n" +
               indent + ")");
  }
  out.append("\n");
  if (attribute.samples.empty()) return;
  out.append(indent + declared + ".timeSamples = {\n");
  for (const UsdSample& sample : attribute.samples) {
    out.append(indent + "    " + std::to_string(sample.frame) + ": " + values.text(sample.value) +
               ",\n");
  }
  out.append(indent + "}\n");
}

void write_prim(ExportFile& out, const UsdPrim& prim, const Values& values,
                const std::string& indent) {
  out.append(indent + "def " + prim.type + " \"" + prim.name + "\"");
  if (!prim.kind.empty() || !prim.full_name.empty() || prim.bound) {
    out.append(" (\n");
    if (prim.bound) out.append(indent + "    prepend apiSchemas = [\"MaterialBindingAPI\"]\n");
    if (!prim.full_name.empty()) {
      out.append(indent + "    customData = {\n" + indent +
                 "        string name = " + quoted(prim.full_name) + "\n" + indent + "    }\n");
    }
    if (!prim.kind.empty()) out.append(indent + "    kind = " + quoted(prim.kind) + "\n");
    out.append(indent + ")");
  }
  out.append("\n" + indent + "{\n");
  for (const UsdAttribute& attribute : prim.attributes) {
    write_attribute(out, attribute, values, indent + "    ");
  }
  for (const UsdPrim& child : prim.children) {
    out.append("\n");
    write_prim(out, child, values, indent + "    ");
  }
  out.append(indent + "}\n");
}

std::string header(const UsdLayer& layer) {
  std::string text = "#usda 1.0\n(\n    customLayerData = {\n";
  for (const auto& [name, value] : layer.custom) {
    text += "        string " + name + " = " + quoted(value) + "\n";
  }
  const std::string fps = digits(layer.fps);
  return text + "    }\n    defaultPrim = " + quoted(layer.root.name) +
         "\n    endTimeCode = " + digits(layer.last_frame) + "\n    framesPerSecond = " + fps +
         "\n    metersPerUnit = 1\n    startTimeCode = " + digits(layer.first_frame) +
         "\n    timeCodesPerSecond = " + fps + "\n    upAxis = \"Y\"\n)\n\n";
}

}  // namespace

void write_usda(const Shot& shot, UsdLayer& layer, ExportFile& out) {
  Values values;
  keep_values(shot, layer.root, [&](const UsdAttribute& attribute, const UsdData& data) {
    return values.keep(attribute.type, data);
  });
  out.append(header(layer));
  write_prim(out, layer.root, values, "");
}

}  // namespace thew::tools
