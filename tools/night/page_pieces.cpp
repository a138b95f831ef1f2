// SPDX-License-Identifier: Apache-2.0
#include "tools/night/page_pieces.h"

#include <cctype>
#include <cmath>
#include <cstring>

#include "tools/base/text.h"

namespace thew::tools {
namespace {

// As a path in an address.
std::string address(const std::string& path) {
  static constexpr char kHex[] = "0123456789ABCDEF";
  std::string text;
  for (const char c : path) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) || std::strchr("/-_.~", c)) {
      text += c;
    } else {
      text += {'%', kHex[byte >> 4], kHex[byte & 15]};
    }
  }
  return text;
}

}  // namespace

Cell text_cell(std::string html, const char* look) { return {std::move(html), 0.0, true, look}; }
Cell number_cell(double value, std::string html, const char* look) {
  return {std::move(html), value, false, look};
}

Cell count_cell(std::size_t count, const char* look) {
  return number_cell(static_cast<double>(count), std::to_string(count), look);
}

Cell no_cell() { return number_cell(std::nan(""), "–", "soft"); }

std::string html_row(const std::vector<Cell>& cells, const std::string& attributes) {
  std::string html = "<tr" + attributes + ">";
  for (const Cell& cell : cells) {
    html += "<td";
    const std::string look = std::string(cell.is_text ? "text " : "") + cell.look;
    if (!look.empty()) html += " class=\"" + look + "\"";
    if (!cell.is_text) {
      html += " data-v=\"" + (std::isnan(cell.value) ? "" : readable(cell.value, 9)) + "\"";
    }
    html += ">" + cell.html + "</td>";
  }
  return html + "</tr>\n";
}

std::string html_table(const std::vector<Head>& heads, const std::string& rows,
                       const std::string& attributes) {
  std::string html = "<div class=\"wide\"><table class=\"sortable\"" + attributes + "><thead><tr>";
  for (const Head& head : heads) {
    html += (head.is_text ? "<th class=\"text\">" : "<th>") + head.html + "</th>";
  }
  return html + "</tr></thead><tbody>\n" + rows + "</tbody></table></div>\n";
}

std::string html_fold(bool open, const std::string& summary, const std::string& inside) {
  return std::string("<details") + (open ? " open" : "") + "><summary>" + summary + "</summary>\n" +
         inside + "</details>\n";
}

std::string html_badge(ShotState state) {
  const char* look = state == ShotState::kDone     ? "good"
                     : state == ShotState::kMissed ? "warn"
                                                   : "bad";
  return std::string("<span class=\"badge ") + look + "\">" + state_text(state) + "</span>";
}

std::string duration_text(double seconds) {
  if (seconds < 100.0) return readable(seconds) + " s";
  if (seconds < 6000.0) return readable(seconds / 60.0) + " min";
  return readable(seconds / 3600.0) + " h";
}

std::string Page::link(const NightShot& shot) const {
  std::string name = escape_html(shot.name);
  if (!shot.has_report()) return name;
  const std::filesystem::path report = (shot.folder / "report.html").lexically_relative(folder);
  return "<a href=\"" + address(report.string()) + "\">" + name + "</a>";
}

}  // namespace thew::tools
