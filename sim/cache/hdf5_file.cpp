// SPDX-License-Identifier: Apache-2.0
#include "sim/cache/hdf5_file.h"

#include <libdeflate.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <new>

#include "sim/cache/hdf5_driver.h"

namespace thew::sim {
namespace {

// Deflate shrinks by no more than this factor, so the size of a file limits the size of its
// contents.
constexpr hsize_t kDeflateRatio = 1032;
constexpr int kDeflateLevel = 1;
constexpr hsize_t kSlack = 1024;  // bytes, for small chunks
constexpr std::size_t kMaxTextBytes = 4096;

// Turns off the library's own messages, since Thew reports errors itself, and its exit handler,
// which crashes after a full disk.
void start_library() {
  static const bool kStarted = [] {
    H5dont_atexit();
    H5open();
    return H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr) >= 0;
  }();
  (void)kStarted;
}

// The deepest entry of the library's stack of errors, without its clock and addresses.
std::string cause() {
  std::string text;
  H5Ewalk2(
      H5E_DEFAULT, H5E_WALK_UPWARD,
      [](unsigned depth, const H5E_error2_t* entry, void* out) -> herr_t {
        if (depth == 0 && entry->desc) *static_cast<std::string*>(out) = entry->desc;
        return 0;
      },
      &text);
  const std::string key = "error message = '";
  if (const auto at = text.find(key); at != std::string::npos) {
    text = text.substr(at + key.size());
    text = text.substr(0, text.find('\''));
  }
  return text;
}

Hdf5Id property_list(hid_t kind) {
  Hdf5Id list(H5Pcreate(kind), H5Pclose);
  if (kind == H5P_FILE_CREATE || kind == H5P_GROUP_CREATE || kind == H5P_DATASET_CREATE) {
    H5Pset_obj_track_times(list, false);
  }
  return list;
}

Hdf5Id text_type(std::size_t length) {
  Hdf5Id type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, std::max<std::size_t>(length, 1));
  H5Tset_strpad(type, H5T_STR_NULLPAD);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return type;
}

bool multiply(const Hdf5Dims& dims, hsize_t& product) {
  return std::none_of(dims.begin(), dims.end(),
                      [&](hsize_t n) { return __builtin_mul_overflow(product, n, &product); });
}

hsize_t chunk_bytes(const Hdf5Dataset& dataset) {
  Hdf5Dims chunk = dataset.dims;
  chunk[0] = dataset.rows;
  hsize_t bytes = H5Tget_size(dataset.type);
  return multiply(chunk, bytes) ? bytes : HSIZE_UNDEF;
}

}  // namespace

Hdf5File::Hdf5File(const std::filesystem::path& file, Mode mode) : path_(file), mode_(mode) {
  start_library();
  const Hdf5Id access = property_list(H5P_FILE_ACCESS);
  H5Pset_fclose_degree(access, H5F_CLOSE_STRONG);
  // HDF5's lock is not needed, since files appear by renaming and a bake locks its folder; some
  // network file systems do not have it.
  H5Pset_file_locking(access, false, true);
  if (mode == Mode::kCreate) {
    H5Pset_libver_bounds(access, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
    const Hdf5Id creation = property_list(H5P_FILE_CREATE);
    file_ = checked(H5Fcreate(file.c_str(), H5F_ACC_EXCL, creation, access), H5Fclose, "create");
  } else {
    length_ = use_file_of_child(access);
    if (length_ == 0) fail("it is not a file that is there");
    file_ = checked(H5Fopen(file.c_str(), H5F_ACC_RDONLY, access), H5Fclose, "open as HDF5");
  }
  root_ = checked(H5Gopen2(file_, "/", H5P_DEFAULT), H5Gclose, "open the root group");
}

void Hdf5File::close() {
  check(root_.close(), "close the root group");
  check(file_.close(), "close");
}

void Hdf5File::fail(const std::string& what) const {
  if (mode_ == Mode::kCreate) {
    throw Error(ErrorCode::kOutput,
                path_.string() + ": " + what + "; free some space and run again");
  }
  throw Error(ErrorCode::kInput,
              path_.string() + ": " + what + "; give a bake.h5 of this version, or bake again");
}

void Hdf5File::check(long long result, const std::string& what) const {
  if (result < 0) {
    const std::string why = cause();
    fail("cannot " + what + (why.empty() ? "" : ": " + why));
  }
}

Hdf5Id Hdf5File::checked(hid_t id, herr_t (*close)(hid_t), const std::string& what) const {
  check(id, what);
  return {id, close};
}

Hdf5Id Hdf5File::create_group(hid_t parent, const std::string& name) {
  const Hdf5Id creation = property_list(H5P_GROUP_CREATE);
  return checked(H5Gcreate2(parent, name.c_str(), H5P_DEFAULT, creation, H5P_DEFAULT), H5Gclose,
                 "create the group " + name);
}

Hdf5Dataset Hdf5File::create_dataset(hid_t parent, const std::string& name, hid_t type,
                                     const Hdf5Dims& dims, hsize_t rows) {
  const Hdf5Id creation = property_list(H5P_DATASET_CREATE);
  Hdf5Dims chunk = dims;
  chunk[0] = rows;
  const int rank = static_cast<int>(dims.size());
  check(H5Pset_chunk(creation, rank, chunk.data()), "lay out " + name);
  check(H5Pset_shuffle(creation), "shuffle " + name);
  check(H5Pset_deflate(creation, kDeflateLevel), "compress " + name);
  check(H5Pset_fletcher32(creation), "protect " + name);
  const Hdf5Id space =
      checked(H5Screate_simple(rank, dims.data(), nullptr), H5Sclose, "lay out " + name);
  return {checked(H5Dcreate2(parent, name.c_str(), type, space, H5P_DEFAULT, creation, H5P_DEFAULT),
                  H5Dclose, "create " + name),
          type, dims, rows};
}

namespace {

/// The part of a dataset that is one chunk.
struct ChunkSpaces {
  Hdf5Id in_file, in_memory;
};

ChunkSpaces chunk_spaces(const Hdf5Dataset& dataset, hsize_t first) {
  Hdf5Dims offset(dataset.dims.size(), 0), count = dataset.dims;
  offset[0] = first;
  count[0] = dataset.rows;
  const int rank = static_cast<int>(count.size());
  ChunkSpaces spaces{{H5Dget_space(dataset.id), H5Sclose},
                     {H5Screate_simple(rank, count.data(), nullptr), H5Sclose}};
  H5Sselect_hyperslab(spaces.in_file, H5S_SELECT_SET, offset.data(), nullptr, count.data(),
                      nullptr);
  return spaces;
}

}  // namespace

namespace {

hsize_t numbers_of_chunk(const Hdf5Dataset& dataset) {
  return chunk_bytes(dataset) / H5Tget_size(dataset.type);
}

// The first bytes of all numbers, then the second ones and so on, as H5Pset_shuffle() says.
std::string shuffled(const std::string& bytes, std::size_t size) {
  const std::size_t count = bytes.size() / size;
  std::string out(bytes.size(), '\0');
  for (std::size_t k = 0; k < size; ++k) {
    char* const to = out.data() + k * count;
    for (std::size_t i = 0; i < count; ++i) to[i] = bytes[i * size + k];
  }
  return out;
}

// The checksum that H5Pset_fletcher32() appends, of pairs of bytes with the higher one first.
std::uint32_t fletcher32(const std::string& bytes) {
  std::uint32_t sum = 0, sums = 0;
  const auto fold = [](std::uint32_t& of) { of = (of & 0xffff) + (of >> 16); };
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(bytes[i]); };
  constexpr std::size_t kMost = 360;  // pairs, before a sum could overflow
  std::size_t i = 0;
  while (i + 1 < bytes.size()) {
    const std::size_t end = std::min(i + 2 * kMost, bytes.size() - bytes.size() % 2);
    for (; i < end; i += 2) {
      sum += static_cast<std::uint32_t>(byte(i) << 8 | byte(i + 1));
      sums += sum;
    }
    fold(sum);
    fold(sums);
  }
  if (i < bytes.size()) {
    sum += static_cast<std::uint32_t>(byte(i) << 8);
    sums += sum;
    fold(sum);
    fold(sums);
  }
  fold(sum);
  fold(sums);
  return sums << 16 | sum;
}

}  // namespace

// The chunk is packed here and written as it is: the library's own filters take three times as
// long. What it reads is the same.
void Hdf5File::write_chunk(const Hdf5Dataset& dataset, hid_t memory_type, hsize_t first,
                           const void* values) {
  static libdeflate_compressor* const kDeflate = libdeflate_alloc_compressor(kDeflateLevel);
  if (!kDeflate) throw std::bad_alloc();
  const hsize_t count = numbers_of_chunk(dataset);
  const std::size_t stored = H5Tget_size(dataset.type), given = H5Tget_size(memory_type);
  std::string bytes(count * std::max(stored, given), '\0');
  std::memcpy(bytes.data(), values, count * given);
  check(H5Tconvert(memory_type, dataset.type, count, bytes.data(), nullptr, H5P_DEFAULT),
        "convert numbers");
  bytes.resize(count * stored);
  bytes = shuffled(bytes, stored);
  std::string packed(libdeflate_zlib_compress_bound(kDeflate, bytes.size()), '\0');
  packed.resize(
      libdeflate_zlib_compress(kDeflate, bytes.data(), bytes.size(), packed.data(), packed.size()));
  const std::uint32_t sum = fletcher32(packed);
  for (int k = 0; k < 4; ++k) packed.push_back(static_cast<char>(sum >> (8 * k)));
  Hdf5Dims offset(dataset.dims.size(), 0);
  offset[0] = first;
  check(H5Dwrite_chunk(dataset.id, H5P_DEFAULT, 0, offset.data(), packed.size(), packed.data()),
        "write");
}

void Hdf5File::write_dataset(hid_t parent, const std::string& name, hid_t type, hid_t memory_type,
                             const Hdf5Dims& dims, const void* values) {
  Hdf5Dataset dataset = create_dataset(parent, name, type, dims, dims[0]);
  write_chunk(dataset, memory_type, 0, values);
  close(dataset.id);
}

void Hdf5File::write_attribute(hid_t object, const std::string& name, const std::string& value) {
  const Hdf5Id type = text_type(value.size());
  write_attribute(object, name, type, type, value.empty() ? "" : value.data());
}

void Hdf5File::write_attribute(hid_t object, const std::string& name, hid_t type, hid_t memory_type,
                               const void* value) {
  const Hdf5Id space = checked(H5Screate(H5S_SCALAR), H5Sclose, "lay out attribute " + name);
  Hdf5Id attribute =
      checked(H5Acreate2(object, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
              "create attribute " + name);
  check(H5Awrite(attribute, memory_type, value), "write attribute " + name);
  check(attribute.close(), "close attribute " + name);
}

void Hdf5File::close(Hdf5Id& object) { check(object.close(), "close a part of it"); }

std::vector<std::string> Hdf5File::names(hid_t group) const {
  std::vector<std::string> names;
  check(H5Literate(
            group, H5_INDEX_NAME, H5_ITER_INC, nullptr,
            [](hid_t, const char* name, const H5L_info_t*, void* out) -> herr_t {
              static_cast<std::vector<std::string>*>(out)->emplace_back(name);
              return 0;
            },
            &names),
        "list a group");
  std::sort(names.begin(), names.end());
  return names;
}

bool Hdf5File::has(hid_t group, const std::string& name) const {
  return H5Lexists(group, name.c_str(), H5P_DEFAULT) > 0;
}

bool Hdf5File::has_attribute(hid_t object, const std::string& name) const {
  return H5Aexists(object, name.c_str()) > 0;
}

void Hdf5File::check_hard_link(hid_t parent, const std::string& name) const {
  H5L_info_t info;
  check(H5Lget_info(parent, name.c_str(), &info, H5P_DEFAULT), "find " + name);
  if (info.type != H5L_TYPE_HARD) fail(name + " is a link to elsewhere, which is refused");
}

bool Hdf5File::is_group(hid_t parent, const std::string& name) const {
  check_hard_link(parent, name);
  H5O_info_t info;
  check(H5Oget_info_by_name2(parent, name.c_str(), &info, H5O_INFO_BASIC, H5P_DEFAULT),
        "look at " + name);
  return info.type == H5O_TYPE_GROUP;
}

void Hdf5File::open_once(hid_t parent, const std::string& name) const {
  check_hard_link(parent, name);
  if (mode_ == Mode::kCreate) return;
  H5O_info_t info;
  check(H5Oget_info_by_name2(parent, name.c_str(), &info, H5O_INFO_BASIC, H5P_DEFAULT),
        "look at " + name);
  if (!opened_.insert(info.addr).second) fail(name + " is a second link to what was read before");
}

Hdf5Id Hdf5File::open_group(hid_t parent, const std::string& name) const {
  open_once(parent, name);
  return checked(H5Gopen2(parent, name.c_str(), H5P_DEFAULT), H5Gclose, "open the group " + name);
}

Hdf5Dataset Hdf5File::open_dataset(hid_t parent, const std::string& name,
                                   const std::vector<hid_t>& types, std::size_t rank,
                                   hsize_t rows) const {
  open_once(parent, name);
  Hdf5Dataset dataset;
  dataset.id = checked(H5Dopen2(parent, name.c_str(), H5P_DEFAULT), H5Dclose, "open " + name);
  const Hdf5Id stored = checked(H5Dget_type(dataset.id), H5Tclose, "read the type of " + name);
  for (const hid_t type : types) {
    if (H5Tequal(stored, type) > 0) dataset.type = type;
  }
  if (dataset.type < 0) fail(name + " is of another type of number");

  const Hdf5Id creation =
      checked(H5Dget_create_plist(dataset.id), H5Pclose, "read the layout of " + name);
  // Chunked is neither external nor virtual; a virtual one opens other files to tell its size.
  if (H5Pget_layout(creation) != H5D_CHUNKED) fail(name + " is not laid out in chunks");

  const Hdf5Id space = checked(H5Dget_space(dataset.id), H5Sclose, "read the size of " + name);
  if (H5Sget_simple_extent_ndims(space) != static_cast<int>(rank)) {
    fail(name + " does not have " + std::to_string(rank) + " dimensions");
  }
  dataset.dims.resize(rank);
  check(H5Sget_simple_extent_dims(space, dataset.dims.data(), nullptr), "read the size of " + name);
  dataset.rows = rows == 0 ? dataset.dims[0] : rows;
  Hdf5Dims chunk(rank), wanted = dataset.dims;
  wanted[0] = dataset.rows;
  if (H5Pget_chunk(creation, static_cast<int>(rank), chunk.data()) != static_cast<int>(rank) ||
      chunk != wanted) {
    fail(name + " is not laid out in chunks of one frame");
  }
  const std::vector<H5Z_filter_t> filters = {H5Z_FILTER_SHUFFLE, H5Z_FILTER_DEFLATE,
                                             H5Z_FILTER_FLETCHER32};
  bool known = H5Pget_nfilters(creation) == static_cast<int>(filters.size());
  for (unsigned i = 0; known && i < filters.size(); ++i) {
    unsigned flags = 0;
    std::size_t values = 0;
    known =
        H5Pget_filter2(creation, i, &flags, &values, nullptr, 0, nullptr, nullptr) == filters[i];
  }
  if (!known) fail(name + " has other filters than shuffle, deflate and Fletcher32");

  // Each chunk costs some bytes of index at least, and no chunk holds more than the file can.
  if (dataset.dims[0] / std::max<hsize_t>(dataset.rows, 1) > length_ ||
      chunk_bytes(dataset) / kDeflateRatio > length_ + kSlack) {
    fail(name + " claims more numbers than the file has room for");
  }
  return dataset;
}

void Hdf5File::check_chunk(const Hdf5Dataset& dataset, hsize_t first) const {
  Hdf5Dims offset(dataset.dims.size(), 0);
  offset[0] = first;
  unsigned mask = 0;
  haddr_t address = HADDR_UNDEF;
  hsize_t size = 0;
  check(H5Dget_chunk_info_by_coord(dataset.id, offset.data(), &mask, &address, &size),
        "find a chunk");
  if (address == HADDR_UNDEF || address > length_ || size > length_ - address) {
    fail("numbers are missing; the file is not whole");
  }
  if (mask != 0 || chunk_bytes(dataset) > kDeflateRatio * size + kSlack) {
    fail("claims more numbers than it has room for");
  }
}

void Hdf5File::read_chunk(const Hdf5Dataset& dataset, hid_t memory_type, hsize_t first,
                          void* values) const {
  check_chunk(dataset, first);
  const ChunkSpaces spaces = chunk_spaces(dataset, first);
  check(H5Dread(dataset.id, dataset.type, spaces.in_memory, spaces.in_file, H5P_DEFAULT, values),
        "read numbers");
  // Not in the call above, which would clear a buffer of its own of 1 MB each time.
  check(H5Tconvert(dataset.type, memory_type, numbers_of_chunk(dataset), values, nullptr,
                   H5P_DEFAULT),
        "convert numbers");
}

std::string Hdf5File::read_text_attribute(hid_t object, const std::string& name) const {
  const Hdf5Id attribute =
      checked(H5Aopen(object, name.c_str(), H5P_DEFAULT), H5Aclose, "find attribute " + name);
  const Hdf5Id type = checked(H5Aget_type(attribute), H5Tclose, "read attribute " + name);
  const Hdf5Id space = checked(H5Aget_space(attribute), H5Sclose, "read attribute " + name);
  const std::size_t size = H5Tget_size(type);
  if (H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) != 0 || size > kMaxTextBytes ||
      H5Sget_simple_extent_npoints(space) != 1) {
    fail("attribute " + name + " is not a text of fixed length");
  }
  std::string value(size, '\0');
  check(H5Aread(attribute, type, value.data()), "read attribute " + name);
  value.resize(value.find_last_not_of('\0') + 1);
  return value;
}

void Hdf5File::read_attribute(hid_t object, const std::string& name, hid_t type, hid_t memory_type,
                              void* value) const {
  const Hdf5Id attribute =
      checked(H5Aopen(object, name.c_str(), H5P_DEFAULT), H5Aclose, "find attribute " + name);
  const Hdf5Id stored = checked(H5Aget_type(attribute), H5Tclose, "read attribute " + name);
  const Hdf5Id space = checked(H5Aget_space(attribute), H5Sclose, "read attribute " + name);
  if (H5Tequal(stored, type) <= 0 || H5Sget_simple_extent_npoints(space) != 1) {
    fail("attribute " + name + " is of another type");
  }
  check(H5Aread(attribute, memory_type, value), "read attribute " + name);
}

}  // namespace thew::sim
