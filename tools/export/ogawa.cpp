// SPDX-License-Identifier: Apache-2.0
#include "tools/export/ogawa.h"

namespace thew::tools {

OgawaFile::OgawaFile(const std::filesystem::path& file) : out_(file) {
  out_.append(std::string_view("Ogawa\0\0\1\0\0\0\0\0\0\0\0", 16));
}

std::uint64_t OgawaFile::add_leaf(std::string_view bytes) {
  if (bytes.empty()) return kLeaf;
  const std::uint64_t place = out_.size();
  std::string count;
  put<std::uint64_t>(count, bytes.size());
  out_.append(count);
  out_.append(bytes);
  return place | kLeaf;
}

std::uint64_t OgawaFile::add_group(const std::vector<std::uint64_t>& children) {
  if (children.empty()) return 0;
  const std::uint64_t place = out_.size();
  std::string bytes;
  put<std::uint64_t>(bytes, children.size());
  for (const std::uint64_t child : children) put(bytes, child);
  out_.append(bytes);
  return place;
}

void OgawaFile::finish(std::uint64_t root) {
  std::string place;
  put(place, root);
  out_.patch(8, place);
  out_.patch(5, "\xff");
  out_.finish();
}

}  // namespace thew::tools
