// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace thew {

/// Where files of others (meshes, rigs, characters, caches) are parsed.
enum class ImportMode {
  /// In a forked child process with limits of memory and time, without network and without other
  /// files. A parser that crashes, hangs or takes too much is an Error(kInput) here.
  kIsolated,
  /// In the thread that reads, one reader at a time, for a host in which fork is not allowed or too
  /// dear. Results are the same, and so is each Error for a file that a parser refuses. Given up
  /// are
  /// all limits and the confinement: a damaged or hostile file can crash the host, hang it, take
  /// all
  /// of its memory or, where a parser has a hole, do what the host may do; and a parser may print.
  kInProcess,
};

/// For the whole process, from the next file on; kIsolated until it is called. Any thread may call
/// it.
void set_import_mode(ImportMode mode);

}  // namespace thew
