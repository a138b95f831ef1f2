// SPDX-License-Identifier: Apache-2.0
#include <libdeflate.h>

#include "tools/export/formats.h"
#include "tools/export/usd/usd.h"

namespace thew::tools {
namespace {

/// A usdz is a zip of files as they are, each from a multiple of 64 bytes on. Ours holds one.
constexpr std::string_view kInner = "bake.usdc";
constexpr std::size_t kDataPlace = 64;
constexpr std::uint16_t kFirstDay = 1 << 5 | 1;  // 1 January 1980: the same bytes at any time

// What both headers of a zip say of the file in it.
std::string zip_entry(std::uint32_t crc, std::uint32_t size, std::size_t padding) {
  std::string bytes;
  for (const std::uint16_t word : {10, 0, 0, 0}) put(bytes, word);  // version, flags, stored, time
  put(bytes, kFirstDay);
  for (const std::uint32_t word : {crc, size, size}) put(bytes, word);
  put(bytes, static_cast<std::uint16_t>(kInner.size()));
  put(bytes, static_cast<std::uint16_t>(padding));
  return bytes;
}

std::string local_header(std::uint32_t crc, std::uint32_t size) {
  const std::size_t padding = kDataPlace - 30 - kInner.size();
  std::string bytes = "PK\3\4" + zip_entry(crc, size, padding) + std::string(kInner);
  put<std::uint16_t>(bytes, 0x1986);
  put(bytes, static_cast<std::uint16_t>(padding - 4));
  return bytes + std::string(padding - 4, '\0');
}

std::string directory(std::uint32_t crc, std::uint32_t size) {
  std::string bytes = "PK\1\2";
  put<std::uint16_t>(bytes, 10);
  bytes += zip_entry(crc, size, 0) + std::string(14, '\0') + std::string(kInner);
  std::string end = "PK\5\6" + std::string(4, '\0');
  put<std::uint16_t>(end, 1);
  put<std::uint16_t>(end, 1);
  put(end, static_cast<std::uint32_t>(bytes.size()));
  put(end, static_cast<std::uint32_t>(kDataPlace + size));
  return bytes + end + std::string(2, '\0');
}

void write_usdz(const Shot& shot, UsdLayer& layer, const std::filesystem::path& file,
                ExportFile& out) {
  constexpr std::uint64_t kMost = 0xfff00000;  // zip counts in 32 bits
  out.append(std::string(kDataPlace, '\0'));
  write_usdc(shot, layer, out);
  if (out.size() > kMost) {
    throw Error(ErrorCode::kUsage, file.string() +
                                       ": a usdz holds 4 GB, and the bake takes more; write .usdc, "
                                       "or fewer --frames");
  }
  std::uint32_t crc = 0;
  out.read_back(kDataPlace, [&](std::string_view bytes) {
    crc = libdeflate_crc32(crc, bytes.data(), bytes.size());
  });
  const auto size = static_cast<std::uint32_t>(out.size() - kDataPlace);
  out.patch(0, local_header(crc, size));
  out.append(directory(crc, size));
}

}  // namespace

Exported export_usd(const Shot& shot, const std::filesystem::path& file) {
  ExportFile out(file);
  UsdLayer layer = describe_usd(shot);
  if (file.extension() == ".usda") {
    write_usda(shot, layer, out);
  } else if (file.extension() == ".usdc") {
    write_usdc(shot, layer, out);
  } else {
    write_usdz(shot, layer, file, out);
  }
  out.finish();
  return {{file},
          "time codes are frame numbers; default points are the rest pose, and rigid meshes move "
          "by a transform"};
}

}  // namespace thew::tools
