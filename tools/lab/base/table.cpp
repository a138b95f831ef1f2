// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/base/table.h"

#include "rig/text.h"
#include "tools/base/html_page.h"
#include "tools/base/svg_chart.h"

namespace thew::tools {
namespace {

constexpr const char* kTableStyle =
    "caption { text-align: left; padding: 10px 12px; font-weight: 600; } td { vertical-align: top; "
    "} th { font-size: 13px; color: var(--soft); } .text { text-align: left; }\n";

using Row = std::vector<std::string>;

/// Which columns are words, to be read from the left; numbers stand to the right.
std::vector<bool> words_of(const Table& table) {
  std::vector<bool> words(table.head.size(), false);
  for (const Row& row : table.rows) {
    for (size_t i = 0; i < row.size() && i < words.size(); ++i) {
      if (!row[i].empty() && !parse_number(row[i])) words[i] = true;
    }
  }
  return words;
}

std::string html_row(const Row& row, const std::string& tag, const std::vector<bool>& words) {
  std::string html = "<tr>";
  for (size_t i = 0; i < row.size(); ++i) {
    html += "<" + tag + (i < words.size() && words[i] ? " class=\"text\">" : ">") +
            escape_html(row[i]) + "</" + tag + ">";
  }
  return html + "</tr>\n";
}

std::string csv_row(const Row& row) {
  std::string text;
  for (size_t i = 0; i < row.size(); ++i) {
    const bool quoted = row[i].find_first_of(",\"") != std::string::npos;
    text += (i ? "," : "") + (quoted ? "\"" + row[i] + "\"" : row[i]);
  }
  return text + "\n";
}

std::string markdown_row(const Row& row) {
  std::string text = "|";
  for (const std::string& cell : row) {
    text += " ";
    for (const char c : cell) text += c == '|' ? "\\|" : std::string(1, c);
    text += " |";
  }
  return text + "\n";
}

}  // namespace

std::string number(double value, int digits) { return readable(value, digits); }

std::string csv_of(const Table& table) {
  std::string text = csv_row(table.head);
  for (const Row& row : table.rows) text += csv_row(row);
  return text;
}

std::string markdown_of(const Table& table) {
  std::string text = "## " + table.title + "\n\n" + markdown_row(table.head) +
                     markdown_row(Row(table.head.size(), "---"));
  for (const Row& row : table.rows) text += markdown_row(row);
  return text + (table.note.empty() ? "" : "\n" + table.note + "\n");
}

std::string html_of(const Table& table) {
  const std::vector<bool> words = words_of(table);
  std::string html = "<div class=\"wide\"><table><caption>" + escape_html(table.title) +
                     "</caption>" + html_row(table.head, "th", words);
  for (const Row& row : table.rows) html += html_row(row, "td", words);
  return html + "</table></div>\n" +
         (table.note.empty() ? "" : "<p class=\"soft\">" + escape_html(table.note) + "</p>\n");
}

std::string html_page(const std::string& title, const std::string& style, const std::string& body) {
  return "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>" +
         escape_html(title) + "</title><style>" + kPageCss + kTableStyle + style +
         "</style></head><body><main>\n<h1>" + escape_html(title) + "</h1>\n" + body +
         "</main></body></html>\n";
}

}  // namespace thew::tools
