// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace thew::tools {

/// Of which commit the program was built, "-dirty" behind it where files had changed since;
/// "unknown" where that was no checkout. Written when the program is built, and linked into it
/// alone.
extern const char* const kCommit;

}  // namespace thew::tools
