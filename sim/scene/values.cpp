// SPDX-License-Identifier: Apache-2.0
#include "sim/scene/values.h"

#include <algorithm>
#include <cassert>
#include <charconv>
#include <string_view>

#include "rig/text.h"

namespace thew::sim {

namespace fs = std::filesystem;

double number_of(const TomlValue& value, const Range& range) {
  const bool is_number =
      value.type == TomlValue::Type::kInteger || value.type == TomlValue::Type::kReal;
  const double x = value.number;
  const bool above_least = range.above ? x > range.least : x >= range.least;
  if (is_number && above_least && x <= range.most) return x;  // false for NaN
  refuse(value, std::string("give a number ") + (range.above ? "above " : "from ") +
                    number_text(range.least) + (range.above ? ", at most " : " to ") +
                    number_text(range.most));
}

double length_of(const TomlValue& value, const Range& range) {
  if (value.type != TomlValue::Type::kText) return number_of(value, range);
  const std::pair<const char*, double> units[] = {
      {"um", 1e-6}, {"mm", 1e-3}, {"cm", 1e-2}, {"m", 1}};
  TomlValue metres = value;
  metres.type = TomlValue::Type::kReal;
  const char* end = value.text.data() + value.text.size();
  auto [at, error] = std::from_chars(value.text.data(), end, metres.number);
  while (error == std::errc() && at != end && *at == ' ') ++at;
  for (const auto& [unit, size] : units) {
    if (error != std::errc() || std::string_view(at, end) != unit) continue;
    metres.number *= size;
    if (metres.number >= range.least && metres.number <= range.most) return metres.number;
  }
  refuse(value, "give a length from " + number_text(range.least) + " m to " +
                    number_text(range.most) + " m, as \"0.5 mm\" or in metres");
}

int integer_of(const TomlValue& value, const Range& range) {
  if (value.type == TomlValue::Type::kInteger && value.number >= range.least &&
      value.number <= range.most) {
    return static_cast<int>(value.number);
  }
  refuse(value, "give a whole number from " + std::to_string(static_cast<int>(range.least)) +
                    " to " + std::to_string(static_cast<int>(range.most)));
}

bool truth_of(const TomlValue& value) {
  if (value.type != TomlValue::Type::kTruth) refuse(value, "give true or false");
  return value.truth;
}

const std::string& text_of(const TomlValue& value) {
  const auto is_control = [](char c) { return (c >= 0 && c < ' ') || c == 127; };
  if (value.type != TomlValue::Type::kText || value.text.empty() ||
      std::any_of(value.text.begin(), value.text.end(), is_control)) {
    refuse(value, "give a text of one line, in quotes");
  }
  return value.text;
}

const std::string& word_of(const TomlValue& value, const Key& key) {
  std::vector<std::string> words;
  std::string all;
  for (const char* word : key.words) {
    if (!word) break;
    words.emplace_back(word);
    all += (all.empty() ? "\"" : ", \"") + words.back() + "\"";
  }
  if (std::find(words.begin(), words.end(), value.text) != words.end()) return value.text;
  refuse(value, "give one of " + all + did_you_mean(value.text, words));
}

const std::string& name_of(const TomlValue& value) {
  const std::string& name = text_of(value);
  const auto is_plain = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-' || static_cast<unsigned char>(c) >= 0x80;  // UTF-8
  };
  if (name.size() > 100 || !std::all_of(name.begin(), name.end(), is_plain)) {
    refuse(value, "give at most 100 letters, digits, _ and -: files are named after it");
  }
  return name;
}

fs::path file_of(const TomlValue& value, const Folders& folders) {
  const fs::path path = text_of(value);
  if (path.is_absolute()) refuse(value, "give a path relative to the scene's folder");
  std::error_code error;
  fs::path file = fs::weakly_canonical(folders.base / path, error);
  if (error || !is_below(file, folders.root)) {
    refuse(value, "copy it there, or allow another folder",
           ", which lies outside " + folders.root.string());
  }
  if (!fs::is_regular_file(file, error)) {
    refuse(value, "correct the path", ", but " + file.string() + " is no file");
  }
  return file;
}

std::vector<TomlValue>& items_of(TomlValue& value, const std::string& what, std::size_t least,
                                 std::size_t most) {
  const std::size_t count = value.items.size();
  if (value.type != TomlValue::Type::kArray || count < least || count > most) {
    refuse(value, "give " + what);
  }
  return value.items;
}

Vec3 vector_of(TomlValue& value, const Range& range) {
  const std::vector<TomlValue>& items = items_of(value, "three numbers, [x, y, z]", 3, 3);
  return {number_of(items[0], range), number_of(items[1], range), number_of(items[2], range)};
}

Vec3 direction_of(TomlValue& value, const Range& range) {
  const Vec3 direction = vector_of(value, range);
  if (direction.norm() < 1e-9) refuse(value, "give a direction, which is not zero");
  return direction.normalized();
}

Pairs pairs_of(TomlValue& value, const std::string& form, const Key& key) {
  Pairs pairs;
  for (TomlValue& item : items_of(value, "pairs, [" + form + ", ...]", 1, 1000000)) {
    const std::vector<TomlValue>& two = items_of(item, "a pair, " + form, 2, 2);
    pairs.push_back({number_of(two[0], key.range), number_of(two[1], key.second)});
    if (pairs.size() > 1 && pairs.back()[0] <= pairs[pairs.size() - 2][0]) {
      refuse(two[0], "give more than " + number_text(pairs[pairs.size() - 2][0]) +
                         ", which is before it: pairs " + form + " go upwards");
    }
  }
  return pairs;
}

void read(TomlValue& table, const Key& key, double& out) {
  assert(key.type == KeyType::kNumber);
  if (const TomlValue* value = find(table, key)) out = number_of(*value, key.range);
}

void read(TomlValue& table, const Key& key, int& out) {
  assert(key.type == KeyType::kInteger);
  if (const TomlValue* value = find(table, key)) out = integer_of(*value, key.range);
}

void read(TomlValue& table, const Key& key, bool& out) {
  assert(key.type == KeyType::kTruth);
  if (const TomlValue* value = find(table, key)) out = truth_of(*value);
}

void read(TomlValue& table, const Key& key, Vec3& out) {
  assert(key.type == KeyType::kVector);
  if (TomlValue* value = find(table, key)) out = vector_of(*value, key.range);
}

void read(TomlValue& table, const Key& key, std::string& out) {
  assert(key.type == KeyType::kWord);
  if (const TomlValue* value = find(table, key)) out = word_of(*value, key);
}

std::string read_word(TomlValue& table, const Key& key) {
  std::string word = key.words[0];
  read(table, key, word);
  return word;
}

}  // namespace thew::sim
