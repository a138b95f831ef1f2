// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace thew::tools {

/// The ball of `assets/paper/ball.toml` (885 nodes) squeezed to half its height and held: ours by
/// every method, Bullet's soft body and linear finite elements in one run. Writes ball.svg (cost
/// against the mean distance from the converged neo-Hookean ball), ball_volume.svg and ball.csv
/// into the folder, and pictures of the first two where rsvg-convert is installed.
/// `scenes`: where the ball's scene lies. Errors as those of a bake.
void draw_ball_chart(const std::filesystem::path& scenes, const std::filesystem::path& out);

}  // namespace thew::tools
