// SPDX-License-Identifier: Apache-2.0
//
// Frame 1 of the bake is the same instant in every format, and so are all others: at frame / fps,
// in seconds, stands that frame.
#include <gtest/gtest.h>

#include <sstream>

#include "tests/unit/tools/export/abc_reader.h"
#include "tests/unit/tools/export/crate_reader.h"
#include "tests/unit/tools/export/glb_reader.h"

namespace thew::tests {
namespace {

constexpr double kFps = 24.0;
constexpr std::size_t kVertex = 3;  // of the muscle, that is looked at

// Where it is, by s.
using Instants = std::vector<std::pair<double, Eigen::Vector3f>>;

class InstantTest : public ExportTest {
 protected:
  InstantTest() {
    bake({1, 2, 3, 4}, [](BakeFrame&) {});
    for (int i = 0; i < 4; ++i) {
      expected_.emplace_back((i + 1) / kFps, positions("biceps", i)[kVertex].cast<float>());
    }
  }
  std::string exported(const std::string& name) { return bytes_of(write(name, {"biceps"})); }

  void expect(const std::string& format, const Instants& read) const {
    ASSERT_EQ(read.size(), expected_.size()) << format;
    for (std::size_t i = 0; i < read.size(); ++i) {
      EXPECT_NEAR(read[i].first, expected_[i].first, 1e-7) << format;
      EXPECT_LT((read[i].second - expected_[i].second).norm(), 1e-6f) << format << " " << i;
    }
  }
  Instants expected_;
};

template <typename Take>
Eigen::Vector3f at_vertex(ByteReader in, const Take& take) {
  in.at += 12 * kVertex;
  const float x = take(in), y = take(in), z = take(in);
  return {x, y, z};
}

// The numbers of a text from `at` to the end of the line.
std::vector<double> numbers(const std::string& text, std::size_t at) {
  std::string line = text.substr(at, text.find('\n', at) - at);
  for (char& c : line) c = std::string("()[],:").find(c) == std::string::npos ? c : ' ';
  std::istringstream in(line);
  std::vector<double> values;
  for (double value; in >> value;) values.push_back(value);
  return values;
}

TEST_F(InstantTest, PointCaches) {
  const auto little = [](ByteReader& in) { return in.take<float>(); };
  const auto big = [](ByteReader& in) { return in.take<float>(true); };
  ByteReader pc2{exported("a.pc2"), 16}, mdd{exported("a.mdd"), 0};
  const auto points = pc2.take<std::int32_t>();
  const float first = pc2.take<float>(), step = pc2.take<float>();
  const auto samples = pc2.take<std::int32_t>();
  Instants read;
  for (int i = 0; i < samples; ++i, pc2.at += 12 * static_cast<std::size_t>(points)) {
    read.emplace_back((first + i * step) / kFps, at_vertex(pc2, little));
  }
  expect("PC2", read);
  std::vector<float> seconds(mdd.take<std::uint32_t>(true));
  mdd.at += 4;
  for (float& time : seconds) time = mdd.take<float>(true);
  read.clear();
  for (const float time : seconds) {
    read.emplace_back(time, at_vertex(mdd, big));
    mdd.at += 12 * static_cast<std::size_t>(points);
  }
  expect("MDD", read);
}

TEST_F(InstantTest, Sequences) {
  write("s/a.obj", {"biceps"});
  write("s/a.ply", {"biceps"});
  Instants obj, ply;
  for (int frame = 1; frame <= 4; ++frame) {
    const std::string name = (folder_ / "s/a.000").string() + std::to_string(frame);
    const std::string text = bytes_of(name + ".obj"), bytes = bytes_of(name + ".ply");
    std::size_t at = 0;
    for (std::size_t v = 0; v <= kVertex; ++v) at = text.find("\nv ", at) + 3;
    const std::vector<double> values = numbers(text, at);
    obj.emplace_back(frame / kFps, Eigen::Vector3d(values.data()).cast<float>());
    const std::string end = "end_header\n";
    ByteReader in{bytes, bytes.find(end) + end.size() + kVertex * (24 + 24)};  // all as written
    const double x = in.take<double>(), y = in.take<double>(), z = in.take<double>();
    ply.emplace_back(frame / kFps, Eigen::Vector3d(x, y, z).cast<float>());
  }
  expect("OBJ", obj);
  expect("PLY", ply);
}

TEST_F(InstantTest, Gltf) {
  const Glb glb = read_glb(write("a.glb", {"biceps"}));
  const std::vector<float> times = glb.floats(glb.doc["animations"][0]["samplers"][0]["input"]);
  Instants read;
  for (std::size_t key = 0; key < times.size(); ++key) {
    const Shape shape = GlbPlayer(glb, key).shape(0, 0);
    read.emplace_back(times[key], shape.positions[kVertex].cast<float>());
  }
  expect("glTF", read);
}

TEST_F(InstantTest, Xdmf) {
  const std::string text = exported("a.xdmf");
  Instants read;
  for (std::size_t at = 0; (at = text.find("<Time Value=\"", at)) != std::string::npos;) {
    at += 13;
    const double time = std::stod(text.substr(at));
    const std::size_t place = text.find("/positions|", at) + 11;
    read.emplace_back(time,
                      positions("biceps", std::stoi(text.substr(place)))[kVertex].cast<float>());
  }
  expect("XDMF", read);
}

TEST_F(InstantTest, Usd) {
  const std::string text = exported("a.usda");
  const double per_second = numbers(text, text.find("timeCodesPerSecond = ") + 21).at(0);
  Instants read;
  std::size_t at = text.find(" points.timeSamples = {\n");
  while ((at = text.find('\n', at) + 1, text.substr(at, 40).find('}') == std::string::npos)) {
    const std::vector<double> values = numbers(text, at);
    read.emplace_back(values.at(0) / per_second,
                      Eigen::Vector3d(&values.at(1 + 3 * kVertex)).cast<float>());
  }
  expect("usda", read);
  for (const std::string name : {"a.usdc", "a.usdz"}) {
    const std::string bytes = exported(name);
    const Crate crate = read_crate(name == "a.usdz" ? bytes.substr(64) : bytes);
    // What is a float too stands in place of a value's place.
    const std::uint64_t rep = crate.specs.at("").at("timeCodesPerSecond");
    float codes;
    std::memcpy(&codes, &rep, sizeof codes);
    read.clear();
    for (const auto& [code, value] :
         crate.samples(crate.specs.at("/Bake/Muscles/biceps.points").at("timeSamples"))) {
      read.emplace_back(code / codes, Eigen::Vector3f(&crate.floats(value)[3 * kVertex]));
    }
    expect(name, read);
  }
}

TEST_F(InstantTest, Alembic) {
  const ReadArchive archive = read_archive(write("a.abc", {"biceps"}));
  const std::vector<double>& sampling = archive.samplings.at(1);
  Instants read;
  for (int i = 0; i < 4; ++i) {
    const auto points = sample<float>(archive, archive.geometry(0).at("P"), i);
    read.emplace_back(sampling.at(1) + i * sampling.at(0), Eigen::Vector3f(&points[3 * kVertex]));
  }
  expect("Alembic", read);
}

}  // namespace
}  // namespace thew::tests
