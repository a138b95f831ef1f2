// SPDX-License-Identifier: Apache-2.0
#include "tools/render/image.h"

#include <png.h>
#include <zlib.h>

#include <cassert>
#include <csetjmp>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <memory>
#include <new>
#include <string>

#include "rig/types.h"
#include "sim/cache/durable_file.h"

namespace thew::tools {
namespace {

constexpr png_uint_32 kLargestSide = 16384;
constexpr const char* kRendererKey = "Renderer";
constexpr std::size_t kLongestText = 256;  // bytes, of a renderer's name

void remember_error(png_structp png, png_const_charp message) {
  std::snprintf(static_cast<char*>(png_get_error_ptr(png)), 128, "%s", message);
  png_longjmp(png, 1);
}

void ignore_warning(png_structp, png_const_charp) {}

// libpng reports by longjmp: nothing in this frame has a destructor. False leaves the cause in
// `why`.
bool encode(std::FILE* out, const Image& image, int level, char (&why)[128]) {
  png_structp png =
      png_create_write_struct(PNG_LIBPNG_VER_STRING, why, remember_error, ignore_warning);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  if (!info || setjmp(png_jmpbuf(png))) {
    png_destroy_write_struct(&png, &info);
    return false;
  }
  png_init_io(png, out);
  png_set_compression_level(png, level);
  if (level == kFastPng) {
    // What is left of smooth shading by one filter is runs: two thirds of the time of the search
    // for repetitions that zlib makes otherwise, and a fifth smaller.
    png_set_compression_strategy(png, Z_RLE);
    png_set_filter(png, 0, PNG_FILTER_SUB);
  } else {
    // The two filters that pay on it; trying all five costs more than the drawing.
    png_set_filter(png, 0, PNG_FILTER_SUB | PNG_FILTER_UP);
  }
  png_set_IHDR(png, info, image.width, image.height, 8, PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  if (!image.renderer.empty()) {
    png_text text{};
    text.compression = PNG_TEXT_COMPRESSION_NONE;
    text.key = const_cast<char*>(kRendererKey);  // libpng copies both
    text.text = const_cast<char*>(image.renderer.c_str());
    png_set_text(png, info, &text, 1);
  }
  png_write_info(png, info);
  for (int y = 0; y < image.height; ++y) {
    png_write_row(png, image.rgb.data() + 3ul * image.width * y);
  }
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return true;
}

std::uint32_t big_endian(const unsigned char* bytes) {
  return std::uint32_t{bytes[0]} << 24 | bytes[1] << 16 | bytes[2] << 8 | bytes[3];
}

// libpng's simplified interface drops texts. A PNG is 8 bytes, then chunks: length, type, data,
// CRC; those that we write stand before the pixels.
std::string read_renderer(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  const std::string key = std::string(kRendererKey) + '\0';
  unsigned char head[8];
  in.ignore(8);
  while (in.read(reinterpret_cast<char*>(head), sizeof head)) {
    const std::string type(reinterpret_cast<char*>(head) + 4, 4);
    const std::uint32_t length = big_endian(head);
    if (type == "IDAT") break;
    if (type != "tEXt" || length > kLongestText) {
      in.ignore(length + 4ll);
      continue;
    }
    std::string data(length, '\0');
    in.read(data.data(), length);
    in.ignore(4);
    if (!in || !data.starts_with(key)) continue;
    data.erase(0, key.size());
    for (char& c : data) {
      if (c < ' ' || c > '~') c = '?';  // it is printed to terminals
    }
    return data;
  }
  return "";
}

}  // namespace

std::string png_bytes(const Image& image, int level) {
  assert(image.rgb.size() == 3ul * image.width * image.height);
  char* bytes = nullptr;
  std::size_t size = 0;
  char why[128] = "libpng could not start";
  std::FILE* out = ::open_memstream(&bytes, &size);
  const bool encoded = out && encode(out, image, level, why);
  const bool closed = out && std::fclose(out) == 0;
  const std::unique_ptr<char, decltype(&std::free)> owner(bytes, std::free);
  if (!closed) throw std::bad_alloc();
  if (!encoded) {
    throw Error(ErrorCode::kOutput, std::string("cannot encode a picture: ") + why +
                                        "; choose a smaller size, or free some memory");
  }
  return {bytes, size};
}

void write_png(const std::filesystem::path& file, const Image& image, int level,
               const std::string& of) {
  write_durably(file, png_bytes(image, level), of);
}

std::string encode_png(const Image& image) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = image.width;
  png.height = image.height;
  png.format = PNG_FORMAT_RGB;
  std::string bytes;
  png_alloc_size_t size = 0;  // the first call only asks for it
  for (void* to : {static_cast<void*>(nullptr), static_cast<void*>(&bytes)}) {
    if (to) bytes.resize(size);
    if (!png_image_write_to_memory(&png, to ? bytes.data() : nullptr, &size, 0, image.rgb.data(), 0,
                                   nullptr)) {
      throw Error(ErrorCode::kOutput, std::string("cannot encode a picture: ") + png.message +
                                          "; choose a smaller size");
    }
  }
  return bytes;
}

Image read_png(const std::filesystem::path& file) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  const auto fail = [&](const std::string& cause) {
    png_image_free(&png);
    throw Error(ErrorCode::kInput,
                file.string() + ": cannot read the image: " + cause + "; give a PNG file");
  };
  std::error_code error;  // a folder or a pipe would block or confuse libpng
  if (!std::filesystem::is_regular_file(file, error)) fail("no such file");
  if (!png_image_begin_read_from_file(&png, file.c_str())) fail(png.message);
  if (png.width > kLargestSide || png.height > kLargestSide) fail("larger than 16384 pixels");
  png.format = PNG_FORMAT_RGB;
  Image image{static_cast<int>(png.width), static_cast<int>(png.height), {}, read_renderer(file)};
  image.rgb.resize(PNG_IMAGE_SIZE(png));
  if (!png_image_finish_read(&png, nullptr, image.rgb.data(), 0, nullptr)) fail(png.message);
  return image;
}

}  // namespace thew::tools
