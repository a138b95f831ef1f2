// SPDX-License-Identifier: Apache-2.0
#include "tools/base/printing.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>

#include "tools/base/exit_code.h"

namespace thew::tools {
namespace {

namespace fs = std::filesystem;

// Cuts ":12" off the end: 12, or 0 where there is none.
int take_line(std::string& place) {
  const size_t colon = place.rfind(':');
  if (colon == place.npos) return 0;
  int line = 0;
  const char* last = place.data() + place.size();
  const auto [end, error] = std::from_chars(place.data() + colon + 1, last, line);
  if (error != std::errc() || end != last || line < 1) return 0;
  place.resize(colon);
  return line;
}

// Blanks and quotes are of a sentence, an option is no file, and a file has a folder or an ending.
bool looks_like_a_file(const std::string& name) {
  std::string without_line = name;
  if (take_line(without_line) > 0) return false;
  if (name.empty() || name[0] == '-' || name.find_first_of(" \"") != name.npos) return false;
  return name.find('/') != name.npos || !fs::path(name).extension().empty();
}

bool is_known_file(const std::string& name, const std::vector<std::string>& words) {
  std::error_code error;
  if (name.empty()) return false;
  if (fs::exists(name, error)) return true;
  return std::any_of(words.begin(), words.end(), [&](const std::string& word) {
    return !word.empty() && (name == word || (name.starts_with(word) && name[word.size()] == '/') ||
                             (word.ends_with('/') && name.starts_with(word)));
  });
}

// The length of the place and its colon, 0 where the message begins with none.
template <typename IsFile>
size_t find_place(const std::string& message, const IsFile& is_file, ErrorParts& parts) {
  for (size_t at = message.find(": "); at != message.npos; at = message.find(": ", at + 1)) {
    std::string place = message.substr(0, at);
    int line = 0;
    if (!is_file(place) && ((line = take_line(place)) == 0 || !is_file(place))) continue;
    parts.file = place;
    parts.line = line;
    return at + 2;
  }
  return 0;
}

// The last "; " that is not quoted.
size_t find_next_move(const std::string& message, size_t from) {
  size_t found = message.npos;
  bool quoted = false;
  for (size_t at = from; at + 1 < message.size(); ++at) {
    if (message[at] == '"') quoted = !quoted;
    if (!quoted && message[at] == ';' && message[at + 1] == ' ') found = at;
  }
  return found;
}

nlohmann::ordered_json text_or_null(const std::string& text) {
  return text.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(text);
}

}  // namespace

void print(std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(STDOUT_FILENO, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      throw Error(ErrorCode::kOutput,
                  "standard output: cannot be written: " + std::generic_category().message(errno) +
                      "; send it to where there is space, or to a program that "
                      "reads it all");
    }
    text.remove_prefix(static_cast<size_t>(written));
  }
}

std::string json_text(const nlohmann::ordered_json& document, int indent) {
  return document.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

void print_json(const nlohmann::ordered_json& document) { print(json_text(document, 2) + "\n"); }

ErrorParts split_error(const std::string& message, const std::vector<std::string>& words) {
  ErrorParts parts;
  size_t begin = find_place(
      message, [&](const std::string& name) { return is_known_file(name, words); }, parts);
  if (begin == 0) begin = find_place(message, looks_like_a_file, parts);
  const size_t next = find_next_move(message, begin);
  parts.message = message.substr(begin, next == message.npos ? next : next - begin);
  if (next != message.npos) parts.next = message.substr(next + 2);
  return parts;
}

nlohmann::ordered_json error_as_json(ErrorCode code, const ErrorParts& parts) {
  return {{"error",
           {{"code", static_cast<int>(exit_code_of(code))},
            {"file", text_or_null(parts.file)},
            {"line", parts.line > 0 ? nlohmann::ordered_json(parts.line) : nullptr},
            {"message", parts.message},
            {"next", text_or_null(parts.next)}}}};
}

}  // namespace thew::tools
