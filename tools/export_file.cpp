// SPDX-License-Identifier: Apache-2.0
#include "tools/export_file.h"

#include <unistd.h>

#include <bit>
#include <cerrno>
#include <charconv>
#include <system_error>
#include <utility>

#include "sim/durable_file.h"

namespace thew {
namespace {

template <typename T>
std::string shortest(T value) {
  char text[40];
  const auto end = std::to_chars(text, text + sizeof text, value).ptr;
  return {text, end};
}

}  // namespace

static_assert(std::endian::native == std::endian::little);

ExportFile::ExportFile(const std::filesystem::path& file) : file_(file) {
  if (file.has_parent_path()) create_folders(file.parent_path());
  ::unlink(beside(file).c_str());  // of an export that was killed, or a link that leads elsewhere
  out_ = std::fopen(beside(file).c_str(), "wbxe");
  if (!out_) fail("open");
}

ExportFile::~ExportFile() {
  if (!out_) return;
  std::fclose(out_);
  ::unlink(beside(file_).c_str());
}

void ExportFile::fail(const char* what) const {
  throw Error(ExitCode::kOutput,
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

void ExportFile::finish() {
  // Until it is closed well the destructor takes it away.
  if (std::fflush(out_) != 0) fail("write");
  rename_durably(file_);
  std::FILE* closing = std::exchange(out_, nullptr);
  if (std::fclose(closing) != 0) fail("close");
}

void put_floats(std::string& bytes, const Vec3& value) {
  for (int axis = 0; axis < 3; ++axis) put(bytes, static_cast<float>(value[axis]));
}

std::string digits(float value) { return shortest(value); }
std::string digits(double value) { return shortest(value); }

}  // namespace thew
