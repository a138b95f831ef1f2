// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "sim/scene/keys.h"
#include "sim/scene/scene.h"

namespace thew::sim {

/// A value of a TOML file, with its location, and which of it was asked for: what nobody asks for
/// is a key that does not exist. All errors are Error(kUsage): "location: name is ...; give ...".
struct TomlValue {
  enum class Type { kTruth, kInteger, kReal, kText, kDate, kArray, kTable };
  Type type = Type::kTable;
  Location location;  ///< "arm.toml:12", or "--set solver.substeps"
  std::string name;   ///< "muscle.biceps_long.path.0", as --set would say it
  bool truth = false;
  double number = 0.0;  ///< integers as well
  std::string text;
  std::vector<std::string> keys;   ///< of a table, in the file's order; items[i] belongs to keys[i]
  std::vector<TomlValue> items;    ///< of an array or a table
  bool read = false;               ///< somebody asked for it
  std::string renamed;             ///< it has an old name: what its key is called now
  std::vector<std::string> known;  ///< all keys that somebody asked this table for
};

/// Reads a file of at most 4 MiB.
TomlValue read_toml(const std::filesystem::path& file);
/// `setting` is "key.path=value": a TOML value, or a bare word for a string. Tables in an array are
/// named by their `name`, by their index from 0, or, where they have no name, by a key they hold.
void override_toml(TomlValue& root, const std::string& setting);
/// Throws at the first key, in the file's order, that nobody asked for.
void refuse_unknown_keys(const TomlValue& root);

/// A warning for each value that was read by an old name, in the file's order.
void list_old_names(const TomlValue& root, std::vector<std::string>& warnings);

/// "location: name is <the value><why>; <next>"
[[noreturn]] void refuse(const TomlValue& value, const std::string& next,
                         const std::string& why = "");

/// The value of `key` in a table, by its old name too; null where it is absent.
TomlValue* find(TomlValue& table, const Key& key);
/// The same of a key that the table has to have.
TomlValue& require(TomlValue& table, const Key& key);
/// The one of `keys` that the table has; more or fewer are refused.
std::pair<std::string, TomlValue*> require_one(TomlValue& table,
                                               const std::vector<const Key*>& keys);
/// The tables of [[key]]; a plain [key] is one.
std::vector<TomlValue*> tables_of(TomlValue& parent, const Key& key);
/// All of a table whose keys are names of the user's, marked as asked for.
TomlValue& entries_of(TomlValue& table);

}  // namespace thew::sim
