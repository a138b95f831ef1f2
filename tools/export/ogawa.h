// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "tools/base/output_file.h"

namespace thew::tools {

/// Ogawa, Alembic's container: a tree of groups whose leaves are bytes. It is written from the
/// leaves up, so that nothing has to be mended but the place of the root.
/// File: "Ogawa", 0xff when complete, version 0 1, uint64 place of the root group.
/// Group: uint64 count, uint64 child each. Leaf: uint64 count, bytes. A child is its place in the
/// file, with the highest bit set for a leaf; place 0 is an empty group or leaf.
class OgawaFile {
 public:
  explicit OgawaFile(const std::filesystem::path& file);

  std::uint64_t add_leaf(std::string_view bytes);
  std::uint64_t add_group(const std::vector<std::uint64_t>& children);
  void finish(std::uint64_t root);

  static constexpr std::uint64_t kLeaf = std::uint64_t{1} << 63;

 private:
  ExportFile out_;
};

}  // namespace thew::tools
