// SPDX-License-Identifier: Apache-2.0
//
// A reader of USD's crates that knows no more than what ours hold.
#pragma once

#include <map>

#include "tests/unit/tools/export/export.h"

namespace thew::tests {

inline constexpr std::uint64_t kPlace = (std::uint64_t{1} << 48) - 1;

struct Crate {
  std::string bytes;
  std::vector<std::string> tokens;
  using Fields = std::map<std::string, std::uint64_t>;
  std::map<std::string, Fields> specs;  // by path

  std::vector<float> floats(std::uint64_t rep) const {
    EXPECT_EQ(rep >> 63, 1u);
    EXPECT_EQ((rep & kPlace) % 8, 0u);
    ByteReader in{bytes, rep & kPlace};
    const auto width = (rep >> 48 & 255) == 24 ? 3u : (rep >> 48 & 255) == 20 ? 2u : 1u;
    std::vector<float> values(width * in.take<std::uint64_t>());
    for (float& value : values) value = in.take<float>();
    return values;
  }
  std::vector<double> doubles(std::uint64_t rep, std::size_t count) const {
    ByteReader in{bytes, rep & kPlace};
    std::vector<double> values(count);
    for (double& value : values) value = in.take<double>();
    return values;
  }
  const std::string& token(std::uint64_t rep) const { return tokens.at(rep & kPlace); }
  // By time, the place of the value.
  std::map<double, std::uint64_t> samples(std::uint64_t rep) const {
    ByteReader in{bytes, rep & kPlace};
    EXPECT_EQ(in.take<std::int64_t>(), 8);
    ByteReader times{bytes, in.take<std::uint64_t>() & kPlace};
    EXPECT_EQ(in.take<std::int64_t>(), 8);
    const auto count = in.take<std::uint64_t>();
    EXPECT_EQ(times.take<std::uint64_t>(), count);
    std::map<double, std::uint64_t> samples;
    for (std::uint64_t i = 0; i < count; ++i) {
      samples[times.take<double>()] = in.take<std::uint64_t>();
    }
    return samples;
  }
};

// LZ4 of one piece without repetitions.
inline std::string unpacked(ByteReader& in) {
  const auto size = in.take<std::uint64_t>();
  ByteReader block{in.bytes.substr(in.at, size)};
  in.at += size;
  EXPECT_EQ(block.take<std::uint8_t>(), 0);
  std::size_t length = block.take<std::uint8_t>() >> 4;
  if (length == 15) {
    for (unsigned more = 255; more == 255; length += more) more = block.take<std::uint8_t>();
  }
  EXPECT_EQ(block.at + length, block.bytes.size());
  return block.bytes.substr(block.at);
}

inline std::vector<std::int32_t> integers(ByteReader& in, std::size_t count) {
  const std::string plain = unpacked(in);
  ByteReader codes{plain, 4}, numbers{plain, 4 + (2 * count + 7) / 8};
  const auto common = ByteReader{plain}.take<std::int32_t>();
  std::vector<std::int32_t> values;
  std::int32_t value = 0;
  unsigned four = 0;
  for (std::size_t i = 0; i < count; ++i) {
    if (i % 4 == 0) four = codes.take<std::uint8_t>();
    const unsigned code = four >> 2 * (i % 4) & 3;
    value += code == 0   ? common
             : code == 1 ? numbers.take<std::int8_t>()
             : code == 2 ? numbers.take<std::int16_t>()
                         : numbers.take<std::int32_t>();
    values.push_back(value);
  }
  EXPECT_EQ(numbers.at, plain.size());
  return values;
}

inline Crate read_crate(const std::string& bytes) {
  Crate crate{bytes, {}, {}};
  EXPECT_EQ(bytes.substr(0, 16), "PXR-USDC" + std::string("\0\x8\0\0\0\0\0\0", 8));
  ByteReader in{bytes, 16};
  ByteReader contents{bytes, in.take<std::uint64_t>()};
  std::map<std::string, ByteReader> sections;
  for (auto left = contents.take<std::uint64_t>(); left > 0; --left) {
    const std::string name = bytes.c_str() + contents.at;
    contents.at += 16;
    const auto place = contents.take<std::uint64_t>(), size = contents.take<std::uint64_t>();
    EXPECT_LE(place + size, bytes.size());
    sections[name] = {bytes, place};
  }
  const auto counted = [&](const char* name) { return sections.at(name).take<std::uint64_t>(); };
  const auto tokens = counted("TOKENS"), texts = counted("TOKENS");
  const std::string text = unpacked(sections["TOKENS"]);
  EXPECT_EQ(text.size(), texts);
  for (std::size_t at = 0; at < text.size(); at += crate.tokens.back().size() + 1) {
    crate.tokens.push_back(text.c_str() + at);
  }
  EXPECT_EQ(crate.tokens.size(), tokens);
  const auto fields = counted("FIELDS");
  const auto names = integers(sections["FIELDS"], fields);
  ByteReader reps{unpacked(sections["FIELDS"])};
  const auto sets = counted("FIELDSETS");
  const auto set = integers(sections["FIELDSETS"], sets);
  const auto paths = counted("PATHS");
  EXPECT_EQ(counted("PATHS"), paths);
  const auto numbers = integers(sections["PATHS"], paths);
  const auto elements = integers(sections["PATHS"], paths);
  const auto jumps = integers(sections["PATHS"], paths);
  EXPECT_EQ(counted("SPECS"), paths);
  EXPECT_EQ(integers(sections["SPECS"], paths), numbers);
  const auto first = integers(sections["SPECS"], paths);
  const auto kinds = integers(sections["SPECS"], paths);
  std::map<std::size_t, std::string> parent_of = {{0, ""}};  // known once what is before was read
  for (std::size_t i = 0; i < paths; ++i) {
    const std::string& parent = parent_of.at(i);
    const std::string path =
        i == 0 ? "" : parent + (elements[i] < 0 ? "." : "/") + crate.tokens[std::abs(elements[i])];
    const bool relationship = elements[i] < 0 && kinds[i] == 8;
    EXPECT_EQ(kinds[i], i == 0 ? 7 : relationship ? 8 : elements[i] < 0 ? 1 : 6) << path;
    if (jumps[i] > 0) parent_of[i + static_cast<std::size_t>(jumps[i])] = parent;
    if (jumps[i] == 0) parent_of[i + 1] = parent;
    if (jumps[i] > 0 || jumps[i] == -1) parent_of[i + 1] = path;
    Crate::Fields& of = crate.specs[path];
    for (auto at = static_cast<std::size_t>(first[i]); set.at(at) != -1; ++at) {
      reps.at = 8 * static_cast<std::size_t>(set[at]);
      of[crate.tokens.at(names.at(set[at]))] = reps.take<std::uint64_t>();
    }
  }
  return crate;
}

}  // namespace thew::tests
