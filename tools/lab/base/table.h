// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace thew::tools {

/// A table as it is read.
struct Table {
  std::string file, title, note;  ///< its name as CSV, if any; the note stands below it
  std::vector<std::string> head;
  std::vector<std::vector<std::string>> rows;
};

/// A number as people read it: `digits` significant ones.
std::string number(double value, int digits = 3);

std::string csv_of(const Table& table);
std::string markdown_of(const Table& table);
/// For html_page().
std::string html_of(const Table& table);

/// One file without network: its title as its heading, then the body. `style`: more CSS.
std::string html_page(const std::string& title, const std::string& style, const std::string& body);

}  // namespace thew::tools
