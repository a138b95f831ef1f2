// SPDX-License-Identifier: Apache-2.0
//
// In which unit a character is.
#include "tools/fit/scale.h"

#include <algorithm>
#include <cstdio>

#include "rig/import/character_import.h"
#include "rig/limits.h"
#include "rig/text.h"

namespace thew::tools {
namespace {

// A person's, child or giant, from the shoulder's centre to the elbow's; what lies outside is
// another unit, and is made an adult's. m.
constexpr double kShortestHumerus = 0.2, kLongestHumerus = 0.45, kAdultsHumerus = 0.32;

// As text that is short to read and to write into a scene.
std::string three_digits(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

// m, the longer of the two.
double humerus_of(const Character& character, const std::vector<ArmBodies>& arms) {
  const auto place = [&](int body) { return position_of(character, body); };
  double length = 0.0;
  for (const ArmBodies& arm : arms) {
    length = std::max(length, (place(arm.forearm) - place(arm.humerus)).norm());
  }
  return length;
}

}  // namespace

Character read_in_metres(const NewOptions& options, double& scale, std::vector<ArmBodies>& arms,
                         std::vector<std::string>& notes, std::vector<std::string>& warnings) {
  const auto read = [&] {
    notes.clear();
    Character character = import_character(options.character, scale);
    arms = find_arms(character, options.side, options.map, options.character.string(), notes);
    warnings = character.warnings;
    return character;
  };
  scale = options.scale.value_or(1.0);
  Character character = read();
  const double length = humerus_of(character, arms);
  const bool human = length >= kShortestHumerus && length <= kLongestHumerus;
  if (human || !(length > 0.0)) return character;
  if (options.scale) {
    warnings.push_back("a humerus of " + three_digits(length) +
                       " m, that of a person is 0.2 to 0.45; left as --scale has it");
    return character;
  }
  const double wanted = std::clamp(kAdultsHumerus / length, kMinScale, kMaxScale);
  scale = parse_number(three_digits(wanted)).value_or(wanted);
  character = read();
  notes.push_back("scaled by " + three_digits(scale) + ": its humerus is " + three_digits(length) +
                  " m long, and becomes an adult's (--scale 1 leaves it)");
  return character;
}

}  // namespace thew::tools
