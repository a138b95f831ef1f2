// SPDX-License-Identifier: Apache-2.0
//
// Compound: its properties, then their headers. Array or scalar: its samples, an array's each
// followed by its dimensions, which are empty where they follow from the size. Sample: 16 bytes of
// identity, then the values. Object: its compound, its children, then the children's headers and 32
// bytes of identity.
#include "tools/export/abc_archive.h"

#include <algorithm>
#include <limits>

#include "sim/cache/hash.h"

namespace thew::tools {
namespace {

constexpr std::int32_t kFileVersion = 0;
constexpr std::int32_t kLibraryVersion = 10709;  // the version of the layout: Alembic 1.7.9

std::string digest_of(std::string_view bytes) {
  const std::string hex = sim::hash_of(bytes);
  std::string digest;
  for (std::size_t i = 0; i < 32; i += 2) {
    digest += static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16));
  }
  return digest;
}

bool is_constant(const AbcProperty& property) {
  return std::count(property.samples.begin(), property.samples.end(), property.samples.front()) ==
         static_cast<std::ptrdiff_t>(property.samples.size());
}

// By sampling: its samples, seconds a cycle, the seconds in it. The first sampling is every
// archive's own.
std::string samplings(const AbcTimes& times) {
  std::string bytes;
  put<std::uint32_t>(bytes, 0);
  put(bytes, 1.0);
  put<std::uint32_t>(bytes, 1);
  put(bytes, 0.0);
  put(bytes, times.count);
  put(bytes, times.every > 0.0 ? times.every : std::numeric_limits<double>::max() / 32.0);
  put(bytes, static_cast<std::uint32_t>(times.seconds.size()));
  for (const double time : times.seconds) put(bytes, time);
  return bytes;
}

}  // namespace

void AbcArchive::add(AbcProperty& property, const std::string& values) {
  const std::string digest = digest_of(values);
  auto& place = places_[digest];
  if (place == 0) {
    place = out_.add_leaf(digest + values);
    digests_[place] = digest;
  }
  property.samples.push_back(place);
}

std::uint32_t AbcArchive::number_of(const std::string& text) {
  if (text.empty()) return 0;
  const auto found = std::find(texts_.begin(), texts_.end(), text);
  const auto number = static_cast<std::uint32_t>(found - texts_.begin()) + 1;
  if (found == texts_.end()) texts_.push_back(text);
  return number;
}

// Bits: 0-1 type, 2-3 width of the counts below (2: 32 bits), 4-7 number type, 8 has a time
// sampling, 10 all samples of one size, 11 constant, 12-19 numbers in a value, 20-27 shared text.
std::string AbcArchive::header(const AbcProperty& property) {
  std::string bytes;
  std::uint32_t bits = 2u << 2 | number_of(property.meta) << 20 | property.type;
  if (property.type != AbcProperty::kCompound) {
    bits |= std::uint32_t{property.number} << 4 | 1u << 8 | 1u << 10 | property.extent << 12;
    if (is_constant(property)) bits |= 1u << 11;
  }
  put(bytes, bits);
  if (property.type != AbcProperty::kCompound) {
    put(bytes, count_);
    put<std::uint32_t>(bytes, 1);  // the second time sampling, the shot's
  }
  put(bytes, static_cast<std::uint32_t>(property.name.size()));
  return bytes + property.name;
}

AbcArchive::Written AbcArchive::write(const AbcProperty& property) {
  if (property.type == AbcProperty::kCompound) return write(property.below);
  std::vector<std::uint64_t> children;
  std::string identity;
  const std::size_t count = is_constant(property) ? 1 : property.samples.size();
  for (std::size_t i = 0; i < count; ++i) {
    children.push_back(property.samples[i]);
    if (property.type == AbcProperty::kArray) children.push_back(OgawaFile::kLeaf);
    identity += digests_.at(property.samples[i]);
  }
  return {out_.add_group(children), digest_of(identity)};
}

AbcArchive::Written AbcArchive::write(const std::vector<AbcProperty>& properties) {
  std::vector<std::uint64_t> children;
  std::string headers, identity;
  for (const AbcProperty& property : properties) {
    const Written written = write(property);
    children.push_back(written.place);
    identity += property.name + written.identity;
    headers += header(property);
  }
  if (children.empty()) return {0, digest_of("")};
  children.push_back(out_.add_leaf(headers));
  return {out_.add_group(children), digest_of(identity)};
}

AbcArchive::Written AbcArchive::write(const AbcObject& object) {
  const Written properties = write(object.properties);
  std::vector<std::uint64_t> children = {properties.place};
  std::string headers, below;
  for (const AbcObject& child : object.children) {
    const Written written = write(child);
    children.push_back(written.place);
    put(headers, static_cast<std::uint32_t>(child.name.size()));
    headers += child.name + static_cast<char>(number_of(child.meta));
    below += child.name + written.identity;
  }
  const std::string identity = properties.identity + digest_of(below);
  children.push_back(out_.add_leaf(headers + identity));
  return {out_.add_group(children), digest_of(identity)};
}

void AbcArchive::finish(const AbcObject& top, const std::string& meta, const AbcTimes& times) {
  count_ = times.count;
  const std::uint64_t root = write(top).place;
  std::string file_version, library_version, texts;
  put(file_version, kFileVersion);
  put(library_version, kLibraryVersion);
  for (const std::string& text : texts_) texts += static_cast<char>(text.size()) + text;
  const std::uint64_t versions[] = {out_.add_leaf(file_version), out_.add_leaf(library_version)};
  const std::uint64_t infos[] = {out_.add_leaf(meta), out_.add_leaf(samplings(times)),
                                 out_.add_leaf(texts)};
  out_.finish(out_.add_group({versions[0], versions[1], root, infos[0], infos[1], infos[2]}));
}

}  // namespace thew::tools
