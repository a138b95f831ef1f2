// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/paper/report.h"

#include "sim/cache/durable_file.h"
#include "tools/base/options.h"
#include "tools/render/contact_sheet.h"

namespace thew::tools {
namespace {

constexpr const char* kStyle = R"css(
body { margin: 0; background: #f4f5f6; color: #1d2329;
  font: 15px/1.5 system-ui, "Segoe UI", Roboto, "Noto Sans", sans-serif; }
main { max-width: 1180px; margin: 0 auto; padding: 32px 24px 48px; }
h1 { margin: 0; font-size: 30px; } h2 { margin: 40px 0 8px; font-size: 20px; }
p { max-width: 85ch; margin: 6px 0; } .soft, figcaption { color: #5c6670; font-size: 13.5px; }
figure { max-width: max-content; margin: 14px 0; padding: 14px; background: #fff; border: 1px solid #e3e6e9; border-radius: 6px; }
img { display: block; max-width: 100%; height: auto; } svg { display: block; width: 640px; max-width: 100%; height: auto;
  font: 12px system-ui, sans-serif; }
.labels { display: flex; font-size: 13.5px; font-weight: 600; } .labels span { flex: 1; text-align: center; }
.wide { overflow-x: auto; background: #fff; border: 1px solid #e3e6e9; border-radius: 6px; margin: 14px 0; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
caption { text-align: left; padding: 10px 12px; font-weight: 600; }
th, td { padding: 6px 12px; text-align: right; border-top: 1px solid #e3e6e9; vertical-align: top; }
td { white-space: nowrap; } .left td { white-space: normal; }
th { font-size: 13px; color: #5c6670; } th:first-child, td:first-child { text-align: left; }
.met { color: #14663c; font-weight: 600; } .missed { color: #b3261e; font-weight: 600; }
.left td { text-align: left; } svg .title { font-size: 15px; font-weight: 600; }
svg .tick, svg .unit { fill: #5c6670; font-size: 12px; } svg .grid { stroke: #e3e6e9; }
svg .line { fill: none; stroke-width: 1.7; } svg .leader { opacity: .45; }
svg line.limit { stroke: #b3261e; stroke-dasharray: 6 4; } svg text.limit { fill: #b3261e; }
)css";

std::string csv_text(const PaperTable& table) {
  std::string text;
  const auto line = [&](const std::vector<std::string>& cells) {
    for (size_t i = 0; i < cells.size(); ++i) {
      const bool quoted = cells[i].find_first_of(",\"") != std::string::npos;
      text += (i ? "," : "") + (quoted ? "\"" + cells[i] + "\"" : cells[i]);
    }
    text += "\n";
  };
  line(table.head);
  for (const auto& row : table.rows) line(row);
  return text;
}

std::string table_html(const PaperTable& table, const char* style) {
  std::string html = std::string("<div class=\"wide\"><table") + style + "><caption>" +
                     escape_html(table.title) + "</caption><tr>";
  for (const std::string& cell : table.head) html += "<th>" + escape_html(cell) + "</th>";
  html += "</tr>\n";
  for (const auto& row : table.rows) {
    html += "<tr>";
    for (const std::string& cell : row) html += "<td>" + escape_html(cell) + "</td>";
    html += "</tr>\n";
  }
  return html + "</table></div>\n" +
         (table.note.empty() ? "" : "<p class=\"soft\">" + escape_html(table.note) + "</p>\n");
}

}  // namespace

std::string number(double value, int digits) { return readable(value, digits); }

PaperReport::PaperReport(const std::filesystem::path& out, bool is_quick,
                         const std::filesystem::path& cow_file, bool overwrite, Progress& progress)
    : quick(is_quick),
      folder(out),
      cow(cow_file),
      scenes(own_asset("paper")),
      overwrite_(overwrite),
      progress_(progress) {
  create_folders(out);
  for (const char* name : {"report.html", "verdicts.csv"}) place(name);
}

std::filesystem::path PaperReport::place(const std::string& name) const {
  claim({folder / name}, overwrite_);
  return folder / name;
}

void PaperReport::section(const std::string& title, const std::string& text) {
  chapters_[chapter_].html +=
      "<h2>" + escape_html(title) + "</h2>\n<p>" + escape_html(text) + "</p>\n";
}

void PaperReport::add(const PaperTable& table) {
  write_durably(place(table.file), csv_text(table));
  chapters_[chapter_].html += table_html(table, "");
}

void PaperReport::add(const LineChart& chart, const std::string& file, const std::string& caption) {
  const std::string svg = draw_chart(chart);
  write_durably(place(file), svg);
  chapters_[chapter_].html +=
      "<figure>" + svg + "<figcaption>" + escape_html(caption) + "</figcaption></figure>\n";
}

void PaperReport::add(const std::vector<PaperPicture>& pictures,
                      const std::vector<std::string>& labels, const std::string& file,
                      const std::string& caption) {
  std::vector<Image> images;
  for (const PaperPicture& picture : pictures) {
    if (!renderer_) {
      renderer_ = std::make_unique<Renderer>(picture.width, picture.height, picture.meshes);
    }
    renderer_->show(picture.width, picture.height, picture.meshes);
    images.push_back(renderer_->draw(picture.view, picture.positions));
  }
  const int columns = static_cast<int>(images.size());
  write_png(place(file), contact_sheet(images, columns, columns > 4 ? 320 : 420), 6);
  chapters_[chapter_].html += "<figure><div class=\"labels\">";
  for (const std::string& label : labels)
    chapters_[chapter_].html += "<span>" + escape_html(label) + "</span>";
  chapters_[chapter_].html += "</div><img src=\"" + file + "\" alt=\"" + escape_html(caption) +
                              "\"><figcaption>" + escape_html(caption) + "</figcaption></figure>\n";
}

void PaperReport::add(const PaperVerdict& verdict) {
  chapters_[chapter_].verdicts.push_back(verdict);
}

void PaperReport::done(int steps) {
  const std::scoped_lock lock(mutex_);
  steps_ += steps;
  progress_.step(steps_, steps_);
}

void PaperReport::write(double seconds) {
  std::string top =
      "<div class=\"wide\"><table class=\"left\"><tr><th>What is to be shown</th>"
      "<th>wanted</th><th>found</th><th></th></tr>\n";
  std::string csv = "what,wanted,found,met,reason\n";
  std::string body;
  std::vector<PaperVerdict> verdicts;
  for (const auto& [at, chapter] : chapters_) {
    body += chapter.html;
    verdicts.insert(verdicts.end(), chapter.verdicts.begin(), chapter.verdicts.end());
  }
  for (const PaperVerdict& v : verdicts) {
    top += "<tr><td>" + escape_html(v.what) + "</td><td>" + escape_html(v.wanted) + "</td><td>" +
           escape_html(v.found) + "</td><td>" +
           (v.met ? "<span class=\"met\">met</span>"
                  : "<span class=\"missed\">missed</span> " + escape_html(v.reason)) +
           "</td></tr>\n";
    csv += "\"" + v.what + "\",\"" + v.wanted + "\",\"" + v.found + "\"," + (v.met ? "yes" : "no") +
           ",\"" + (v.met ? "" : v.reason) + "\"\n";
  }
  top += "</table></div>\n";
  write_durably(folder / "verdicts.csv", csv);
  write_durably(
      folder / "report.html",
      "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>The paper, "
      "reproduced</title><style>" +
          std::string(kStyle) +
          "</style></head><body><main>\n<h1>The paper, reproduced</h1>\n<p class=\"soft\">Hong, "
          "Jung, Choi, Welch, Fast Volume Preservation for a Mass-Spring System, IEEE CG&amp;A "
          "2006. Printed values are of a 2.0 GHz Pentium 4; the ratios carry over." +
          (quick ? std::string(" This is the quick run: fewer frames, repetitions and elements, "
                               "these on a thread of their own.")
                 : std::string()) +
          "</p>\n" + top + body + "<p class=\"soft\">Made in " + number(seconds) +
          " s. CPU time of one thread; medians of interleaved repetitions.</p>\n" +
          "</main></body></html>\n");
}

}  // namespace thew::tools
