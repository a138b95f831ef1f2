// SPDX-License-Identifier: Apache-2.0
#include "sim/cache/cache_parts.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
#include <sstream>

#include "rig/import/json_number.h"
#include "sim/cache/durable_file.h"
#include "sim/cache/hash.h"

namespace thew::sim {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr char kMagic[] = "thewpart";
constexpr std::uint64_t kPartsVersion = 7;
constexpr std::size_t kMaxTextBytes = std::size_t{1} << 28;  // of bake.json and manifest.jsonl
static_assert(sizeof(Vec3) == 3 * sizeof(double) && sizeof(double) == sizeof(std::uint64_t));

template <typename T>
void put(std::string& bytes, const T* values, std::size_t count) {
  if (count > 0) bytes.append(reinterpret_cast<const char*>(values), count * sizeof(T));
}

void put_number(std::string& bytes, std::uint64_t value) { put(bytes, &value, 1); }

// A run repeats its number so often at most, so that the bytes of a part limit what it unpacks to.
constexpr std::size_t kMostRepeats = 1024;
constexpr std::size_t kLeastRepeats = 4;  // fewer cost more than they save

std::size_t equal_from(const std::vector<double>& numbers, std::size_t first) {
  std::size_t end = first + 1;
  const std::size_t last = std::min(numbers.size(), first + kMostRepeats);
  while (end < last && std::memcmp(&numbers[end], &numbers[first], sizeof(double)) == 0) ++end;
  return end - first;
}

void put_runs(std::string& bytes, const std::vector<double>& numbers) {
  for (std::size_t first = 0; first < numbers.size();) {
    std::size_t end = first, repeats = 0;
    while (end < numbers.size() && (repeats = equal_from(numbers, end)) < kLeastRepeats) {
      end += repeats;
      repeats = 0;
    }
    put_number(bytes, end - first);
    put_number(bytes, repeats);
    put(bytes, &numbers[first], end - first + (repeats > 0 ? 1 : 0));
    first = end + repeats;
  }
}

/// Reads numbers from the front of a part. False where too few are left.
struct PartReader {
  std::string_view rest;

  template <typename T>
  bool read(T* values, std::size_t count) {
    if (count > rest.size() / sizeof(T)) return false;
    if (count > 0) std::memcpy(static_cast<void*>(values), rest.data(), count * sizeof(T));
    rest.remove_prefix(count * sizeof(T));
    return true;
  }
  bool read_equal(std::uint64_t expected) {
    std::uint64_t value = 0;
    return read(&value, 1) && value == expected;
  }
  /// `count` numbers as put_runs() wrote them.
  bool read_runs(std::vector<double>& numbers, std::size_t count) {
    // Before memory is allocated for them.
    if (count / kMostRepeats > rest.size() / sizeof(double)) return false;
    numbers.clear();
    numbers.reserve(count);
    while (numbers.size() < count) {
      std::uint64_t single = 0, repeats = 0;
      double repeated = 0.0;
      const std::size_t filled = numbers.size();
      if (!read(&single, 1) || !read(&repeats, 1) || single > count - filled ||
          repeats > std::min(kMostRepeats, count - filled - single) || single + repeats == 0) {
        return false;
      }
      numbers.resize(filled + single);
      if (!read(numbers.data() + filled, single)) return false;
      if (repeats > 0 && !read(&repeated, 1)) return false;
      numbers.insert(numbers.end(), repeats, repeated);
    }
    return true;
  }
};

bool decode_part(std::string_view bytes, const Part& part, const BakeInfo& info, bool with_state,
                 BakeFrame& frame) {
  PartReader reader{bytes};
  std::uint64_t magic = 0;
  std::memcpy(&magic, kMagic, sizeof magic);
  frame.frame = part.frame;
  std::uint64_t states = 0;
  if (!reader.read_equal(magic) || !reader.read_equal(kPartsVersion) ||
      !reader.read_equal(static_cast<std::uint64_t>(std::int64_t{part.frame})) ||
      !reader.read_equal(info.meshes.size()) || !reader.read_equal(info.character.rest.size()) ||
      !reader.read_equal(info.metric_names.size()) || !reader.read(&states, 1)) {
    return false;
  }
  for (const BakeMesh& mesh : info.meshes) {
    if (!reader.read_equal(mesh.rest.vertices.size())) return false;
  }
  for (const BakeMesh& mesh : info.meshes) {
    if (!reader.read_equal(mesh.line)) return false;
  }
  for (const BakeMesh& mesh : info.meshes) {
    auto& positions = frame.positions.emplace_back(mesh.rest.vertices.size());
    if (!reader.read(positions.data(), positions.size())) return false;
  }
  for (const BakeMesh& mesh : info.meshes) {
    auto& line = frame.lines.emplace_back(mesh.line);
    if (!reader.read(line.data(), line.size())) return false;
  }
  frame.bodies.resize(info.character.rest.size());
  if (!reader.read(frame.bodies.data(), frame.bodies.size())) return false;
  frame.metrics.resize(info.metric_names.size());
  if (!reader.read(frame.metrics.data(), frame.metrics.size())) return false;
  return !with_state || (reader.read_runs(frame.state, states) && reader.rest.empty());
}

std::string mesh_hash(const BakeMesh& mesh) {
  Hash hash;
  hash.add(mesh.rest.vertices.data(), mesh.rest.vertices.size() * sizeof(Vec3));
  hash.add(mesh.rest.triangles.data(), mesh.rest.triangles.size() * sizeof(Triangle));
  hash.add(mesh.weights.data(), mesh.weights.size() * sizeof(double));
  return hash.hex();
}

json scene_as_json(const BakeInfo& info) {
  json meshes = json::object();
  for (const BakeMesh& mesh : info.meshes) meshes[mesh.name] = mesh_hash(mesh);
  return {{"version", kPartsVersion}, {"scene", info.scene_name}, {"scene_hash", info.scene_hash},
          {"fps", info.fps},          {"meshes", meshes},         {"metrics", info.metric_names}};
}

// Written without the JSON library's containers: their destructors allocate, and where memory runs
// out in one the process ends.
std::string quoted(const std::string& text) {
  return json(text).dump(-1, ' ', false, json::error_handler_t::replace);
}
using Members = std::vector<std::pair<std::string, std::string>>;
std::string object_of(const Members& members, const std::string& gap) {
  std::string text;
  for (const auto& [name, value] : members) {
    text += (text.empty() ? "{" : "," + gap) + quoted(name) + ":" + value;
  }
  return text.empty() ? "{}" : text + "}";
}

json part_hashes(const BakeInfo& info) {
  json parts = json::object();
  for (const auto& [name, hash] : info.part_hashes) parts[name] = hash;
  return parts;
}

// The first line in which two texts differ, for a message. It may be a line that the solver does
// not read.
std::string text_difference(const std::string& was, const std::string& is) {
  std::istringstream before(was), after(is);
  std::string old_line, new_line;
  for (int row = 1;; ++row) {
    const bool more_before = static_cast<bool>(std::getline(before, old_line));
    const bool more_after = static_cast<bool>(std::getline(after, new_line));
    if (!more_before && !more_after) return "";
    if (!more_before) old_line.clear();
    if (!more_after) new_line.clear();
    if (old_line == new_line && more_before == more_after) continue;
    return "line " + std::to_string(row) + " of the scene was \"" + old_line + "\" and is \"" +
           new_line + "\"";
  }
}

// The names whose hashes differ, for a message; each is put between `before` and `after`.
std::string hash_differences(const json& was, const json& is, const char* before = "",
                             const char* after = "") {
  std::string names;
  const auto add = [&](const std::string& name, const char* what) {
    names += (names.empty() ? "" : ", ") + (before + name + after + " " + what);
  };
  for (const auto& [name, hash] : is.items()) {
    if (was.value(name, json()) != hash) add(name, was.contains(name) ? "has changed" : "is new");
  }
  for (const auto& [name, hash] : was.items()) {
    if (!is.contains(name)) add(name, "is gone");
  }
  return names;
}

// Reads up to the first line that is incomplete or names no part.
std::vector<Part> read_manifest(const fs::path& folder) {
  std::vector<Part> parts;
  const fs::path manifest = folder / kManifest;
  std::error_code error;
  if (!fs::exists(manifest, error)) return parts;
  std::istringstream lines(read_whole_file(manifest, kMaxTextBytes));
  try {
    for (std::string line; std::getline(lines, line);) {
      const json read = json::parse(line);
      const auto frame = whole_number(read.at("frame")), bytes = whole_number(read.at("bytes"));
      if (!frame || !bytes || *bytes < 0) break;
      const Part part{static_cast<int>(*frame), read.at("file"), static_cast<std::size_t>(*bytes),
                      read.at("hash")};
      // Our own name only: a manifest must not lead out of its folder.
      if (part.file != part_file(part.frame)) break;
      parts.push_back(part);
    }
  } catch (const json::exception&) {  // a torn line
  }
  return parts;
}

// Whether a bake, of this version or an earlier one, gives such a name in its folder of parts.
bool is_of_parts(std::string name) {
  if (name.starts_with(".thew-")) return true;
  if (name.ends_with(".tmp")) name.resize(name.size() - 4);
  if (name == "bake.json" || name == kManifest || name == "bake.h5") return true;
  constexpr std::string_view kBegin = "frame.", kEnd = ".part";
  if (!name.starts_with(kBegin) || !name.ends_with(kEnd)) return false;
  const std::string number = name.substr(kBegin.size(), name.size() - kBegin.size() - kEnd.size());
  int frame = 0;
  const char* last = number.data() + number.size();
  const auto [end, error] = std::from_chars(number.data(), last, frame);
  return error == std::errc() && end == last && name == part_file(frame);
}

}  // namespace

std::string part_file(int frame) {
  char text[32];
  std::snprintf(text, sizeof text, "frame.%04d.part", frame);
  return text;
}

std::string manifest_line(const Part& part) {
  return object_of({{"frame", std::to_string(part.frame)},
                    {"file", quoted(part.file)},
                    {"bytes", std::to_string(part.bytes)},
                    {"hash", quoted(part.hash)}},
                   "");
}

void encode_part(const BakeFrame& frame, std::string& bytes) {
  bytes = kMagic;
  put_number(bytes, kPartsVersion);
  put_number(bytes, static_cast<std::uint64_t>(std::int64_t{frame.frame}));
  put_number(bytes, frame.positions.size());
  put_number(bytes, frame.bodies.size());
  put_number(bytes, frame.metrics.size());
  put_number(bytes, frame.state.size());
  const std::size_t meshes = frame.positions.size();
  for (const auto& positions : frame.positions) put_number(bytes, positions.size());
  for (std::size_t m = 0; m < meshes; ++m) put_number(bytes, line_of(frame, m).size());
  for (const auto& positions : frame.positions) put(bytes, positions.data(), positions.size());
  for (std::size_t m = 0; m < meshes; ++m) {
    put(bytes, line_of(frame, m).data(), line_of(frame, m).size());
  }
  put(bytes, frame.bodies.data(), frame.bodies.size());
  put(bytes, frame.metrics.data(), frame.metrics.size());
  put_runs(bytes, frame.state);
}

BakeFrame read_part(const fs::path& folder, const Part& part, const BakeInfo& info,
                    bool with_state) {
  const fs::path file = folder / part.file;
  std::string why;
  BakeFrame frame;
  try {
    const std::string bytes = read_whole_file(file, part.bytes);
    if (bytes.size() == part.bytes && hash_of(bytes) == part.hash &&
        decode_part(bytes, part, info, with_state, frame)) {
      return frame;
    }
    why = "its bytes are not those that were written";
  } catch (const Error& error) {
    why = error.what();
  }
  throw Error(ErrorCode::kOutput, file.string() + ": " + why + "; check the disk and run again");
}

std::string describe_scene(const BakeInfo& info) {
  Members meshes, parts;
  for (const BakeMesh& mesh : info.meshes) meshes.emplace_back(mesh.name, quoted(mesh_hash(mesh)));
  for (const auto& [name, hash] : info.part_hashes) parts.emplace_back(name, quoted(hash));
  std::string metrics;
  for (const std::string& name : info.metric_names) {
    metrics += (metrics.empty() ? "" : ", ") + quoted(name);
  }
  return object_of({{"version", std::to_string(kPartsVersion)},
                    {"scene", quoted(info.scene_name)},
                    {"scene_hash", quoted(info.scene_hash)},
                    {"fps", json(info.fps).dump()},
                    {"frames", std::to_string(info.frames.size())},
                    {"command", quoted(info.command)},
                    {"directory", quoted(info.directory)},
                    {"meshes", object_of(meshes, "\n  ")},
                    {"metrics", "[" + metrics + "]"},
                    {"parts", object_of(parts, "\n  ")},
                    {"text", quoted(info.scene_text)}},
                   "\n ") +
         "\n";
}

bool is_scene_of(const fs::path& folder, const BakeInfo& info) {
  const fs::path file = folder / "bake.json";
  std::error_code error;
  if (!fs::exists(file, error)) return false;
  const json there = json::parse(read_whole_file(file, kMaxTextBytes), nullptr, false);
  if (!there.is_object()) return false;  // it is damaged, so no part can be trusted
  const json here = scene_as_json(info);
  std::string differences;
  const auto add = [&](const std::string& what) {
    if (!what.empty()) differences += (differences.empty() ? "" : ", ") + what;
  };
  for (const auto& [key, value] : here.items()) {
    const json other = there.value(key, json());
    if (other == value) continue;
    if (key == "meshes" && other.is_object()) {
      add(hash_differences(other, value, "mesh \"", "\""));
    } else {
      add(key +
          (value.is_structured() ? " differ" : " was " + other.dump() + " and is " + value.dump()));
    }
  }
  if (differences.empty()) return true;
  // What the meshes do not show: an override, or a file that the scene names.
  const json parts = there.value("parts", json()), text = there.value("text", json());
  if (parts.is_object()) add(hash_differences(parts, part_hashes(info)));
  if (text.is_string()) add(text_difference(text.get<std::string>(), info.scene_text));
  throw Error(ErrorCode::kUsage, file.string() + ": these frames are of another scene: " +
                                     differences + "; replace them, or bake into another folder");
}

std::map<int, PlacedPart> parts_of_chunks(const std::vector<fs::path>& chunks,
                                          const BakeInfo& info) {
  std::map<int, PlacedPart> places;
  for (const fs::path& chunk : chunks) {
    const fs::path folder = chunk / "bake.parts";
    if (!is_scene_of(folder, info)) {
      throw Error(ErrorCode::kInput, folder.string() +
                                         ": does not say of what scene its frames are; bake this "
                                         "chunk anew");
    }
    for (const Part& part : read_manifest(folder)) {
      const auto [place, is_new] = places.emplace(part.frame, PlacedPart{folder, part});
      if (is_new || place->second.part.hash == part.hash) continue;
      throw Error(ErrorCode::kInput, "frame " + std::to_string(part.frame) +
                                         " is not the same in " + place->second.folder.string() +
                                         " and " + folder.string() +
                                         "; bake both again by one version of thew");
    }
  }
  std::string missing;
  for (const int frame : info.frames) {
    if (!places.contains(frame)) missing += (missing.empty() ? "" : ",") + std::to_string(frame);
  }
  if (missing.empty()) return places;
  throw Error(ErrorCode::kInput, "frames that are in none of the chunks: " + missing +
                                     "; bake them as one more chunk");
}

std::vector<Part> good_parts(const fs::path& folder, const BakeInfo& info) {
  std::vector<Part> parts = read_manifest(folder);
  std::size_t good = 0;
  try {
    for (; good < std::min(parts.size(), info.frames.size()); ++good) {
      if (parts[good].frame != info.frames[good]) break;
      read_part(folder, parts[good], info);
    }
  } catch (const Error&) {  // a part that is not whole
  }
  parts.resize(good);
  return parts;
}

void remove_parts(const fs::path& folder, const std::set<std::string>& kept) {
  struct stat about {};
  if (::lstat(folder.c_str(), &about) != 0 || !S_ISDIR(about.st_mode)) return;
  const auto is_ours = [&](const fs::path& path) {
    const std::string name = path.filename().string();
    return is_of_parts(name) && !kept.contains(name) && ::lstat(path.c_str(), &about) == 0 &&
           S_ISREG(about.st_mode);
  };
  // The manifest goes first, so that it never lists a part that is not there, also after a kill.
  if (const fs::path list = folder / kManifest; is_ours(list)) remove_file(list);
  bool empty = true;
  for (const fs::path& path : paths_in(folder)) {
    const bool ours = is_ours(path);
    if (ours) remove_file(path);
    empty = empty && ours;
  }
  if (!empty) return;
  if (::rmdir(folder.c_str()) != 0) fail_to_write(folder, "remove", errno);
  sync_folder(folder.parent_path());
}

std::vector<int> listed_frames(const fs::path& folder) {
  std::vector<int> frames;
  for (const Part& part : read_manifest(folder)) frames.push_back(part.frame);
  return frames;
}

}  // namespace thew::sim
