// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <hdf5.h>

#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "rig/types.h"

namespace thew::sim {

/// One object of HDF5, closed at the end of its life.
class Hdf5Id {
 public:
  Hdf5Id() = default;
  Hdf5Id(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  Hdf5Id(Hdf5Id&& other) noexcept { swap(other); }
  Hdf5Id& operator=(Hdf5Id&& other) noexcept {
    swap(other);
    return *this;
  }
  ~Hdf5Id() {
    if (id_ >= 0) close_(id_);
  }
  operator hid_t() const { return id_; }
  /// Closes the object and returns HDF5's result, negative on failure. Closing writes the last
  /// bytes of a dataset or file.
  herr_t close() { return id_ < 0 ? 0 : close_(std::exchange(id_, -1)); }

 private:
  void swap(Hdf5Id& other) {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
  }
  hid_t id_ = -1;
  herr_t (*close_)(hid_t) = nullptr;
};

using Hdf5Dims = std::vector<hsize_t>;

struct Hdf5Dataset {
  Hdf5Id id;
  hid_t type = -1;  ///< the one of the accepted types that it has
  Hdf5Dims dims;
  hsize_t rows = 0;  ///< of a chunk
};

/// A file of HDF5 in the one dialect that Thew writes and accepts: newest format, no object times
/// (equal content, equal bytes), hard links only, every dataset chunked in equal blocks of rows
/// with shuffle, deflate 1 and Fletcher32. Each call checks what it does and throws Error with
/// file, cause and next move: kOutput where the file was created here, kInput where it was opened.
class Hdf5File {
 public:
  /// kRead only in a reader's child process (rig/import/child.h), for the file that it was given.
  enum class Mode { kCreate, kRead };
  Hdf5File(const std::filesystem::path& file, Mode mode);

  const Hdf5Id& root() const { return root_; }
  /// Afterwards the operating system has all that was written.
  void close();
  [[noreturn]] void fail(const std::string& what) const;

  Hdf5Id create_group(hid_t parent, const std::string& name);
  /// Stored in chunks of `rows` rows of the first dimension.
  Hdf5Dataset create_dataset(hid_t parent, const std::string& name, hid_t type,
                             const Hdf5Dims& dims, hsize_t rows);
  void write_chunk(const Hdf5Dataset& dataset, hid_t memory_type, hsize_t first,
                   const void* values);
  /// Creates and writes a dataset in one chunk.
  void write_dataset(hid_t parent, const std::string& name, hid_t type, hid_t memory_type,
                     const Hdf5Dims& dims, const void* values);
  void write_attribute(hid_t object, const std::string& name, const std::string& value);
  void write_attribute(hid_t object, const std::string& name, hid_t type, hid_t memory_type,
                       const void* value);
  void close(Hdf5Id& object);

  /// Names of the links of a group, sorted.
  std::vector<std::string> names(hid_t group) const;
  bool has(hid_t group, const std::string& name) const;
  bool has_attribute(hid_t object, const std::string& name) const;
  /// Each group and dataset of a file may be opened only once, since hard links may form cycles or
  /// multiply a small file.
  Hdf5Id open_group(hid_t parent, const std::string& name) const;
  /// Refuses a dataset whose type is none of `types`, or whose rank, layout, filters or chunks
  /// differ from create_dataset(), or that claims more numbers than the file can hold. `rows` of a
  /// chunk; 0: all in one chunk.
  Hdf5Dataset open_dataset(hid_t parent, const std::string& name, const std::vector<hid_t>& types,
                           std::size_t rank, hsize_t rows = 0) const;
  bool is_group(hid_t parent, const std::string& name) const;
  /// Refuses the chunk that begins at row `first` unless it lies inside the file and can hold as
  /// many numbers as it claims. To be called before memory is allocated for it.
  void check_chunk(const Hdf5Dataset& dataset, hsize_t first) const;
  /// The chunk that begins at row `first`, checked.
  void read_chunk(const Hdf5Dataset& dataset, hid_t memory_type, hsize_t first, void* values) const;
  std::string read_text_attribute(hid_t object, const std::string& name) const;
  void read_attribute(hid_t object, const std::string& name, hid_t type, hid_t memory_type,
                      void* value) const;

 private:
  Hdf5Id checked(hid_t id, herr_t (*close)(hid_t), const std::string& what) const;
  void check(long long result, const std::string& what) const;
  void check_hard_link(hid_t parent, const std::string& name) const;
  void open_once(hid_t parent, const std::string& name) const;

  std::filesystem::path path_;
  Mode mode_;
  std::uintmax_t length_ = 0;  ///< bytes, of a file that is read
  Hdf5Id file_, root_;
  mutable std::set<haddr_t> opened_;  ///< addresses of objects that were opened
};

}  // namespace thew::sim
