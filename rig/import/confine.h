// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace thew::rig {

/// From here on the process has memory, the clock and the descriptors it holds: it can open no file
/// and see none (EPERM), and is ended (SIGSYS) where it asks for a network, another process or
/// program, or the memory of others. For good, and for what it would start. False, and all as
/// before, where the kernel takes no filter, as in a container that forbids it. Private to the
/// library.
bool confine_process();

}  // namespace thew::rig
