// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace thew::rig {

/// Confines the process by a seccomp filter to memory, the clock and the descriptors that are open.
/// It can then open or look up no file (EPERM), and is ended (SIGSYS) if it asks for a network,
/// another process or program, or the memory of others. This cannot be undone, and child processes
/// inherit it. Returns false, and changes nothing, if the kernel accepts no filter, as in a
/// container that forbids it. Private to the library.
bool confine_process();

}  // namespace thew::rig
