// SPDX-License-Identifier: Apache-2.0
//
// What the viewer's script will unpack: each position within the stated rounding, and a page that
// no name of a mesh can break.
#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/unit/tools/export/export.h"
#include "tools/base/html_page.h"
#include "tools/report/viewer.h"

namespace thew::tests {
namespace {

using nlohmann::json;

std::string between(const std::string& text, const std::string& begin, const std::string& end) {
  const std::size_t at = text.find(begin);
  EXPECT_NE(at, std::string::npos) << begin;
  const std::size_t from = at + begin.size();
  return text.substr(from, text.find(end, from) - from);
}

std::string from_base64(const std::string& text) {
  std::string bytes;
  unsigned bits = 0, have = 0;
  for (const char c : text) {
    if (c == '=') break;
    const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    EXPECT_NE(digits.find(c), std::string::npos);
    bits = bits << 6 | static_cast<unsigned>(digits.find(c));
    if ((have += 6) >= 8) bytes += static_cast<char>(bits >> (have -= 8) & 255);
  }
  return bytes;
}

TEST_F(ExportTest, TheViewerHoldsEveryPositionWithinItsRounding) {
  bake(true);
  const std::string page = report_viewer(*reader_);
  const json head = json::parse(between(page, "id=\"viewer-head\">", "</script>"));
  const std::string packed = from_base64(between(page, "id=\"viewer-data\">", "</script>"));
  std::string bytes(1 << 16, '\0');
  uLongf size = bytes.size();
  ASSERT_EQ(uncompress(reinterpret_cast<Bytef*>(bytes.data()), &size,
                       reinterpret_cast<const Bytef*>(packed.data()), packed.size()),
            Z_OK);
  bytes.resize(size);
  ByteReader in{bytes};
  EXPECT_EQ(head["frames"], (json{-2, 0, 2, 4}));
  const double step = head["step"];
  double largest = 0.0;
  for (std::size_t m = 0; m < 3; ++m) {
    const BakeMesh& mesh = reader_->info().meshes[m];
    EXPECT_EQ(head["meshes"][m]["name"], mesh.name);
    for (const Triangle& triangle : mesh.rest.triangles) {
      for (const int vertex : triangle) {
        EXPECT_EQ(in.take<std::uint32_t>(), static_cast<std::uint32_t>(vertex));
      }
    }
    for (const double weight : mesh.weights) {
      EXPECT_NEAR(in.take<std::uint8_t>() / 255.0 * 2.0, weight, 1.001 / 255.0);
    }
    const std::size_t count = mesh.rest.vertices.size();
    std::vector<std::uint16_t> last(3 * count, 0);
    const bool rest = mesh.kind == BakeMesh::Kind::kSkin;  // its rest pose comes first
    EXPECT_EQ(head["meshes"][m]["rest"], rest);
    for (int f = rest ? -1 : 0; f < 4; ++f) {
      const std::vector<Vec3> baked = f < 0 ? mesh.rest.vertices : positions(mesh.name, f);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::size_t v = 0; v < count; ++v) {
          const auto low = static_cast<unsigned char>(bytes[in.at + v]);
          const auto high = static_cast<unsigned char>(bytes[in.at + count + v]);
          const unsigned folded = low | unsigned{high} << 8;
          last[axis * count + v] += static_cast<std::uint16_t>(folded >> 1 ^ -(folded & 1));
          const double read = head["low"][axis].get<double>() + step * last[axis * count + v];
          largest = std::max(largest, std::abs(read - baked[v][static_cast<Eigen::Index>(axis)]));
        }
        in.at += 2 * count;
      }
    }
  }
  EXPECT_EQ(in.at, bytes.size());
  EXPECT_GT(largest, 0.0);
  EXPECT_LE(largest, 0.5 * step * (1 + 1e-9));
  EXPECT_NE(page.find(" µm for this view"), std::string::npos);
}

TEST_F(ExportTest, NoNameEndsTheViewersScript) {
  info_ = small_info(false);
  info_.meshes[1].name = "<!-- <script> \"'&";
  bake_small(folder_, info_);
  const std::string page = report_viewer(BakeReader(folder_ / "bake.h5"));
  const json head = json::parse(between(page, "id=\"viewer-head\">", "</script>"));
  EXPECT_EQ(head["meshes"][0]["name"], info_.meshes[1].name);
  EXPECT_EQ(page.find("<!--"), std::string::npos);
}

TEST(Base64, AsInItsStandard) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
}

}  // namespace
}  // namespace thew::tests
