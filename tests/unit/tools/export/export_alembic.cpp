// SPDX-License-Identifier: Apache-2.0
//
// Alembic, read back by a reader of the test's own that goes the way of the reference library: no
// reader of Alembic is in Debian.
#include <gtest/gtest.h>

#include <map>

#include "tests/unit/tools/export/export.h"

namespace thew::tests {
namespace {

constexpr std::uint64_t kLeaf = std::uint64_t{1} << 63;

struct Ogawa {
  std::string bytes;

  std::vector<std::uint64_t> group(std::uint64_t place) const {
    EXPECT_EQ(place & kLeaf, 0u);
    if (place == 0) return {};
    ByteReader in{bytes, place};
    std::vector<std::uint64_t> children(in.take<std::uint64_t>());
    for (auto& child : children) child = in.take<std::uint64_t>();
    return children;
  }
  std::string leaf(std::uint64_t child) const {
    EXPECT_NE(child & kLeaf, 0u);
    if (child == kLeaf) return "";
    ByteReader in{bytes, child & ~kLeaf};
    const auto size = in.take<std::uint64_t>();
    EXPECT_LE(in.at + size, bytes.size());
    return bytes.substr(in.at, size);
  }
};

struct ReadProperty {
  unsigned type = 0, pod = 0, extent = 0, samples = 0, sampling = 0;
  bool constant = false;
  std::string meta;
  std::vector<std::uint64_t> children;
};
using Compound = std::map<std::string, ReadProperty>;

unsigned take_hinted(ByteReader& in, unsigned hint) {
  return hint == 0   ? in.take<std::uint8_t>()
         : hint == 1 ? in.take<std::uint16_t>()
                     : in.take<std::uint32_t>();
}

Compound read_compound(const Ogawa& file, std::uint64_t place,
                       const std::vector<std::string>& texts) {
  Compound compound;
  const auto children = file.group(place);
  if (children.empty()) return compound;
  ByteReader in{file.leaf(children.back())};
  for (std::size_t i = 0; in.at < in.bytes.size(); ++i) {
    const auto bits = in.take<std::uint32_t>();
    const unsigned hint = bits >> 2 & 3;
    ReadProperty property;
    property.type = bits & 3;
    if (property.type != 0) {
      property.pod = bits >> 4 & 15;
      property.extent = bits >> 12 & 255;
      property.constant = bits & 0x800;
      EXPECT_TRUE(bits & 0x400);
      EXPECT_FALSE(bits & 0x200);
      property.samples = take_hinted(in, hint);
      if (bits & 0x100) property.sampling = take_hinted(in, hint);
    }
    const unsigned length = take_hinted(in, hint);
    const std::string name = in.bytes.substr(in.at, length);
    in.at += length;
    property.meta = texts.at(bits >> 20 & 255);
    property.children =
        property.type == 0 ? std::vector{children.at(i)} : file.group(children.at(i));
    compound[name] = property;
  }
  EXPECT_EQ(compound.size() + 1, children.size());
  return compound;
}

struct ReadArchive {
  Ogawa file;
  std::string meta;
  std::vector<std::string> texts = {""};
  std::vector<std::vector<double>> samplings;  // seconds a cycle, then the stored times
  std::vector<unsigned> most_samples;
  std::vector<std::string> names, object_meta;
  std::vector<Compound> geometry;
};

ReadArchive read_archive(const std::filesystem::path& path) {
  ReadArchive archive{{bytes_of(path)}, "", {""}, {}, {}, {}, {}, {}};
  const Ogawa& file = archive.file;
  EXPECT_EQ(file.bytes.substr(0, 8), std::string("Ogawa\xff\0\1", 8));
  ByteReader in{file.bytes, 8};
  const auto root = file.group(in.take<std::uint64_t>());
  EXPECT_EQ(root.size(), 6u);
  EXPECT_EQ((ByteReader{file.leaf(root.at(0))}.take<std::int32_t>()), 0);
  EXPECT_GE((ByteReader{file.leaf(root.at(1))}.take<std::int32_t>()), 9999);
  archive.meta = file.leaf(root.at(3));
  for (ByteReader times{file.leaf(root.at(4))}; times.at < times.bytes.size();) {
    archive.most_samples.push_back(times.take<std::uint32_t>());
    auto& sampling = archive.samplings.emplace_back();
    sampling.push_back(times.take<double>());
    const auto stored = times.take<std::uint32_t>();
    for (unsigned i = 0; i < stored; ++i) sampling.push_back(times.take<double>());
  }
  for (ByteReader texts{file.leaf(root.at(5))}; texts.at < texts.bytes.size();) {
    const auto length = texts.take<std::uint8_t>();
    archive.texts.push_back(texts.bytes.substr(texts.at, length));
    texts.at += length;
  }
  const auto top = file.group(root.at(2));
  EXPECT_EQ(top.front(), 0u);
  ByteReader headers{file.leaf(top.back())};
  for (std::size_t i = 1; headers.at + 32 < headers.bytes.size(); ++i) {
    const auto length = headers.take<std::uint32_t>();
    archive.names.push_back(headers.bytes.substr(headers.at, length));
    headers.at += length;
    archive.object_meta.push_back(archive.texts.at(headers.take<std::uint8_t>()));
    const auto object = file.group(top.at(i));
    EXPECT_EQ(file.leaf(object.back()).size(), 32u);
    const Compound properties = read_compound(file, object.front(), archive.texts);
    archive.geometry.push_back(
        read_compound(file, properties.at(".geom").children.front(), archive.texts));
  }
  EXPECT_EQ(archive.names.size() + 2, top.size());
  return archive;
}

template <typename T>
std::vector<T> sample(const ReadArchive& archive, const ReadProperty& property, int i) {
  const std::size_t width = property.type == 1 ? 1 : 2;  // an array has its dimensions beside it
  const std::size_t at = property.constant ? 0 : static_cast<std::size_t>(i);
  EXPECT_EQ(property.children.size(), (property.constant ? 1 : property.samples) * width);
  if (width == 2) {
    EXPECT_EQ(archive.file.leaf(property.children.at(2 * at + 1)), "");
  }
  ByteReader in{archive.file.leaf(property.children.at(width * at)), 16};
  std::vector<T> values;
  while (in.at < in.bytes.size()) values.push_back(in.take<T>());
  return values;
}

TEST_F(ExportTest, AlembicHoldsEveryFrame) {
  for (const bool double_precision : {false, true}) {
    bake(double_precision);
    const ReadArchive archive = read_archive(write("all.abc", {}));
    EXPECT_NE(archive.meta.find("_ai_DCC_FPS=24"), std::string::npos);
    EXPECT_NE(archive.meta.find("units: m, up_axis: Y, fps: 24, first_frame: -2"),
              std::string::npos);
    EXPECT_EQ(archive.most_samples, (std::vector<unsigned>{0, 4}));
    EXPECT_EQ(archive.samplings[1], (std::vector<double>{2 / 24.0, -2 / 24.0}));
    ASSERT_EQ(archive.names, (std::vector<std::string>{"biceps", "skin", "ulna"}));
    for (std::size_t m = 0; m < 3; ++m) {
      const std::string& name = archive.names[m];
      const Compound& geometry = archive.geometry[m];
      EXPECT_EQ(archive.object_meta[m],
                "schema=AbcGeom_PolyMesh_v1;schemaBaseType=AbcGeom_GeomBase_v1;"
                "schemaObjTitle=AbcGeom_PolyMesh_v1:.geom");
      EXPECT_EQ(geometry.at("P").meta, "geoScope=vtx;interpretation=point");
      for (int i = 0; i < 4; ++i) {
        const auto p = sample<float>(archive, geometry.at("P"), i);
        EXPECT_EQ(p, as_floats(positions(name, i)));
        EXPECT_EQ(sample<float>(archive, geometry.at("N"), i).size(), p.size());
        const auto bounds = sample<double>(archive, geometry.at(".selfBnds"), i);
        ASSERT_EQ(bounds.size(), 6u);
        Vec3 low = positions(name, i)[0];
        for (const Vec3& q : positions(name, i)) low = low.cwiseMin(q);
        EXPECT_EQ(Vec3(bounds[0], bounds[1], bounds[2]), low);
      }
      const Vec3 moved = positions(name, 3)[1] - positions(name, 1)[1];
      EXPECT_EQ(sample<float>(archive, geometry.at(".velocities"), 2)[4],
                static_cast<float>(moved.y() / (4 / 24.0)));
      const auto indices = sample<std::int32_t>(archive, geometry.at(".faceIndices"), 3);
      const auto counts = sample<std::int32_t>(archive, geometry.at(".faceCounts"), 3);
      const auto& triangles = mesh(name).rest.triangles;
      EXPECT_EQ(counts, std::vector<std::int32_t>(triangles.size(), 3));
      ASSERT_EQ(indices.size(), 3 * triangles.size());
      for (std::size_t t = 0; t < triangles.size(); ++t) {
        // Clockwise.
        EXPECT_EQ((Triangle{indices[3 * t + 2], indices[3 * t + 1], indices[3 * t]}), triangles[t]);
      }
      for (const auto& [property, read] : geometry) {
        EXPECT_EQ(read.samples, 4u) << property;
        EXPECT_EQ(read.sampling, 1u) << property;
      }
    }
  }
}

TEST_F(ExportTest, AlembicListsTheTimesOfUnevenFrames) {
  bake(false);
  options_.frames = "-2,0,4";
  const ReadArchive archive = read_archive(write("ulna.abc", {"ulna"}));
  EXPECT_EQ(archive.samplings[1], (std::vector<double>{std::numeric_limits<double>::max() / 32.0,
                                                       -2 / 24.0, 0.0, 4 / 24.0}));
  EXPECT_EQ(sample<float>(archive, archive.geometry[0].at("P"), 2),
            as_floats(positions("ulna", 3)));
}

TEST_F(ExportTest, AlembicOfOneFrameIsConstant) {
  bake(false);
  options_.frames = "4";
  const ReadArchive archive = read_archive(write("ulna.abc", {"ulna"}));
  EXPECT_TRUE(archive.geometry[0].at("P").constant);
  EXPECT_EQ(sample<float>(archive, archive.geometry[0].at("P"), 0),
            as_floats(positions("ulna", 3)));
}

}  // namespace
}  // namespace thew::tests
