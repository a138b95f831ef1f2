// SPDX-License-Identifier: Apache-2.0
#include "rig/import/gltf_file.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include "rig/import/child.h"
#include "rig/import/json_number.h"
#include "rig/text.h"

namespace thew::rig {
namespace {

// glTF 2.0, 3.6.2.2: kinds of component.
enum Kind : size_t {
  kByte = 5120,
  kUnsignedByte = 5121,
  kShort = 5122,
  kUnsignedShort = 5123,
  kUnsignedInt = 5125,
  kFloat = 5126
};

size_t bytes_of(size_t kind) {
  switch (kind) {
    case kByte:
    case kUnsignedByte:
      return 1;
    case kShort:
    case kUnsignedShort:
      return 2;
    case kUnsignedInt:
    case kFloat:
      return 4;
    default:
      return 0;
  }
}

size_t width_of(std::string_view type) {
  constexpr std::pair<std::string_view, size_t> kWidths[] = {
      {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT4", 16}};
  for (const auto& [name, width] : kWidths) {
    if (name == type) return width;
  }
  return 0;
}

template <typename T>
T value_at(const char* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

// glTF 2.0, 3.11: a normalised integer is divided by the largest of its type.
double number_at(const char* at, size_t kind, bool as_share) {
  switch (kind) {
    case kByte:
      return as_share ? std::max(value_at<std::int8_t>(at) / 127.0, -1.0)
                      : value_at<std::int8_t>(at);
    case kUnsignedByte:
      return value_at<std::uint8_t>(at) / (as_share ? 255.0 : 1.0);
    case kShort:
      return as_share ? std::max(value_at<std::int16_t>(at) / 32767.0, -1.0)
                      : value_at<std::int16_t>(at);
    case kUnsignedShort:
      return value_at<std::uint16_t>(at) / (as_share ? 65535.0 : 1.0);
    case kUnsignedInt:
      return value_at<std::uint32_t>(at);
    default:
      return value_at<float>(at);
  }
}

std::uint32_t index_at(const char* at, size_t kind) {
  return kind == kUnsignedByte    ? value_at<std::uint8_t>(at)
         : kind == kUnsignedShort ? value_at<std::uint16_t>(at)
                                  : value_at<std::uint32_t>(at);
}

std::optional<std::string> from_base64(std::string_view text) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::array<std::uint8_t, 256> digit_of;
  digit_of.fill(64);
  for (size_t i = 0; i < kDigits.size(); ++i) {
    digit_of[static_cast<unsigned char>(kDigits[i])] = static_cast<std::uint8_t>(i);
  }
  std::string out;
  out.reserve(text.size() / 4 * 3 + 3);
  std::uint32_t value = 0;
  int bits = 0;
  for (const char c : text) {
    if (c == '=') break;
    const std::uint8_t digit = digit_of[static_cast<unsigned char>(c)];
    if (digit == 64) return {};
    value = value << 6 | digit;
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    out.push_back(static_cast<char>(value >> bits & 255u));
  }
  return out;
}

// A URI with its percent codes resolved: "my%20mesh.bin" names a file with a blank in its name.
std::string decoded_uri(const std::string& uri) {
  const auto digit = [](char c) {
    return c >= '0' && c <= '9'   ? c - '0'
           : c >= 'a' && c <= 'f' ? c - 'a' + 10
           : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                  : -1;
  };
  std::string out;
  for (size_t i = 0; i < uri.size(); ++i) {
    const bool coded =
        uri[i] == '%' && i + 2 < uri.size() && digit(uri[i + 1]) >= 0 && digit(uri[i + 2]) >= 0;
    out.push_back(coded ? static_cast<char>(16 * digit(uri[i + 1]) + digit(uri[i + 2])) : uri[i]);
    i += coded ? 2 : 0;
  }
  return out;
}

std::string location_of(const char* name, size_t index) {
  return std::string(name) + "[" + std::to_string(index) + "]";
}

}  // namespace

struct GltfFile::Layout {
  std::string location;  // "accessors[3]"
  size_t count = 0, width = 0, kind = 0;
  bool as_shares = false;
  const char* first = nullptr;  // null: all items are 0, except those of `sparse`
  size_t stride = 0;            // bytes
  const Json* sparse = nullptr;
};

GltfFile::GltfFile(std::filesystem::path file)
    : file_(std::move(file)), bytes_(read_in_child(file_of_child(), kFileLimit)) {
  constexpr size_t kHead = 12, kChunkHead = 8;  // bytes
  std::string_view text = bytes_;
  if (text.starts_with(
          "glTF")) {  // version and length follow, then chunks of length, kind and bytes
    std::string_view json;
    for (size_t at = kHead; at + kChunkHead <= text.size();) {
      const size_t length = value_at<std::uint32_t>(text.data() + at);
      const std::string_view kind = text.substr(at + 4, 4);
      if (length > text.size() - at - kChunkHead) {
        refuse("is cut short: a chunk claims " + std::to_string(length) + " bytes, and " +
               std::to_string(text.size() - at - kChunkHead) + " are left");
      }
      const std::string_view chunk = text.substr(at + kChunkHead, length);
      if (kind == "JSON" && json.empty()) json = chunk;
      if (kind == std::string_view("BIN\0", 4) && binary_.empty()) binary_ = chunk;
      at += kChunkHead + length;
    }
    text = json;
  }
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);  // a byte order mark
  try {
    json_ = Json::parse(text);
  } catch (const Json::exception& error) {
    const std::string what = error.what();  // the message ends with all that was last read
    refuse("is no glTF, its JSON cannot be read (" +
           printable(what.substr(0, std::min<size_t>(what.find("; last read"), 300))) + ")");
  }
  if (!json_.is_object()) refuse("is no glTF, its JSON is no object");
  const auto asset = json_.find("asset");
  const std::string version =
      asset == json_.end() || !asset->is_object() ? "" : text_of(*asset, "version");
  if (!version.starts_with("2.")) {
    refuse(version.empty() ? "is no glTF, it names no version of the format"
                           : "is glTF " + printable(version) + ", and 2.0 is read");
  }
}

void GltfFile::refuse(const std::string& what, const char* next) const {
  throw Error(ErrorCode::kInput, file_.string() + ": " + what + "; " + next);
}

const GltfFile::Json& GltfFile::list(const char* name) const {
  static const Json kNone = Json::array();
  const auto found = json_.find(name);
  if (found == json_.end()) return kNone;
  if (!found->is_array()) refuse(std::string(name) + " is no list");
  return *found;
}

const GltfFile::Json& GltfFile::item(const char* name, size_t index,
                                     const std::string& from) const {
  const Json& items = list(name);
  if (index < items.size() && items[index].is_object()) return items[index];
  refuse(from + " names " + location_of(name, index) + " of " + std::to_string(items.size()));
}

size_t GltfFile::index_or(const Json& object, const char* key, size_t otherwise,
                          const std::string& location) const {
  const auto found = object.find(key);
  if (found == object.end()) return otherwise;
  const auto number = whole_number(*found);
  if (!number || *number < 0) refuse(location + "." + key + " is no whole number of at least 0");
  return static_cast<size_t>(*number);
}

size_t GltfFile::index_of(const Json& object, const char* key, const std::string& location) const {
  if (!object.contains(key)) refuse(location + " has no " + key);
  return index_or(object, key, 0, location);
}

bool GltfFile::numbers_of(const Json& object, const char* key, size_t count,
                          const std::string& location, double* to) const {
  const auto found = object.find(key);
  if (found == object.end()) return false;
  bool good = found->is_array() && found->size() == count;
  for (size_t k = 0; good && k < count; ++k) {
    good = (*found)[k].is_number();
    if (good) to[k] = (*found)[k].get<double>();
    good = good && std::isfinite(to[k]);
  }
  if (!good) refuse(location + "." + key + " is no list of " + std::to_string(count) + " numbers");
  return true;
}

std::string GltfFile::text_of(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

std::string_view GltfFile::buffer(size_t index, const std::string& from) {
  if (const auto found = buffers_.find(index); found != buffers_.end()) return found->second;
  const Json& entry = item("buffers", index, from);
  const std::string location = location_of("buffers", index);
  const std::string uri = text_of(entry, "uri");
  if (uri.empty()) {
    if (index == 0 && !binary_.empty()) return binary_;
    refuse(location + " has no bytes, neither a uri nor the chunk of a .glb");
  }
  std::string& bytes = buffers_[index];
  auto read = bytes_of_uri(uri);
  if (!read && uri.starts_with("data:")) refuse(location + ".uri is no data in base64");
  if (!read) {
    refuse(location + " is in \"" + printable(uri) + "\", which is no regular file in its folder");
  }
  bytes = std::move(*read);
  return bytes;
}

std::optional<std::string> GltfFile::bytes_of_uri(const std::string& uri) {
  if (uri.starts_with("data:")) {
    constexpr std::string_view kMark = ";base64,";
    const size_t mark = uri.find(kMark);
    if (mark == uri.npos) return std::nullopt;
    return from_base64(std::string_view(uri).substr(mark + kMark.size()));
  }
  try {
    return read_in_child(decoded_uri(uri), kFileLimit);
  } catch (const Error&) {
    return std::nullopt;
  }
}

std::vector<std::string> GltfFile::files_named() const {
  std::vector<std::string> files;
  for (const char* name : {"buffers", "images"}) {
    for (const Json& entry : list(name)) {
      const std::string uri = entry.is_object() ? text_of(entry, "uri") : "";
      if (!uri.empty() && !uri.starts_with("data:")) files.push_back(decoded_uri(uri));
    }
  }
  return files;
}

std::string_view GltfFile::view(size_t index, const std::string& from) {
  const Json& entry = item("bufferViews", index, from);
  const std::string location = location_of("bufferViews", index);
  const size_t of = index_of(entry, "buffer", location);
  const Json& in = item("buffers", of, location);
  // A file may also have the uncompressed bytes of a compressed view, for readers that do not know
  // the extension.
  const auto packed = [](const Json& of_what) {
    return of_what.contains("extensions") &&
           of_what["extensions"].contains("EXT_meshopt_compression");
  };
  if (packed(entry) && !in.contains("uri") && (of != 0 || binary_.empty() || packed(in))) {
    refuse("is compressed (EXT_meshopt_compression), which Thew does not read", kUncompressed);
  }
  const std::string_view whole = buffer(of, location);
  const size_t begin = index_or(entry, "byteOffset", 0, location),
               length = index_of(entry, "byteLength", location);
  if (begin > whole.size() || length > whole.size() - begin) {
    refuse(location + " reaches beyond the " + std::to_string(whole.size()) +
           " bytes of its buffer");
  }
  return whole.substr(begin, length);
}

GltfFile::Layout GltfFile::layout_of(size_t accessor, size_t width) {
  Layout out;
  out.location = location_of("accessors", accessor);
  const Json& a = item("accessors", accessor, "the file");
  out.count = index_of(a, "count", out.location);
  out.kind = index_of(a, "componentType", out.location);
  out.width = width_of(text_of(a, "type"));
  const size_t size = bytes_of(out.kind) * width;
  if (size == 0) refuse(out.location + ".componentType is none of the format's");
  if (out.width != width) refuse(out.location + " is not of the width that its use asks for");
  out.as_shares = a.value("normalized", Json(false)) == Json(true);
  if (const auto sparse = a.find("sparse"); sparse != a.end()) {
    if (!sparse->is_object()) refuse(out.location + ".sparse is no object");
    out.sparse = &*sparse;
  }
  if (!a.contains("bufferView")) {
    if (a.contains("extensions")) refuse(out.location + " has no data, but extensions of its own");
    // All items are 0 except the sparse ones (3.6.2.3): writers that pack leave such data out. No
    // bytes of the file back their count, so it is compared with the limit of a file.
    if (out.count > kFileLimit / size) refuse(out.location + " has too many items");
    return out;
  }
  const size_t index = index_of(a, "bufferView", out.location);
  const std::string_view from = view(index, out.location);
  const Json& entry = list("bufferViews")[index];
  const size_t first = index_or(a, "byteOffset", 0, out.location);
  out.stride = index_or(entry, "byteStride", size, location_of("bufferViews", index));
  const bool fits =
      out.stride >= size && out.stride <= 252 && first <= from.size() &&
      (out.count == 0 ||
       (size <= from.size() - first && out.count - 1 <= (from.size() - first - size) / out.stride));
  if (!fits) refuse(out.location + " reaches beyond its view");
  out.first = from.data() + first;
  return out;
}

// Replaces the items that the accessor lists one by one (3.6.2.3).
template <typename Number, typename Read>
void GltfFile::put_sparse(const Layout& layout, std::vector<Number>& items, const Read& read) {
  const std::string location = layout.location + ".sparse";
  const Json& sparse = *layout.sparse;
  const size_t count = index_of(sparse, "count", location);
  const auto part = [&](const char* name, size_t kind, size_t width) {
    const auto found = sparse.find(name);
    if (found == sparse.end() || !found->is_object()) refuse(location + " has no " + name);
    const std::string_view from = view(index_of(*found, "bufferView", location), location);
    const size_t first = index_or(*found, "byteOffset", 0, location);
    const size_t size = bytes_of(kind) * width;
    if (size == 0 || first > from.size() || count > (from.size() - first) / size) {
      refuse(location + "." + name + " reaches beyond its view");
    }
    return from.data() + first;
  };
  const auto of = sparse.find("indices");
  const size_t kind =
      of != sparse.end() && of->is_object() ? index_of(*of, "componentType", location) : 0;
  if (kind != kUnsignedByte && kind != kUnsignedShort && kind != kUnsignedInt) {
    refuse(location + ".indices are no whole numbers of at least 0");
  }
  const char* at = part("indices", kind, 1);
  const char* value = part("values", layout.kind, layout.width);
  for (size_t i = 0; i < count; ++i) {
    const size_t item = index_at(at + i * bytes_of(kind), kind);
    if (item >= layout.count) refuse(location + " names item " + std::to_string(item));
    for (size_t k = 0; k < layout.width; ++k) {
      items[item * layout.width + k] =
          read(value + (i * layout.width + k) * bytes_of(layout.kind), layout);
    }
  }
}

template <typename Number, typename Read>
std::vector<Number> GltfFile::read_items(size_t accessor, size_t width, const Read& read) {
  const Layout layout = layout_of(accessor, width);
  std::vector<Number> out(layout.count * width);
  const size_t size = bytes_of(layout.kind);
  for (size_t i = 0; layout.first && i < layout.count; ++i) {
    for (size_t k = 0; k < width; ++k) {
      out[i * width + k] = read(layout.first + i * layout.stride + k * size, layout);
    }
  }
  if (layout.sparse) put_sparse(layout, out, read);
  return out;
}

std::vector<double> GltfFile::numbers(size_t accessor, size_t width, bool as_shares) {
  return read_items<double>(accessor, width, [&](const char* at, const Layout& layout) {
    const double number = number_at(at, layout.kind, as_shares || layout.as_shares);
    if (!std::isfinite(number)) refuse(layout.location + " holds what is no finite number");
    return number;
  });
}

std::vector<std::uint32_t> GltfFile::indices(size_t accessor, size_t width) {
  return read_items<std::uint32_t>(accessor, width, [&](const char* at, const Layout& layout) {
    if (layout.kind != kUnsignedByte && layout.kind != kUnsignedShort &&
        layout.kind != kUnsignedInt) {
      refuse(layout.location + " holds no whole numbers of at least 0");
    }
    return index_at(at, layout.kind);
  });
}

}  // namespace thew::rig
