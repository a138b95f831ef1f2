// SPDX-License-Identifier: Apache-2.0
#include <libdeflate.h>

#include "tools/export/formats.h"
#include "tools/export/usd/usd.h"

namespace thew::tools {
namespace {

/// A usdz is a zip of files as they are, each from a multiple of 64 bytes on: ours holds the crate,
/// and the images of materials.
constexpr std::size_t kAlignment = 64;
constexpr const char *kCrate = "bake.usdc", *kImages = "textures/";
constexpr std::uint16_t kFirstDay = 1 << 5 | 1;  // 1 January 1980: the same bytes at any time

struct Entry {
  std::string name;
  std::uint32_t place = 0;  ///< of its header
  std::uint32_t crc = 0, size = 0;
};

// What both headers of a zip say of a file in it.
std::string zip_entry(const Entry& entry, std::size_t padding) {
  std::string bytes;
  for (const std::uint16_t word : {10, 0, 0, 0}) put(bytes, word);  // version, flags, stored, time
  put(bytes, kFirstDay);
  for (const std::uint32_t word : {entry.crc, entry.size, entry.size}) put(bytes, word);
  put(bytes, static_cast<std::uint16_t>(entry.name.size()));
  put(bytes, static_cast<std::uint16_t>(padding));
  return bytes;
}

// Padding is a field of its own, whose head takes 4 bytes.
std::string local_header(const Entry& entry) {
  const std::size_t end = entry.place + 30 + entry.name.size();
  std::size_t padding = kAlignment - end % kAlignment;
  if (padding < 4) padding += kAlignment;
  std::string bytes = "PK\3\4" + zip_entry(entry, padding) + entry.name;
  put<std::uint16_t>(bytes, 0x1986);
  put(bytes, static_cast<std::uint16_t>(padding - 4));
  return bytes + std::string(padding - 4, '\0');
}

std::string directory(const std::vector<Entry>& entries, std::uint32_t place) {
  std::string bytes;
  for (const Entry& entry : entries) {
    bytes += "PK\1\2";
    put<std::uint16_t>(bytes, 10);
    bytes += zip_entry(entry, 0) + std::string(10, '\0');
    put(bytes, entry.place);
    bytes += entry.name;
  }
  std::string end = "PK\5\6" + std::string(4, '\0');
  for (int k = 0; k < 2; ++k) put(end, static_cast<std::uint16_t>(entries.size()));
  put(end, static_cast<std::uint32_t>(bytes.size()));
  put(end, place);
  return bytes + end + std::string(2, '\0');
}

void write_usdz(const Shot& shot, UsdLayer& layer, const std::filesystem::path& file,
                ExportFile& out) {
  constexpr std::uint64_t kMost = 0xfff00000;  // zip counts in 32 bits
  const auto check_size = [&] {
    if (out.size() <= kMost) return;
    throw Error(ErrorCode::kUsage, file.string() +
                                       ": a usdz holds 4 GB, and the bake takes more; write .usdc, "
                                       "or fewer --frames");
  };
  Entry crate{kCrate};
  const std::size_t begin = local_header(crate).size();
  out.append(std::string(begin, '\0'));
  write_usdc(shot, layer, out);
  check_size();
  out.read_back(begin, [&](std::string_view bytes) {
    crate.crc = libdeflate_crc32(crate.crc, bytes.data(), bytes.size());
  });
  crate.size = static_cast<std::uint32_t>(out.size() - begin);
  out.patch(0, local_header(crate));
  std::vector<Entry> entries = {crate};
  for (const SkinImage& image : shot.looks.images) {
    const Entry entry{kImages + image.name, static_cast<std::uint32_t>(out.size()),
                      libdeflate_crc32(0, image.bytes.data(), image.bytes.size()),
                      static_cast<std::uint32_t>(image.bytes.size())};
    out.append(local_header(entry));
    out.append(image.bytes);
    check_size();
    entries.push_back(entry);
  }
  out.append(directory(entries, static_cast<std::uint32_t>(out.size())));
}

}  // namespace

std::vector<std::filesystem::path> usd_images(const Shot& shot, const std::filesystem::path& file) {
  std::vector<std::filesystem::path> files;
  for (const SkinImage& image : shot.looks.images) {
    if (file.extension() == ".usdz") break;
    files.push_back(file.parent_path() / (file.stem().string() + "." + image.name));
  }
  return files;
}

Exported export_usd(const Shot& shot, const std::filesystem::path& file) {
  WrittenFiles written;
  const bool archive = file.extension() == ".usdz";
  const std::vector<std::filesystem::path> images = usd_images(shot, file);
  for (std::size_t i = 0; i < images.size(); ++i) {
    ExportFile image(images[i]);
    image.append(shot.looks.images[i].bytes);
    image.finish();
    written.add(images[i]);
  }
  ExportFile out(file);
  UsdLayer layer = describe_usd(shot, archive ? kImages : "./" + file.stem().string() + ".");
  if (file.extension() == ".usda") {
    write_usda(shot, layer, out);
  } else if (!archive) {
    write_usdc(shot, layer, out);
  } else {
    write_usdz(shot, layer, file, out);
  }
  out.finish();
  std::vector<std::filesystem::path> files = written.keep();
  files.insert(files.begin(), file);
  return {files,
          "time codes are frame numbers; default points are the rest pose, and rigid meshes move "
          "by a transform; points are exact in each frame, normals to 1 degree"};
}

}  // namespace thew::tools
