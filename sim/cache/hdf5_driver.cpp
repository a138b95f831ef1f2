// SPDX-License-Identifier: Apache-2.0
#include "sim/cache/hdf5_driver.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "rig/import/child.h"

namespace thew::sim {
namespace {

// A driver of HDF5's for one open descriptor, for reading alone.
struct DescriptorFile {
  H5FD_t base{};  // first: HDF5 holds this
  haddr_t end_of_space = 0;
  OpenFile file;
};
thread_local OpenFile next_file;  // what H5Fopen, which takes a name, is to read

const DescriptorFile& of(const H5FD_t* file) {
  return *reinterpret_cast<const DescriptorFile*>(file);
}

herr_t read_bytes(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t at, std::size_t size, void* to) {
  char* next = static_cast<char*>(to);
  while (size > 0) {
    const ssize_t got = ::pread(of(file).file.descriptor, next, size, static_cast<off_t>(at));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) return -1;
    if (got == 0) {  // beyond the end are zeros, as for the library's own driver
      std::memset(next, 0, size);
      break;
    }
    next += got;
    at += static_cast<haddr_t>(got);
    size -= static_cast<std::size_t>(got);
  }
  return 0;
}

H5FD_class_t make_driver() {
  H5FD_class_t driver{};
  driver.name = "thew_descriptor";
  driver.maxaddr = (haddr_t{1} << 62) - 1;
  driver.fc_degree = H5F_CLOSE_STRONG;
  driver.open = [](const char*, unsigned, hid_t, haddr_t) -> H5FD_t* {
    auto* opened = new DescriptorFile;
    opened->file = std::exchange(next_file, {});
    return &opened->base;
  };
  driver.close = [](H5FD_t* file) -> herr_t {
    ::close(of(file).file.descriptor);
    delete reinterpret_cast<DescriptorFile*>(file);
    return 0;
  };
  driver.query = [](const H5FD_t*, unsigned long* flags) -> herr_t {
    *flags = H5FD_FEAT_ACCUMULATE_METADATA;
    return 0;
  };
  driver.get_eoa = [](const H5FD_t* file, H5FD_mem_t) { return of(file).end_of_space; };
  driver.set_eoa = [](H5FD_t* file, H5FD_mem_t, haddr_t end) -> herr_t {
    reinterpret_cast<DescriptorFile*>(file)->end_of_space = end;
    return 0;
  };
  driver.get_eof = [](const H5FD_t* file, H5FD_mem_t) -> haddr_t { return of(file).file.bytes; };
  driver.read = read_bytes;
  driver.write = [](H5FD_t*, H5FD_mem_t, hid_t, haddr_t, std::size_t, const void*) -> herr_t {
    return -1;
  };
  for (H5FD_mem_t& kind : driver.fl_map) kind = H5FD_MEM_SUPER;  // H5FD_FLMAP_SINGLE
  return driver;
}

}  // namespace

std::uint64_t use_file_of_child(hid_t access) {
  static const H5FD_class_t kDriver = make_driver();
  static const hid_t kId = H5FDregister(&kDriver);
  next_file = open_in_child(file_of_child());
  H5Pset_driver(access, kId, nullptr);
  return next_file.descriptor < 0 ? 0 : next_file.bytes;
}

}  // namespace thew::sim
