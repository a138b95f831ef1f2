// SPDX-License-Identifier: Apache-2.0
#include "sim/cache/own_files.h"

#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <charconv>
#include <nlohmann/json.hpp>
#include <set>

#include "rig/types.h"
#include "sim/cache/file_io.h"
#include "sim/cache/hash.h"

namespace thew::sim {
namespace {

namespace fs = std::filesystem;

constexpr const char* kList = ".thew.jsonl";
constexpr std::size_t kMaxListBytes = std::size_t{1} << 28;  // bytes
constexpr const char* kTemporary = ".thew-";

// Without the JSON library's containers: their destructors allocate, and where memory runs out in
// one the process ends.
std::string quoted(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string list_of(const fs::path& folder) {
  const fs::path file = folder / kList;
  struct stat about {};
  if (::lstat(file.c_str(), &about) != 0) return "";
  check_replaceable(file, fs::file_type::regular);
  try {
    return read_whole_file(file, kMaxListBytes);
  } catch (const Error& error) {
    throw Error(ErrorCode::kOutput, error.what());
  }
}

/// Reads text from the front of a line. Each function is false where the line goes on otherwise.
struct LineReader {
  std::string_view rest;

  bool read(std::string_view text) {
    if (!rest.starts_with(text)) return false;
    rest.remove_prefix(text.size());
    return true;
  }
  bool read_quoted(std::string& text) {
    if (!rest.starts_with('"')) return false;
    std::size_t end = 1;
    while (end < rest.size() && rest[end] != '"') end += rest[end] == '\\' ? 2 : 1;
    if (end >= rest.size()) return false;
    const auto value = nlohmann::json::parse(rest.substr(0, end + 1), nullptr, false);
    if (!value.is_string()) return false;
    text = value.get<std::string>();
    rest.remove_prefix(end + 1);
    return true;
  }
  bool read_number(std::size_t& number) {
    const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), number);
    if (error != std::errc()) return false;
    rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
    return true;
  }
};

// Only lines exactly as list_own() and remove_own() write them count.
void read_line(std::string_view line, std::map<std::string, OwnFile>& files) {
  LineReader reader{line};
  std::string name;
  OwnFile about;
  if (!reader.read("{\"file\":") || !reader.read_quoted(name)) return;
  if (reader.rest == "}") {
    files.erase(name);
  } else if (reader.read(",\"bytes\":") && reader.read_number(about.bytes) &&
             reader.read(",\"hash\":") && reader.read_quoted(about.hash) &&
             reader.read(",\"of\":") && reader.read_quoted(about.of) && reader.rest == "}") {
    files[name] = std::move(about);
  }
}

template <typename Line>
void for_each_line(std::string_view text, Line line) {
  for (std::size_t end; (end = text.find('\n')) != std::string_view::npos;) {
    line(text.substr(0, end));
    text.remove_prefix(end + 1);
  }
}

bool is_there(const fs::path& file) {
  struct stat about {};
  return ::lstat(file.c_str(), &about) == 0;
}

// A hash of boot and process namespace (container): process ids mean the same only where it is
// equal.
// "" where it cannot be found out.
const std::string& process_namespace() {
  static const std::string kName = [] {
    char space[64];
    const ssize_t length = ::readlink("/proc/self/ns/pid", space, sizeof space);
    std::string boot;
    try {
      const Descriptor in("/proc/sys/kernel/random/boot_id", 0);
      char text[64];
      const ssize_t got = ::read(in.value(), text, sizeof text);
      boot.assign(text, got > 0 ? static_cast<std::size_t>(got) : 0);
    } catch (const Error&) {
    }
    if (length <= 0 || boot.empty()) return std::string();
    return hash_of(boot + std::string(space, static_cast<std::size_t>(length))).substr(0, 8);
  }();
  return kName;
}

// Whether it is the name of a temporary file of a process that no longer runs.
bool is_leftover(const std::string& name) {
  const std::string ours = kTemporary + process_namespace() + "-";
  if (process_namespace().empty() || !name.starts_with(ours) || !name.ends_with(".tmp"))
    return false;
  pid_t process = 0;
  const char* begin = name.data() + ours.size();
  const auto [end, error] = std::from_chars(begin, name.data() + name.size(), process);
  return error == std::errc() && *end == '-' && process > 0 && process != ::getpid() &&
         ::kill(process, 0) != 0 && errno == ESRCH;
}

}  // namespace

std::map<std::string, OwnFile> own_files(const fs::path& folder) {
  std::map<std::string, OwnFile> files;
  for_each_line(list_of(folder), [&](std::string_view line) { read_line(line, files); });
  return files;
}

std::optional<OwnFile> own_file(const fs::path& file) {
  const std::string name = file.filename().string(), begin = "{\"file\":" + quoted(name);
  std::map<std::string, OwnFile> found;
  for_each_line(list_of(file.parent_path()), [&](std::string_view line) {
    if (line.starts_with(begin)) read_line(line, found);
  });
  if (found.empty()) return std::nullopt;
  return found.begin()->second;
}

void list_own(const fs::path& file, const OwnFile& about) {
  append_durably(file.parent_path() / kList, "{\"file\":" + quoted(file.filename().string()) +
                                                 ",\"bytes\":" + std::to_string(about.bytes) +
                                                 ",\"hash\":" + quoted(about.hash) +
                                                 ",\"of\":" + quoted(about.of) + "}");
}

void refuse_foreign(const fs::path& file) {
  throw Error(ErrorCode::kOutput, file.string() +
                                      ": is there and not of Thew's making; move it away, write to "
                                      "another place, or replace it");
}

void check_own(const fs::path& file) {
  if (!is_there(file)) return;
  check_replaceable(file, fs::file_type::regular);
  if (!own_file(file)) refuse_foreign(file);
}

void claim(const std::vector<fs::path>& files, bool overwrite) {
  std::set<fs::path> folders;
  std::map<std::string, OwnFile> ours;
  fs::path folder;
  for (const fs::path& file : files) {
    if (folders.empty() || folder != file.parent_path()) {
      folder = file.parent_path();
      ours = own_files(folder);
      folders.insert(folder);
    }
    if (!is_there(file)) continue;
    check_replaceable(file, fs::file_type::regular);
    if (ours.contains(file.filename().string())) continue;
    if (!overwrite) refuse_foreign(file);
    list_own(file);
  }
  for (const fs::path& one : folders) remove_leftovers(one);
}

void remove_leftovers(const fs::path& folder) {
  struct stat about {};
  const fs::path here = folder.empty() ? "." : folder;
  if (::stat(here.c_str(), &about) != 0 || !S_ISDIR(about.st_mode)) return;
  for (const fs::path& path : paths_in(here)) {
    if (is_leftover(path.filename().string())) remove_file(path);
  }
}

void claim_folder(const fs::path& folder) {
  check_replaceable(folder, fs::file_type::directory);
  create_folders(folder);
}

void remove_own(const fs::path& file) {
  if (!own_file(file)) return;
  if (is_there(file)) check_replaceable(file, fs::file_type::regular);
  remove_file(file);
  append_durably(file.parent_path() / kList, "{\"file\":" + quoted(file.filename().string()) + "}");
}

Temporary::Temporary(const fs::path& file)
    : path([&] {
        static std::atomic<unsigned> count{0};
        return file.parent_path() /
               (kTemporary + process_namespace() + "-" + std::to_string(::getpid()) + "-" +
                std::to_string(++count) + ".tmp");
      }()) {}

Temporary::~Temporary() { ::unlink(path.c_str()); }  // a full disk gets its space back

}  // namespace thew::sim
