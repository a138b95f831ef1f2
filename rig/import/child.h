// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>

#include "rig/types.h"

namespace thew::rig {

/// A child process in which parsers of others read a file that is not ours. What they crash on,
/// hang on or exhaust ends there, and is Error(kInput) here. Private to the libraries.
///
/// Its limits: memory of 1 GiB and 8 times the file, and for each answer 2 s of processor time and
/// 1 s more for every 8 MiB of file (five times that on the clock, for what waits without working).
/// It has no network, no other process, and of all files those that open_in_child() gives it
/// (confine.h; where the kernel takes no filter, and under the sanitizers, which need more calls
/// than a reader, the limits alone hold).
///
/// It is forked, not executed, so that a program that links the library needs no other beside it.
/// glibc hands a child of a process with threads a sound heap; nothing else is shared here.
///
/// Where the host has asked for it (thew/import.h) there is no such process: `answer` runs in this
/// one, in the thread that asks, without limits. Files are given and errors are reported alike; one
/// reader works at a time, since urdfdom's log and HDF5 are there once in a process.
class Child {
 public:
  using Answer = std::function<std::string(std::string_view request)>;

  /// `answer` runs in the child, for one request after another. `advice` ends each message.
  Child(std::filesystem::path file, std::string advice, const Answer& answer);
  ~Child();
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  /// What `answer` returned; an Error that it threw is thrown here.
  std::string ask(std::string_view request = {});
  /// What it is asked from now on is about this file. Its limits stay: 8 MiB are read within those
  /// of the smallest.
  void turn_to(std::filesystem::path file);
  /// What came is not what `answer` can have sent.
  [[noreturn]] void refuse(const std::string& what) const;

 private:
  std::string answer_here(std::string_view request);
  void receive(void* to, std::size_t bytes);
  void hand_over(const std::string& name);
  [[noreturn]] void fail();

  std::filesystem::path file_, real_;  ///< as given; canonical
  std::string advice_;
  std::uint64_t memory_;  ///< bytes
  unsigned seconds_;      ///< of processor time, for one answer
  int socket_ = -1;
  int process_ = -1;
  Answer answer_;  ///< where it runs in this process; else empty
};

/// While it is held no child is forked, and no reader works in this process. For what uses HDF5 in
/// a host with other threads: a child forked meanwhile would wait for its lock for ever.
std::unique_lock<std::recursive_mutex> keep_from_forking();

// For what runs in the child, or in its place.

/// The canonical path of the file that the child reads.
const std::filesystem::path& file_of_child();
/// A regular file, for reading, which the parent opened.
struct OpenFile {
  int descriptor = -1;  ///< -1: it is none, or lies elsewhere
  std::uint64_t bytes = 0;
};
/// `name` is relative to the folder of file_of_child(), and lies in it or below.
OpenFile open_in_child(const std::filesystem::path& name);
/// All of its bytes; Error(kInput) where it is none, cannot be read or is larger than `limit`.
std::string read_in_child(const std::filesystem::path& name, std::size_t limit);

}  // namespace thew::rig
