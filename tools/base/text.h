// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace thew::tools {

/// A number as people read it, whatever the locale: `digits` significant ones.
std::string readable(double value, int digits = 3);
/// Text inside HTML, SVG or XML.
std::string escape_html(const std::string& text);
/// "max_depth" as "max depth"
std::string in_words(std::string name);
/// "17-19, 25", with `to` between the ends of a range.
std::string frame_list(const std::vector<int>& frames, const std::string& to = "-");

}  // namespace thew::tools
