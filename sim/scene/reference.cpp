// SPDX-License-Identifier: Apache-2.0
#include "sim/scene/reference.h"

#include <cmath>

#include "rig/text.h"
#include "sim/scene/muscle_keys.h"
#include "sim/scene/rig_keys.h"
#include "sim/scene/scene_keys.h"

namespace thew::sim {
namespace {

constexpr Section kSections[] = {kFile,    kScene,   kRig,      kClip,     kHinge,     kForearm,
                                 kScapula, kBone,    kCollider, kMuscle,   kProfile,   kActivation,
                                 kLoad,    kWeights, kZone,     kMaterial, kTransform, kPathPoint,
                                 kWrap,    kFixed,   kSkin,     kSolver,   kTolerance, kContact,
                                 kRender,  kView,    kOutput,   kBound};

// A test reads the scene in it.
constexpr const char* kPreamble =
    R"(<!-- Written by `thew inspect --keys`. Change the declarations of the keys instead. -->
# Keys of a scene

A scene is a [TOML](https://toml.io) file. Units are SI: metres, kilograms, seconds, newtons, and
angles in degrees where a key says so. Files are named relative to the scene and lie in its folder
or below. A key that Thew does not know is refused, with the line that it stands on.

`thew bake SCENE --set KEY=VALUE` changes any key for one bake. Tables of a list are named by their
`name`, or by their index from 0: `muscle.flexor.weights=left`, `muscle.flexor.path.1.3=0.02`.

The smallest useful scene is one muscle over an elbow. It is a tube, so that it needs no mesh:

```toml
[scene]
name = "flexor"
frames = "1-24"

[rig]
file = "rig.urdf"             # bodies "humerus" and "ulna", joint "elbow"

[rig.clip]
unit = "deg"
keys = { elbow = [[1, 0], [24, 60]] }             # [frame, angle]

[[muscle]]
name = "flexor"
path = [["humerus", 0.03, -0.03, 0], ["ulna", 0.03, -0.05, 0]]
belly = [0.06, 0.24]
profile = { radius = [[0, 0.004], [0.5, 0.018], [1, 0.004]] }

[[render.view]]
name = "muscles"
eye = [0, -0.3, 1.5]
target = [0, -0.3, 0]
```

Below, every table that a scene may have and every key in it. "required" says that the table has to
have the key, "see meaning" that it has to in some cases. `× size` means that the default is
multiplied by `size` of `[scene]`. A range holds for each number of a value; where a second follows
after "then", it is that of the last number of each pair or plane.
)";

std::string type_text(const Key& key) {
  switch (key.type) {
    case KeyType::kNumber:
      return "number";
    case KeyType::kInteger:
      return "whole number";
    case KeyType::kLength:
      return "number or text with unit";
    case KeyType::kTruth:
      return "true or false";
    case KeyType::kText:
      return "text";
    case KeyType::kName:
      return "text of letters, digits, _ and -";
    case KeyType::kWord:
      return "word";
    case KeyType::kFile:
      return "path of a file";
    case KeyType::kVector:
      return *key.form ? key.form : "[x, y, z]";
    case KeyType::kDirection:
      return "direction, [x, y, z]";
    case KeyType::kPairs:
      return std::string("pairs, [") + key.form + ", ...]";
    case KeyType::kForm:
      return key.form;
    case KeyType::kTable:
      return "table";
    default:
      return "tables";
  }
}

std::string standard_text(const Key& key) {
  if (key.need == Need::kRequired) return "required";
  if (key.need == Need::kConditional) return "see meaning";
  if (key.standard) return key.standard();
  return key.type == KeyType::kWord ? toml_text(std::string(key.words[0])) : "none";
}

std::string bounds_text(const Range& range) {
  const auto text = [](double x) {
    const bool whole = x == std::floor(x) && std::abs(x) <= kLastFrame;
    return whole ? toml_text(static_cast<int>(x)) : toml_text(x);
  };
  return text(range.least) + " to " + text(range.most);
}

std::string range_text(const Key& key) {
  std::string text;
  for (const char* word : key.words) {
    if (word) text += (text.empty() ? "" : ", ") + toml_text(std::string(word));
  }
  if (key.range.most > key.range.least) text = bounds_text(key.range);
  if (key.second.most > key.second.least) text += ", then " + bounds_text(key.second);
  return text;
}

// In a cell of a table of Markdown.
std::string cell(std::string text, bool code = false) {
  for (std::size_t at = text.find('|'); at != text.npos; at = text.find('|', at + 2)) {
    text.insert(at, "\\");
  }
  return text.empty() ? " " : code ? " `" + text + "` " : " " + text + " ";
}

}  // namespace

std::string toml_text(double value) { return number_text(value); }
std::string toml_text(int value) { return std::to_string(value); }
std::string toml_text(bool value) { return value ? "true" : "false"; }
std::string toml_text(const std::string& value) { return "\"" + value + "\""; }
std::string toml_text(const Vec3& value) {
  return "[" + toml_text(value.x()) + ", " + toml_text(value.y()) + ", " + toml_text(value.z()) +
         "]";
}
std::string sized_text(double value) { return toml_text(value) + " × size"; }

std::span<const Section> scene_sections() { return kSections; }

std::vector<KeyEntry> scene_keys() {
  std::vector<KeyEntry> entries;
  for (const Section& section : kSections) {
    for (const Key& key : section.keys) {
      const std::string old =
          *key.old ? " Its old name `" + std::string(key.old) + "` is read with a warning." : "";
      entries.push_back({section.title, key.name, type_text(key), key.unit, standard_text(key),
                         range_text(key), key.meaning + old});
    }
  }
  return entries;
}

std::string scene_reference() {
  std::string page = kPreamble, title;
  const std::vector<KeyEntry> entries = scene_keys();
  auto entry = entries.begin();
  for (const Section& section : kSections) {
    const bool is_toml = section.title[0] == '[';
    page += std::string("\n## ") + (is_toml ? "`" : "") + section.title + (is_toml ? "`" : "") +
            "\n\n" + section.about + "\n\n" +
            "| key | type | unit | default | range | meaning |\n"
            "| --- | --- | --- | --- | --- | --- |\n";
    for (std::size_t k = 0; k < section.keys.size(); ++k, ++entry) {
      const bool is_value = section.keys[k].need == Need::kOptional && entry->standard != "none";
      page += "|" + cell(entry->key, true) + "|" + cell(entry->type) + "|" + cell(entry->unit) +
              "|" + cell(entry->standard, is_value) + "|" + cell(entry->range) + "|" +
              cell(entry->meaning) + "|\n";
    }
  }
  return page;
}

}  // namespace thew::sim
