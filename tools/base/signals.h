// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace thew::tools {

/// Set by SIGTERM and SIGINT: the frame is finished and flushed, then the job ends with 75.
bool interrupted();
void listen_for_signals();
/// Error(kRetry) after such a signal.
void stop_if_interrupted();

}  // namespace thew::tools
