// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <map>

#include "tools/base/signals.h"
#include "tools/night/shot.h"

namespace thew::tools {
namespace {

namespace fs = std::filesystem;

constexpr const char* kChunks = ".chunks";  // FOLDER.chunks: where thew farm has those of FOLDER
constexpr int kDeepest =
    6;  // folders below one that is named: show, sequence, shot, character, ...

fs::path plain(const fs::path& folder) {
  fs::path path = fs::absolute(folder).lexically_normal();
  return path.has_filename() ? path : path.parent_path();  // "out/" is "out"
}

// Parts that wait for --join, and what `thew poses` keeps beside its file: no shots.
bool is_of_another(const fs::path& folder) {
  std::error_code error;
  if (fs::exists(folder / "report.json", error) || fs::exists(folder / "failure.json", error)) {
    return false;
  }
  if (folder.extension() == ".bake") return true;
  return read_shot(folder, "").again.find(" --chunk") != std::string::npos;
}

std::vector<fs::path> chunks_of(const fs::path& folder) {
  std::vector<fs::path> chunks;
  std::error_code error;
  fs::directory_iterator entry(folder.string() + kChunks, error);
  for (; entry != fs::directory_iterator(); entry.increment(error)) {
    if (is_bake(entry->path())) chunks.push_back(entry->path());
  }
  std::sort(chunks.begin(), chunks.end());
  return chunks;
}

void search(const fs::path& folder, int depth, std::vector<fs::path>& found) {
  if (folder.extension() == kChunks) {  // of a bake that may have no folder yet
    const fs::path bake = folder.parent_path() / folder.stem();
    if (!chunks_of(bake).empty()) found.push_back(bake);
    return;
  }
  if (is_bake(folder)) {
    if (depth == 0 || !is_of_another(folder)) found.push_back(folder);
    return;
  }
  if (depth == kDeepest) return;
  std::error_code error;  // a folder that may not be read holds nothing for us
  fs::directory_iterator entry(folder, error);
  for (; entry != fs::directory_iterator(); entry.increment(error)) {
    if (entry->path().filename().string().starts_with('.')) continue;
    if (entry->is_directory(error) && !entry->is_symlink(error)) {
      search(entry->path(), depth + 1, found);
    }
  }
}

}  // namespace

fs::path common_folder(const std::vector<fs::path>& folders) {
  fs::path common;
  for (size_t i = 0; i < folders.size(); ++i) {
    const fs::path folder = plain(folders[i]);
    if (i == 0) {
      common = is_bake(folder) ? folder.parent_path() : folder;
      continue;
    }
    const auto [end, unused] =
        std::mismatch(common.begin(), common.end(), folder.begin(), folder.end());
    fs::path shared;
    for (auto part = common.begin(); part != end; ++part) shared /= *part;
    common = shared;
  }
  return common;
}

std::vector<NightShot> find_shots(const std::vector<fs::path>& folders) {
  const fs::path base = common_folder(folders);
  std::map<std::string, fs::path> by_name;
  for (const fs::path& named : folders) {
    std::vector<fs::path> found;
    search(plain(named), 0, found);
    if (found.empty()) found.push_back(plain(named));
    for (const fs::path& folder : found) {
      const std::string name = folder.lexically_relative(base).string();
      by_name.emplace(name.empty() || name == "." ? folder.filename().string() : name, folder);
    }
  }
  std::vector<NightShot> shots;
  for (const auto& [name, folder] : by_name) {
    stop_if_interrupted();
    const auto chunks = is_bake(folder) ? std::vector<fs::path>{} : chunks_of(folder);
    shots.push_back(chunks.empty() ? read_shot(folder, name) : read_chunks(folder, chunks, name));
  }
  return shots;
}

}  // namespace thew::tools
