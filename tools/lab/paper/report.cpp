// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/paper/report.h"

#include "sim/cache/durable_file.h"
#include "tools/base/options.h"
#include "tools/render/contact_sheet.h"

namespace thew::tools {
namespace {

// Besides the style of all pages.
constexpr const char* kStyle = R"css(
main { max-width: 1180px; } h2 { margin: 40px 0 8px; }
figure { max-width: max-content; margin: 14px 0; } figure img { width: auto; max-width: 100%; }
svg { width: 640px; max-width: 100%; } .wide { margin: 14px 0; }
.labels { display: flex; font-size: 13.5px; font-weight: 600; } .labels span { flex: 1; text-align: center; }
.left td { text-align: left; white-space: normal; } p { max-width: 85ch; margin: 6px 0; }
.met { color: #14663c; font-weight: 600; } .missed { color: #b3261e; font-weight: 600; }
)css";

// The verdicts as one table.
Table table_of(const std::vector<PaperVerdict>& verdicts) {
  Table table{"verdicts.csv",
              "What is to be shown of the paper",
              "",
              {"what", "wanted", "found", "met", "reason"},
              {}};
  for (const PaperVerdict& v : verdicts) {
    table.rows.push_back({v.what, v.wanted, v.found, v.met ? "yes" : "no", v.met ? "" : v.reason});
  }
  return table;
}

}  // namespace

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

void PaperReport::add(const Table& table) {
  write_durably(place(table.file), csv_of(table));
  chapters_[chapter_].html += html_of(table);
  chapters_[chapter_].tables.push_back(table);
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
  progress_.step(steps_);
}

std::vector<PaperVerdict> PaperReport::verdicts() const {
  std::vector<PaperVerdict> all;
  for (const auto& [at, chapter] : chapters_) {
    all.insert(all.end(), chapter.verdicts.begin(), chapter.verdicts.end());
  }
  return all;
}

std::vector<Table> PaperReport::tables() const {
  std::vector<Table> all = {table_of(verdicts())};
  for (const auto& [at, chapter] : chapters_) {
    all.insert(all.end(), chapter.tables.begin(), chapter.tables.end());
  }
  return all;
}

void PaperReport::write(double seconds) {
  std::string top =
      "<div class=\"wide\"><table class=\"left\"><tr><th>What is to be shown</th>"
      "<th>wanted</th><th>found</th><th></th></tr>\n";
  std::string body;
  for (const auto& [at, chapter] : chapters_) body += chapter.html;
  for (const PaperVerdict& v : verdicts()) {
    top += "<tr><td>" + escape_html(v.what) + "</td><td>" + escape_html(v.wanted) + "</td><td>" +
           escape_html(v.found) + "</td><td>" +
           (v.met ? "<span class=\"met\">met</span>"
                  : "<span class=\"missed\">missed</span> " + escape_html(v.reason)) +
           "</td></tr>\n";
  }
  top += "</table></div>\n";
  write_durably(folder / "verdicts.csv", csv_of(table_of(verdicts())));
  const char* const quickly =
      " This is the quick run: fewer frames, repetitions and elements, these on a thread of their "
      "own.";
  write_durably(
      folder / "report.html",
      html_page(
          "The paper, reproduced", kStyle,
          "<p class=\"soft\">Hong, Jung, Choi, Welch, Fast Volume Preservation for a "
          "Mass-Spring System, IEEE CG&amp;A 2006. Printed values are of a 2.0 GHz Pentium 4; "
          "the ratios carry over." +
              std::string(quick ? quickly : "") + "</p>\n" + top + body +
              "<p class=\"soft\">Made in " + number(seconds) +
              " s. CPU time of one thread; medians of interleaved repetitions.</p>\n"));
}

}  // namespace thew::tools
