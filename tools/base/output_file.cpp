// SPDX-License-Identifier: Apache-2.0
#include "tools/base/output_file.h"

#include <sys/stat.h>

#include <bit>
#include <cerrno>
#include <charconv>
#include <system_error>
#include <utility>

namespace thew::tools {
namespace {

template <typename T>
std::string shortest(T value) {
  char text[40];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  return {text, end};
}

// 0 where there is no file.
std::uint64_t number_of(const std::filesystem::path& file) {
  struct stat about {};
  return ::lstat(file.c_str(), &about) == 0 ? about.st_ino : 0;
}

}  // namespace

static_assert(std::endian::native == std::endian::little);

ExportFile::ExportFile(const std::filesystem::path& file) : file_(file), temporary_(file) {
  if (file.has_parent_path()) create_folders(file.parent_path());
  check_own(file);
  out_ = std::fopen(temporary_.path.c_str(), "w+bxe");
  if (!out_) fail("open");
}

ExportFile::~ExportFile() {
  if (out_) std::fclose(out_);
}

void ExportFile::fail(const char* what) const {
  throw Error(ErrorCode::kOutput,
              file_.string() + ": cannot " + what + ": " + std::generic_category().message(errno) +
                  "; check the folder, its permissions and the space left, then export again");
}

void ExportFile::append(std::string_view bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), out_) != bytes.size()) fail("write");
  size_ += bytes.size();
}

void ExportFile::patch(std::uint64_t at, std::string_view bytes) {
  if (::fseeko(out_, static_cast<off_t>(at), SEEK_SET) != 0 ||
      std::fwrite(bytes.data(), 1, bytes.size(), out_) != bytes.size() ||
      ::fseeko(out_, 0, SEEK_END) != 0) {
    fail("write");
  }
}

void ExportFile::read_back(std::uint64_t from, const std::function<void(std::string_view)>& take) {
  std::vector<char> piece(std::size_t{1} << 16);
  if (::fseeko(out_, static_cast<off_t>(from), SEEK_SET) != 0) fail("write");
  for (std::size_t got; (got = std::fread(piece.data(), 1, piece.size(), out_)) > 0;) {
    take({piece.data(), got});
  }
  if (std::ferror(out_) || ::fseeko(out_, 0, SEEK_END) != 0) fail("read");
}

void ExportFile::finish() {
  std::FILE* closing = std::exchange(out_, nullptr);
  if (std::fclose(closing) != 0) fail("write");
  place_durably(temporary_.path, file_, {size_, "", ""});
}

WrittenFiles::~WrittenFiles() {
  for (const auto& [file, number] : files_) {
    try {
      if (number_of(file) == number) remove_own(file);
    } catch (...) {  // whoever unwinds past keep() has an error of its own
    }
  }
}

void WrittenFiles::add(const std::filesystem::path& file) {
  files_.push_back({file, number_of(file)});
}

std::vector<std::filesystem::path> WrittenFiles::keep() {
  std::vector<std::filesystem::path> files;
  for (const Written& written : std::exchange(files_, {})) files.push_back(written.file);
  return files;
}

void put_floats(std::string& bytes, const Vec3& value) {
  for (int axis = 0; axis < 3; ++axis) put(bytes, static_cast<float>(value[axis]));
}

std::string digits(float value) { return shortest(value); }
std::string digits(double value) { return shortest(value); }

}  // namespace thew::tools
