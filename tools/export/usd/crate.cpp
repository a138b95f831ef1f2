// SPDX-License-Identifier: Apache-2.0
//
// Bootstrap: "PXR-USDC", uint8 version 0 8 0, uint64 place of the table of contents, to 88 bytes.
// Contents: uint64 sections, each char[16] name, uint64 place, uint64 size.
// TOKENS: uint64 count, uint64 bytes, uint64 compressed bytes, texts that end with 0 as LZ4.
// STRINGS: uint64 count, uint32 token each.
// FIELDS: uint64 count, tokens as integers, uint64 compressed bytes, places of values as LZ4.
// FIELDSETS: uint64 count, fields as integers, -1 after each set.
// PATHS: uint64 count twice, by path and depth first as integers: its number, its last token
// (negative of a property), how far its next sibling is (-2: neither child nor sibling, -1: a
// child alone, 0: a sibling alone).
// SPECS: uint64 count, as integers: path, first field, kind.
// Integers: uint64 compressed bytes, then as LZ4: int32 the most frequent difference from one to
// the next, two bits each (0: that one, 1, 2, 3: one of 1, 2, 4 bytes), these differences.
#include "tools/export/usd/crate.h"

#include <algorithm>

#include "sim/cache/hash.h"

namespace thew::tools {
namespace {

constexpr std::uint64_t kArrayBit = std::uint64_t{1} << 63, kInlineBit = std::uint64_t{1} << 62;
constexpr std::size_t kBootstrap = 88;

Crate::Rep rep(std::uint8_t type, std::uint64_t place) { return std::uint64_t{type} << 48 | place; }

// A block of LZ4 that has no repetitions: the tables are small, and values are never compressed.
// The first byte says that it is one piece.
std::string lz4(const std::string& bytes) {
  std::string block(1, '\0');
  const std::size_t n = bytes.size();
  block += static_cast<char>(std::min<std::size_t>(n, 15) << 4);
  if (n >= 15) {
    block.append((n - 15) / 255, '\xff');
    block += static_cast<char>((n - 15) % 255);
  }
  return block + bytes;
}

void put_block(std::string& bytes, const std::string& plain) {
  const std::string block = lz4(plain);
  put<std::uint64_t>(bytes, block.size());
  bytes += block;
}

std::int32_t most_frequent(std::vector<std::int32_t> values) {
  std::sort(values.begin(), values.end());
  std::int32_t best = 0;
  std::size_t most = 0;
  for (std::size_t i = 0; i < values.size();) {
    std::size_t end = i;
    while (end < values.size() && values[end] == values[i]) ++end;
    if (end - i > most) most = end - i, best = values[i];
    i = end;
  }
  return best;
}

void put_integers(std::string& bytes, const std::vector<std::int32_t>& values) {
  std::vector<std::int32_t> steps;
  std::uint32_t last = 0;
  for (const std::int32_t value : values) {
    steps.push_back(static_cast<std::int32_t>(static_cast<std::uint32_t>(value) - last));
    last = static_cast<std::uint32_t>(value);
  }
  const std::int32_t common = most_frequent(steps);
  std::string plain, numbers;
  put(plain, common);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const std::int32_t step = steps[i];
    unsigned code = 0;
    if (step == common) {
    } else if (step == static_cast<std::int8_t>(step)) {
      code = 1;
      put(numbers, static_cast<std::int8_t>(step));
    } else if (step == static_cast<std::int16_t>(step)) {
      code = 2;
      put(numbers, static_cast<std::int16_t>(step));
    } else {
      code = 3;
      put(numbers, step);
    }
    if (i % 4 == 0) plain += '\0';
    plain.back() =
        static_cast<char>(static_cast<unsigned char>(plain.back()) | code << 2 * (i % 4));
  }
  put_block(bytes, plain + numbers);
}

}  // namespace

Crate::Crate(ExportFile& out) : out_(out), start_(out.size()) {
  out_.append("PXR-USDC" + std::string("\0\x8\0\0\0\0\0\0", 8) +
              std::string(kBootstrap - 16, '\0'));
  number_of(";-)");  // token 0 is no name, for it has no sign
}

std::uint32_t Crate::number_of(const std::string& token) {
  const auto [found, added] =
      token_numbers_.try_emplace(token, static_cast<std::uint32_t>(tokens_.size()));
  if (added) tokens_.push_back(token);
  return found->second;
}

std::uint32_t Crate::string_number(const std::string& text) {
  const std::uint32_t token = number_of(text);
  const auto [found, added] =
      string_numbers_.try_emplace(token, static_cast<std::uint32_t>(strings_.size()));
  if (added) strings_.push_back(token);
  return found->second;
}

void Crate::align() { out_.append(std::string((8 - place() % 8) % 8, '\0')); }

Crate::Rep Crate::inlined(Type type, std::uint32_t value) { return kInlineBit | rep(type, value); }

Crate::Rep Crate::string(const std::string& text) { return inlined(kString, string_number(text)); }

Crate::Rep Crate::number(double value) {
  std::string bytes;
  if (const auto single = static_cast<float>(value); static_cast<double>(single) == value) {
    std::uint32_t bits;
    std::memcpy(&bits, &single, sizeof bits);
    return inlined(kDouble, bits);
  }
  put(bytes, value);
  return this->value(kDouble, bytes);
}

Crate::Rep Crate::number(float value) {
  std::uint32_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  return inlined(kFloat, bits);
}

// A list edit: uint8 which lists follow, then each: uint64 count, uint32 each.
Crate::Rep Crate::prepended(const std::vector<std::string>& tokens) {
  constexpr std::uint8_t kPrepended = 1 << 5;
  std::string bytes;
  put(bytes, kPrepended);
  put<std::uint64_t>(bytes, tokens.size());
  for (const std::string& token : tokens) put(bytes, number_of(token));
  return value(kTokenList, bytes);
}

Crate::Rep Crate::paths(const std::vector<int>& numbers) {
  constexpr std::uint8_t kExplicit = 1 << 0 | 1 << 1;
  std::string bytes;
  put(bytes, kExplicit);
  put<std::uint64_t>(bytes, numbers.size());
  for (const int number : numbers) put(bytes, static_cast<std::uint32_t>(number));
  return value(kPathList, bytes);
}

Crate::Rep Crate::value(std::uint8_t type, std::string_view bytes) {
  const std::string key = static_cast<char>(type) + sim::hash_of(bytes);
  const auto found = kept_.find(key);
  if (found != kept_.end()) return found->second;
  align();
  const Rep result = rep(type, place());
  out_.append(bytes);
  return kept_[key] = result;
}

Crate::Rep Crate::array(std::uint8_t type, std::size_t count, std::string_view bytes) {
  if (count == 0) return kArrayBit | rep(type, 0);
  std::string sized;
  sized.reserve(8 + bytes.size());
  put<std::uint64_t>(sized, count);
  sized += bytes;
  return kArrayBit | value(type, sized);
}

Crate::Rep Crate::token_array(const std::vector<std::string>& texts) {
  std::string bytes;
  for (const std::string& text : texts) put(bytes, number_of(text));
  return array(kToken, texts.size(), bytes);
}

Crate::Rep Crate::tokens(const std::vector<std::string>& texts) {
  std::string bytes;
  put<std::uint64_t>(bytes, texts.size());
  for (const std::string& text : texts) put(bytes, number_of(text));
  return value(kTokenVector, bytes);
}

// Each entry: uint32 string of the key, int64 from here to the value's place.
Crate::Rep Crate::strings(const std::vector<std::pair<std::string, std::string>>& entries) {
  std::string bytes;
  put<std::uint64_t>(bytes, entries.size());
  for (const auto& [key, text] : entries) {
    put(bytes, string_number(key));
    put<std::int64_t>(bytes, 8);
    put(bytes, string(text));
  }
  return value(kDictionary, bytes);
}

// int64 from here to the place of the times, that place, int64 from there to the values, uint64
// count, places of the values.
Crate::Rep Crate::samples(const std::vector<double>& times, const std::vector<Rep>& values) {
  std::string of_times, bytes;
  put<std::uint64_t>(of_times, times.size());
  for (const double time : times) put(of_times, time);
  put<std::int64_t>(bytes, 8);
  put(bytes, value(kDoubleVector, of_times));
  put<std::int64_t>(bytes, 8);
  put<std::uint64_t>(bytes, values.size());
  for (const Rep one : values) put(bytes, one);
  return value(kTimeSamples, bytes);
}

int Crate::add(int parent, const std::string& name, Spec spec, const Fields& fields) {
  const auto token = parent < 0 ? 0 : static_cast<std::int32_t>(number_of(name));
  const bool property = spec == Spec::kAttribute || spec == Spec::kRelationship;
  nodes_.push_back(
      {parent, property ? -token : token, spec, static_cast<std::uint32_t>(field_sets_.size())});
  for (const auto& [field, value] : fields) {
    const std::pair key(number_of(field), value);
    const auto [found, added] =
        field_numbers_.try_emplace(key, static_cast<std::uint32_t>(fields_.size()));
    if (added) fields_.push_back(key);
    field_sets_.push_back(found->second);
  }
  field_sets_.push_back(~std::uint32_t{0});
  return static_cast<int>(nodes_.size()) - 1;
}

std::vector<std::int32_t> Crate::jumps() const {
  const int n = static_cast<int>(nodes_.size());
  std::vector<int> sibling(nodes_.size(), 0), last_child(nodes_.size(), -1);
  for (int i = 1; i < n; ++i) {
    int& last = last_child[nodes_[i].parent];
    if (last >= 0) sibling[last] = i;
    last = i;
  }
  std::vector<std::int32_t> jumps;
  for (int i = 0; i < n; ++i) {
    const bool child = last_child[i] >= 0;
    jumps.push_back(!sibling[i] ? (child ? -1 : -2) : child ? sibling[i] - i : 0);
  }
  return jumps;
}

template <typename Work>
void Crate::section(const char* name, const Work& work) {
  std::string bytes;
  work(bytes);
  align();
  sections_.push_back({name, place(), bytes.size()});
  out_.append(bytes);
}

void Crate::finish() {
  section("TOKENS", [&](std::string& bytes) {
    std::string texts;
    for (const std::string& token : tokens_) texts += token + '\0';
    put<std::uint64_t>(bytes, tokens_.size());
    put<std::uint64_t>(bytes, texts.size());
    put_block(bytes, texts);
  });
  section("STRINGS", [&](std::string& bytes) {
    put<std::uint64_t>(bytes, strings_.size());
    for (const std::uint32_t token : strings_) put(bytes, token);
  });
  section("FIELDS", [&](std::string& bytes) {
    std::vector<std::int32_t> names;
    std::string values;
    for (const auto& [name, value] : fields_) {
      names.push_back(static_cast<std::int32_t>(name));
      put(values, value);
    }
    put<std::uint64_t>(bytes, fields_.size());
    put_integers(bytes, names);
    put_block(bytes, values);
  });
  section("FIELDSETS", [&](std::string& bytes) {
    put<std::uint64_t>(bytes, field_sets_.size());
    put_integers(bytes, {field_sets_.begin(), field_sets_.end()});
  });
  std::vector<std::int32_t> numbers, names, sets, kinds;
  for (const Node& node : nodes_) {
    numbers.push_back(static_cast<std::int32_t>(numbers.size()));
    names.push_back(node.name);
    sets.push_back(static_cast<std::int32_t>(node.fields));
    kinds.push_back(static_cast<std::int32_t>(node.spec));
  }
  section("PATHS", [&](std::string& bytes) {
    put<std::uint64_t>(bytes, nodes_.size());
    put<std::uint64_t>(bytes, nodes_.size());
    for (const auto& list : {numbers, names, jumps()}) put_integers(bytes, list);
  });
  section("SPECS", [&](std::string& bytes) {
    put<std::uint64_t>(bytes, nodes_.size());
    for (const auto& list : {numbers, sets, kinds}) put_integers(bytes, list);
  });
  align();
  std::string contents, where;
  put(where, place());
  put<std::uint64_t>(contents, sections_.size());
  for (const Section& section : sections_) {
    std::string name = section.name;
    name.resize(16);
    contents += name;
    put(contents, section.place);
    put(contents, section.size);
  }
  out_.append(contents);
  out_.patch(start_ + 16, where);
}

}  // namespace thew::tools
