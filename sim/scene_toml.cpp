// SPDX-License-Identifier: Apache-2.0
#include "sim/scene_toml.h"

// toml++ 3.3 meets some slips, "[1, }" for instance, by an assertion alone: it has to throw, in
// every build.
#undef NDEBUG
#define TOML_ASSERT(condition) ((condition) ? void() : thew::throw_slip())
namespace thew {
struct TomlSlip {};
[[noreturn]] static void throw_slip() { throw TomlSlip(); }
}  // namespace thew
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "rig/text.h"

namespace thew {
namespace {

constexpr std::size_t kFileLimit = std::size_t{4} << 20;  // bytes
constexpr int kKeyParts = 32, kDepth = 64;

using PlaceOf = std::function<Place(const toml::source_region&)>;

[[noreturn]] void fail(const Place& place, const std::string& what) {
  std::string message = place + ": " + what;
  for (char& c : message) {  // what is quoted from the file must not command a terminal
    const auto byte = static_cast<unsigned char>(c);
    if (byte < ' ' || byte == 127) c = '?';
  }
  throw Error(ExitCode::kUsage, message);
}

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

// toml++ bounds the nesting of values, but not the parts of a dotted key, each of which is a level
// of its tree: a long one would end in its recursive destructor.
void check_dotted_keys(std::string_view text, const Place& place) {
  int parts = 0;
  char quote = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\n') {
      parts = 0;
      quote = 0;
    } else if (quote) {
      if (c == '\\' && quote == '"' && i + 1 < text.size() && text[i + 1] != '\n')
        ++i;
      else if (c == quote)
        quote = 0;
    } else if (text.substr(i, 3) == R"(""")" || text.substr(i, 3) == "'''") {
      i += 2;
    } else if (c == '"' || c == '\'') {
      quote = c;
    } else if (c == '#') {
      i = std::min(text.find('\n', i), text.size()) - 1;
    } else if (c == '.') {
      if (++parts < kKeyParts) continue;
      const auto line = std::count(text.begin(), text.begin() + static_cast<long>(i), '\n') + 1;
      fail(place + ":" + std::to_string(line),
           "a key has more than " + std::to_string(kKeyParts) + " parts; no key of a scene has");
    } else if (std::string_view(",[]{}=").find(c) != std::string_view::npos) {
      parts = 0;
    }
  }
}

// toml::parse, with a place for the slips that have none: the first line at whose end they show.
toml::table parse(std::string_view text, const Place& place) {
  check_dotted_keys(text, place);
  try {
    return toml::parse(text);
  } catch (const TomlSlip&) {
  }
  std::vector<std::size_t> ends;
  for (std::size_t end = text.find('\n'); end != text.npos; end = text.find('\n', end + 1)) {
    ends.push_back(end);
  }
  const auto is_sound = [&](std::size_t end) {
    try {
      static_cast<void>(toml::parse(text.substr(0, end)));
    } catch (const TomlSlip&) {
      return false;
    } catch (const toml::parse_error&) {  // cut off
    }
    return true;
  };
  const auto line = std::partition_point(ends.begin(), ends.end(), is_sound) - ends.begin() + 1;
  fail(place + ":" + std::to_string(line),
       "a value is missing, or a bracket does not match; correct the TOML there");
}

// Names of an item within its parent, as --set would say them.
std::string item_name(const std::string& parent, const std::string& key) {
  return parent.empty() ? key : parent + "." + key;
}

std::string array_item_name(const std::string& parent, std::size_t index, const toml::node& item) {
  const toml::table* table = item.as_table();
  const auto name = table ? (*table)["name"].value<std::string>() : std::nullopt;
  return item_name(parent, name ? *name : std::to_string(index));
}

TomlValue convert(const toml::node& node, const std::string& name, const Place& place,
                  const PlaceOf& place_of, int depth) {
  using Type = TomlValue::Type;
  if (depth > kDepth) fail(place, "tables and arrays are nested too deep; no scene needs that");
  TomlValue value;
  value.place = place;
  value.name = name;
  if (const toml::table* table = node.as_table()) {
    std::vector<std::pair<const toml::key*, const toml::node*>> entries;
    for (const auto& [key, item] : *table) entries.push_back({&key, &item});
    std::stable_sort(entries.begin(), entries.end(), [](const auto& a, const auto& b) {
      return a.first->source().begin < b.first->source().begin;  // toml++ sorts by name
    });
    for (const auto& [key, item] : entries) {
      value.keys.emplace_back(key->str());
      value.items.push_back(convert(*item, item_name(name, value.keys.back()),
                                    place_of(key->source()), place_of, depth + 1));
    }
  } else if (const toml::array* array = node.as_array()) {
    value.type = Type::kArray;
    for (const toml::node& item : *array) {
      value.items.push_back(convert(item, array_item_name(name, value.items.size(), item),
                                    place_of(item.source()), place_of, depth + 1));
    }
  } else if (const auto* truth = node.as_boolean()) {
    value.type = Type::kTruth;
    value.truth = truth->get();
  } else if (const auto* integer = node.as_integer()) {
    value.type = Type::kInteger;
    value.number = static_cast<double>(integer->get());
  } else if (const auto* real = node.as_floating_point()) {
    value.type = Type::kReal;
    value.number = real->get();
  } else if (const auto* text = node.as_string()) {
    value.type = Type::kText;
    value.text = text->get();
  } else {
    value.type = Type::kDate;
  }
  return value;
}

std::string describe(const TomlValue& value) {
  switch (value.type) {
    case TomlValue::Type::kTruth:
      return value.truth ? "true" : "false";
    case TomlValue::Type::kInteger:
    case TomlValue::Type::kReal:
      return number_text(value.number);
    case TomlValue::Type::kText:
      return "\"" + (value.text.size() > 60 ? value.text.substr(0, 57) + "..." : value.text) + "\"";
    case TomlValue::Type::kDate:
      return "a date";
    case TomlValue::Type::kArray:
      return "an array of " + std::to_string(value.items.size());
    default:
      return "a table";
  }
}

std::string title(const TomlValue& table) {
  return table.name.empty() ? "the scene" : "[" + table.name + "]";
}

std::string suggestion(const std::string& word, const std::vector<std::string>& names) {
  std::string near = did_you_mean(word, names), all;
  if (!near.empty()) return near;
  for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
  return all.empty() ? "" : "; there are " + all;
}

TomlValue* held(TomlValue& table, const std::string& key) {
  const auto at = std::find(table.keys.begin(), table.keys.end(), key);
  return at == table.keys.end() ? nullptr : &table.items[at - table.keys.begin()];
}

TomlValue parse_setting(const std::string& text, const std::string& path, const Place& place) {
  const auto same_place = [&](const toml::source_region&) { return place; };
  TomlValue value;
  try {
    const toml::table parsed = parse("value = " + text, place);
    const toml::node* node = parsed.get("value");
    if (node && parsed.size() == 1) return convert(*node, path, place, same_place, 0);
  } catch (const toml::parse_error& error) {
    if (text.empty() || std::string_view("\"'[{").find(text[0]) != std::string_view::npos) {
      fail(place, "\"" + text + "\" is no TOML value: " + std::string(error.description()) +
                      "; quote it for the shell");
    }
  }
  value.type = TomlValue::Type::kText;  // a bare word
  value.place = place;
  value.name = path;
  value.text = text;
  return value;
}

TomlValue& step_into(TomlValue& at, const std::string& word, const Place& place);

// The item of an array that `word` names; where it is a key of an item, what that key holds.
TomlValue& step_into_array(TomlValue& array, const std::string& word, const Place& place) {
  std::vector<std::string> names;
  std::vector<TomlValue*> tables, holders;
  for (TomlValue& item : array.items) {
    if (item.type != TomlValue::Type::kTable) continue;
    tables.push_back(&item);
    if (held(item, word)) holders.push_back(&item);
    const TomlValue* name = held(item, "name");
    if (!name) continue;
    if (name->text == word) return item;
    names.push_back(name->text);
  }
  const auto index = parse_number(word);
  if (index && *index >= 0.0 && *index < static_cast<double>(array.items.size()) &&
      *index == std::floor(*index)) {
    return array.items[static_cast<std::size_t>(*index)];
  }
  if (tables.empty() || !names.empty()) {
    fail(place, array.name + " has no \"" + word + "\"" + suggestion(word, names) +
                    "; name one of them, or its index from 0");
  }
  if (holders.size() > 1) {
    fail(place, std::to_string(holders.size()) + " of " + array.name + " have the key \"" + word +
                    "\"; put the index from 0 before it");
  }
  return step_into(holders.empty() ? *tables.back() : *holders[0], word, place);
}

// What `word` names within `at`; a table gets a new key where it lacks one.
TomlValue& step_into(TomlValue& at, const std::string& word, const Place& place) {
  if (at.type == TomlValue::Type::kArray) return step_into_array(at, word, place);
  if (at.type != TomlValue::Type::kTable) {
    fail(place, at.name + " is " + describe(at) + ", which has no keys; set it as a whole");
  }
  if (TomlValue* value = held(at, word)) return *value;
  at.keys.push_back(word);
  TomlValue& value = at.items.emplace_back();
  value.place = place;
  value.name = item_name(at.name, word);
  return value;
}

}  // namespace

void refuse(const TomlValue& value, const std::string& next, const std::string& why) {
  fail(value.place, value.name + " is " + describe(value) + why + "; " + next);
}

TomlValue read_toml(const std::filesystem::path& file) {
  const std::string place = file.string();
  std::string text;
  try {
    text = read_whole(file, kFileLimit);
  } catch (const Error& error) {
    throw Error(ExitCode::kUsage, error.what());
  }
  const auto place_of = [&](const toml::source_region& source) {
    return place + ":" + std::to_string(source.begin.line);
  };
  try {
    return convert(parse(text, place), "", place, place_of, 0);
  } catch (const toml::parse_error& error) {
    const auto& at = error.source().begin;
    fail(place_of(error.source()) + ":" + std::to_string(at.column),
         std::string(error.description()) + "; correct the TOML there");
  }
}

void override_toml(TomlValue& root, const std::string& setting) {
  const std::size_t equals = setting.find('=');
  if (equals == setting.npos || equals == 0) {
    fail("--set " + setting, "is not KEY=VALUE; write for instance --set solver.substeps=8");
  }
  std::string path = setting.substr(0, equals);
  while (!path.empty() && is_blank(path.back())) path.pop_back();
  const Place place = "--set " + path;
  if (std::count(path.begin(), path.end(), '.') >= kKeyParts) {
    fail(place.substr(0, 60), "the key has more than " + std::to_string(kKeyParts) + " parts");
  }
  std::size_t start = equals + 1;
  while (start < setting.size() && is_blank(setting[start])) ++start;
  TomlValue value = parse_setting(setting.substr(start), path, place);

  TomlValue* at = &root;
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find('.', begin), path.size());
    at = &step_into(*at, path.substr(begin, end - begin), place);
    begin = end + 1;
  }
  value.name = at->name;
  *at = std::move(value);
}

void refuse_unknown_keys(const TomlValue& root) {
  for (std::size_t i = 0; i < root.items.size(); ++i) {
    const TomlValue& item = root.items[i];
    if (root.type == TomlValue::Type::kTable && !item.read) {
      fail(item.place, "unknown key \"" + root.keys[i] + "\" in " + title(root) +
                           suggestion(root.keys[i], root.known));
    }
    refuse_unknown_keys(item);
  }
}

TomlValue* find(TomlValue& table, const std::string& key) {
  if (table.type != TomlValue::Type::kTable) refuse(table, "give a table, { " + key + " = ... }");
  table.known.push_back(key);
  TomlValue* value = held(table, key);
  if (value) value->read = true;
  return value;
}

TomlValue& require(TomlValue& table, const std::string& key) {
  if (TomlValue* value = find(table, key)) return *value;
  const std::string near = nearest_name(key, table.keys);
  fail(table.place, title(table) + " lacks the key \"" + key + "\"" +
                        (near.empty() ? "; add it" : "; is \"" + near + "\" meant to be it?"));
}

std::pair<std::string, TomlValue*> require_one(TomlValue& table,
                                               const std::vector<std::string>& keys) {
  std::pair<std::string, TomlValue*> one = {"", nullptr};
  std::string all;
  for (const std::string& key : keys) {
    all += (all.empty() ? "\"" : ", \"") + key + "\"";
    TomlValue* value = find(table, key);
    if (value && one.second) {
      fail(value->place,
           title(table) + " has both \"" + one.first + "\" and \"" + key + "\"; keep one of them");
    }
    if (value) one = {key, value};
  }
  if (!one.second) fail(table.place, title(table) + " has none of " + all + "; give one of them");
  return one;
}

std::vector<TomlValue*> tables_of(TomlValue& parent, const std::string& key) {
  TomlValue* value = find(parent, key);
  if (!value) return {};
  if (value->type == TomlValue::Type::kTable) return {value};
  std::vector<TomlValue*> tables;
  const std::string wanted = "give tables, [[" + value->name + "]]";
  if (value->type != TomlValue::Type::kArray) refuse(*value, wanted);
  for (TomlValue& item : value->items) {
    if (item.type != TomlValue::Type::kTable) refuse(item, wanted);
    tables.push_back(&item);
  }
  return tables;
}

TomlValue& entries_of(TomlValue& table) {
  if (table.type != TomlValue::Type::kTable) refuse(table, "give a table, { NAME = ... }");
  for (TomlValue& item : table.items) item.read = true;
  return table;
}

}  // namespace thew
