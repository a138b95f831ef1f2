// SPDX-License-Identifier: Apache-2.0
#include "tools/night/json_fields.h"

#include "rig/text.h"
#include "rig/types.h"
#include "sim/cache/file_io.h"

namespace thew::tools {

using nlohmann::json;

JsonFile read_json_file(const std::filesystem::path& file, const std::string& next) {
  constexpr std::size_t kLargest = std::size_t{1} << 28;  // bytes
  JsonFile read{file, next, {}};
  const std::string text = sim::read_whole_file(file, kLargest);
  try {
    read.root = json::parse(text);
  } catch (const json::exception&) {  // its message says bytes, which help nobody
    throw Error(ErrorCode::kInput, file.string() + ": is no JSON, or not all of it; " + next);
  }
  return read;
}

void JsonField::refuse(const char* what) const {
  throw Error(ErrorCode::kInput, file_->file.string() + ": " +
                                     (place_.empty() ? "the document" : rig::printable(place_)) +
                                     " is " + what + "; " + file_->next);
}

JsonField JsonField::operator[](const char* key) const {
  std::string place = place_ + "/" + key;
  if (!value_) return {*file_, nullptr, std::move(place)};
  if (!value_->is_object()) refuse("no object");
  const auto found = value_->find(key);
  return {*file_, found == value_->end() ? nullptr : &*found, std::move(place)};
}

std::vector<JsonField> JsonField::items() const {
  std::vector<JsonField> all;
  if (!value_) return all;
  if (!value_->is_array()) refuse("no list");
  for (const json& one : *value_) {
    all.push_back({*file_, &one, place_ + "/" + std::to_string(all.size())});
  }
  return all;
}

std::string JsonField::text() const {
  if (!value_) return "";
  if (!value_->is_string()) refuse("no text");
  return value_->get<std::string>();
}

double JsonField::number() const {
  if (!value_) return 0.0;
  if (!value_->is_number()) refuse("no number");
  return value_->get<double>();
}

constexpr double kMost = 1e9;  // of frames and the like

int JsonField::integer() const {
  const double value = number();
  if (!(std::abs(value) <= kMost)) refuse("no whole number");
  return static_cast<int>(value);
}

std::vector<int> JsonField::integers() const {
  std::vector<int> all;
  if (!value_) return all;
  if (!value_->is_array()) refuse("no list");
  all.reserve(value_->size());
  for (const json& one : *value_) {
    const double value = one.is_number() ? one.get<double>() : 2.0 * kMost;
    if (!(std::abs(value) <= kMost)) refuse("no list of whole numbers");
    all.push_back(static_cast<int>(value));
  }
  return all;
}

const JsonField& JsonField::required() const {
  if (!value_) refuse("not there");
  return *this;
}

}  // namespace thew::tools
