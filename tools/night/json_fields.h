// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace thew::tools {

/// A JSON file that a kill or a hand may have spoilt. What is not as it should be is Error(kInput)
/// with its place in the file, "/bounds/0/limit", and the next move.
struct JsonFile {
  std::filesystem::path file;
  std::string next;  ///< move, where it is spoilt
  nlohmann::json root;
};
JsonFile read_json_file(const std::filesystem::path& file, const std::string& next);

/// A value of such a file, or that it is not there: every reader then has what it is given for
/// that.
class JsonField {
 public:
  explicit JsonField(const JsonFile& file) : file_(&file), value_(&file.root) {}

  /// A member of an object.
  JsonField operator[](const char* key) const;
  std::vector<JsonField> items() const;
  bool is_there() const { return value_ != nullptr; }
  std::string text() const;
  double number() const;
  int integer() const;
  std::vector<int> integers() const;
  /// The same, and Error where it is not there.
  const JsonField& required() const;
  /// Throws that the value is wrong: "not as long as its frames".
  [[noreturn]] void refuse(const char* what) const;

 private:
  JsonField(const JsonFile& file, const nlohmann::json* value, std::string place)
      : file_(&file), value_(value), place_(std::move(place)) {}

  const JsonFile* file_;
  const nlohmann::json* value_;
  std::string place_;
};

}  // namespace thew::tools
