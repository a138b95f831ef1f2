// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/night/night.h"

namespace thew::tools {

// What the page of a night is put together from: HTML, with texts escaped already.

inline constexpr std::size_t kOpen = 12;  // of a list; one that is longer is folded up

struct Cell {
  std::string html;
  double value = 0.0;  ///< that it is sorted by, unless is_text
  bool is_text = false;
  const char* look = "";  ///< a class
};
Cell text_cell(std::string html, const char* look = "");
Cell number_cell(double value, std::string html, const char* look = "");
/// A whole number.
Cell count_cell(std::size_t count, const char* look = "");
/// There is nothing to say.
Cell no_cell();

struct Head {
  std::string html;
  bool is_text = false;  ///< of its column
};

std::string html_row(const std::vector<Cell>& cells, const std::string& attributes = "");
/// A table that night.js sorts by the column whose head is pressed.
std::string html_table(const std::vector<Head>& heads, const std::string& rows,
                       const std::string& attributes = "");
/// What a reader opens to see.
std::string html_fold(bool open, const std::string& summary, const std::string& inside);
std::string html_badge(ShotState state);
/// "12 s", "3.4 min", "1.2 h"
std::string duration_text(double seconds);

/// A night, and where its page lies.
struct Page {
  const Night& night;
  std::filesystem::path folder;         ///< of the page, absolute
  std::vector<std::string> quantities;  ///< quantities_of(night)

  /// The name of a bake, with a link to its report where there is one.
  std::string link(const NightShot& shot) const;
};

// Tables of the page (page_tables.cpp), each with its heading; "" where there is nothing to say.
std::string bounds_part(const Page& page);
std::string rungs_part(const Page& page);
std::string swings_part(const Page& page);
std::string cost_part(const Page& page);
std::string shots_part(const Page& page);
std::string warnings_part(const Page& page);

}  // namespace thew::tools
