// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "rig/types.h"

namespace thew::rig {

// Private to the library; to be called in a child process (child.h).

/// A .gltf, .glb or .vrm: its JSON, and numbers out of its buffers, which are read when they are
/// asked for. Nothing is set aside before it has been compared with the bytes that are there. What
/// does not hold is Error(kInput) with the file, the place in its JSON and the next move.
class GltfFile {
 public:
  using Json = nlohmann::json;

  explicit GltfFile(std::filesystem::path file);

  const std::filesystem::path& file() const { return file_; }
  const Json& json() const { return json_; }
  /// The list of that name at the top, an empty one where there is none.
  const Json& list(const char* name) const;
  /// An item of such a list. `from` says in messages who names it.
  const Json& item(const char* name, size_t index, const std::string& from) const;

  /// Numbers of an accessor, `width` to an item (1 to 4, 16); integers are shares of their largest
  /// where the file says so, or where `as_shares`.
  std::vector<double> numbers(size_t accessor, size_t width, bool as_shares = false);
  /// Whole numbers of at least 0: indices.
  std::vector<std::uint32_t> indices(size_t accessor, size_t width);

  static constexpr const char* kUncompressed = "export the character again, without compression";
  [[noreturn]] void refuse(const std::string& what,
                           const char* next = "export the character again") const;
  /// A member of an object: a whole number of at least 0, or `otherwise` where there is none.
  size_t index_of(const Json& object, const char* key, const std::string& location) const;
  size_t index_or(const Json& object, const char* key, size_t otherwise,
                  const std::string& location) const;
  /// A member: so many numbers. False where there is none.
  bool numbers_of(const Json& object, const char* key, size_t count, const std::string& location,
                  double* to) const;
  /// A member: a text; "" where there is none or it is none.
  static std::string text_of(const Json& object, const char* key);

 private:
  struct Layout;  // where the items of an accessor lie

  Layout layout_of(size_t accessor, size_t width);
  std::string_view view(size_t index, const std::string& from);
  std::string_view buffer(size_t index, const std::string& from);
  template <typename Number, typename Read>
  std::vector<Number> read_items(size_t accessor, size_t width, const Read& read);
  template <typename Number, typename Read>
  void put_sparse(const Layout& layout, std::vector<Number>& items, const Read& read);

  std::filesystem::path file_;
  std::string bytes_;
  std::string_view binary_;  // of a .glb
  Json json_;
  std::map<size_t, std::string> buffers_;
};

}  // namespace thew::rig
