// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <vector>

#include "sim/scene/keys.h"

namespace thew::sim {

/// All tables that a scene may have, in the order of the reference.
std::span<const Section> scene_sections();

/// A key as the reference shows it.
struct KeyEntry {
  std::string section;  ///< "[[muscle]]"
  std::string key, type, unit, standard, range, meaning;
};
std::vector<KeyEntry> scene_keys();

/// The reference as Markdown, one table a section: sim/scene/reference.md.
std::string scene_reference();

}  // namespace thew::sim
