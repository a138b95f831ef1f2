// SPDX-License-Identifier: Apache-2.0
#include "sim/cache/hash.h"

#include <bit>

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace thew::sim {

static_assert(std::endian::native == std::endian::little, "hashes and parts are little-endian");

struct Hash::State {
  XXH3_state_t xxh;
};

Hash::Hash() : state_(new State) { XXH3_128bits_reset(&state_->xxh); }
Hash::~Hash() = default;

void Hash::add(const void* bytes, std::size_t count) {
  if (count > 0) XXH3_128bits_update(&state_->xxh, bytes, count);
}

std::string Hash::hex() const {
  XXH128_canonical_t canonical;  // big-endian, as xxhsum prints it
  XXH128_canonicalFromHash(&canonical, XXH3_128bits_digest(&state_->xxh));
  std::string text;
  for (const unsigned char byte : canonical.digest) {
    text += "0123456789abcdef"[byte >> 4];
    text += "0123456789abcdef"[byte & 15];
  }
  return text;
}

std::string hash_of(std::string_view bytes) {
  Hash hash;
  hash.add(bytes);
  return hash.hex();
}

}  // namespace thew::sim
