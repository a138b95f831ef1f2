// SPDX-License-Identifier: Apache-2.0
// libFuzzer's way into one reader, which THEW_READER names; see README.md.
#include <cstdint>

#include "tests/fuzz/readers.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t count) {
  using thew::tests::Reader;
  static const auto folder = [] {
    const auto made =
        thew::tests::fs::temp_directory_path() / ("thew_fuzz_" + std::to_string(getpid()));
    thew::tests::prepare_folder(made);
    return made;
  }();
  thew::tests::accepts(Reader::THEW_READER, folder, {reinterpret_cast<const char*>(bytes), count});
  return 0;
}
