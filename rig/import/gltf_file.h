// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rig/types.h"

namespace thew::rig {

// Private to the library; to be called in a child process (child.h).

/// A .gltf, .glb or .vrm file: its JSON, and the numbers of its buffers, which are read on demand.
/// No memory is allocated for a count before the count has been compared with the bytes that exist.
/// Whatever is not sound is Error(kInput) with the file, the location in its JSON and what the user
/// can do.
class GltfFile {
 public:
  using Json = nlohmann::json;

  static constexpr size_t kFileLimit = size_t{256} << 20;  ///< bytes

  explicit GltfFile(std::filesystem::path file);

  const std::filesystem::path& file() const { return file_; }
  const Json& json() const { return json_; }
  /// The list of that name in the root object; an empty one if there is none.
  const Json& list(const char* name) const;
  /// An item of such a list. `from` tells in messages where it is referred to.
  const Json& item(const char* name, size_t index, const std::string& from) const;

  /// The numbers of an accessor, `width` for each item (1 to 4, 16). Integers are divided by their
  /// largest value if the accessor is normalised or `as_shares` is true (glTF 2.0, 3.11).
  std::vector<double> numbers(size_t accessor, size_t width, bool as_shares = false);
  /// The bytes of a view. `from` as in item().
  std::string_view view(size_t index, const std::string& from);
  /// The same as numbers() as unsigned integers: indices.
  std::vector<std::uint32_t> indices(size_t accessor, size_t width);

  static constexpr const char* kUncompressed = "export the character again, without compression";
  [[noreturn]] void refuse(const std::string& what,
                           const char* next = "export the character again") const;
  /// A member of an object that is a whole number of at least 0. Where it is missing, index_of
  /// throws and index_or returns `otherwise`.
  size_t index_of(const Json& object, const char* key, const std::string& location) const;
  size_t index_or(const Json& object, const char* key, size_t otherwise,
                  const std::string& location) const;
  /// The bytes that a uri holds in base64, or that are in the file that it names, in the folder of
  /// this one or below; nothing where there are none.
  static std::optional<std::string> bytes_of_uri(const std::string& uri);
  /// The files beside it that hold buffers and images, as its uris name them.
  std::vector<std::string> files_named() const;
  /// Reads a member that is a list of `count` finite numbers; false if it is missing.
  bool numbers_of(const Json& object, const char* key, size_t count, const std::string& location,
                  double* to) const;
  /// A member that is a text; "" if it is missing or no text.
  static std::string text_of(const Json& object, const char* key);

 private:
  struct Layout;  // where the items of an accessor lie

  Layout layout_of(size_t accessor, size_t width);
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
