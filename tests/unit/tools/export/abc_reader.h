// SPDX-License-Identifier: Apache-2.0
//
// A reader of Alembic that goes the way of the reference library: no reader of it is in Debian.
#pragma once

#include <map>

#include "tests/unit/tools/export/export.h"

namespace thew::tests {

inline constexpr std::uint64_t kLeaf = std::uint64_t{1} << 63;

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

inline unsigned take_hinted(ByteReader& in, unsigned hint) {
  return hint == 0   ? in.take<std::uint8_t>()
         : hint == 1 ? in.take<std::uint16_t>()
                     : in.take<std::uint32_t>();
}

inline Compound read_compound(const Ogawa& file, std::uint64_t place,
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
  struct Object {
    std::string name, meta;
    Compound properties;
    std::vector<Object> children;
  };
  std::vector<Object> objects;  // of the top
  Compound top;

  Compound below(const ReadProperty& compound) const;
  Compound geometry(std::size_t i) const {
    return below(objects.at(i).children.at(0).properties.at(".geom"));
  }
  Compound transform(std::size_t i) const { return below(objects.at(i).properties.at(".xform")); }
};

inline std::vector<ReadArchive::Object> read_objects(const ReadArchive& archive,
                                                     std::uint64_t place, Compound& properties) {
  const auto group = archive.file.group(place);
  properties = read_compound(archive.file, group.front(), archive.texts);
  std::vector<ReadArchive::Object> objects;
  ByteReader headers{archive.file.leaf(group.back())};
  for (std::size_t i = 1; headers.at + 32 < headers.bytes.size(); ++i) {
    auto& object = objects.emplace_back();
    const auto length = headers.take<std::uint32_t>();
    object.name = headers.bytes.substr(headers.at, length);
    headers.at += length;
    object.meta = archive.texts.at(headers.take<std::uint8_t>());
    object.children = read_objects(archive, group.at(i), object.properties);
  }
  EXPECT_EQ(headers.at + 32, headers.bytes.size());
  EXPECT_EQ(objects.size() + 2, group.size());
  return objects;
}

inline Compound ReadArchive::below(const ReadProperty& compound) const {
  return read_compound(file, compound.children.front(), texts);
}

inline ReadArchive read_archive(const std::filesystem::path& path) {
  ReadArchive archive{{bytes_of(path)}, "", {""}, {}, {}, {}, {}};
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
  archive.objects = read_objects(archive, root.at(2), archive.top);
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

}  // namespace thew::tests
