// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rig/character.h"

namespace thew::rig {

/// Makes one skeleton of two. Clothes and hair often come with a copy of the body's skeleton: names
/// that occur twice, at one place. A body is a twin of one before it where the file names them
/// alike (the reader has added `_2`), both stand at one place in the bind pose and at rest, neither
/// is above the other and no animation moves both of them apart. Its weights then count for the
/// first, and it hangs on the first, so that whatever moves the one moves the other; where an
/// animation moves the twin alone, it moves the first. Fills `twins` and appends to `warnings`.
void join_twins(Character& character);

}  // namespace thew::rig
