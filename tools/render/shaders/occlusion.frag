// SPDX-License-Identifier: Apache-2.0
// How much of the hemisphere over a point is closed within `radius`, from the depths around it.
#version 330 core
#include "depth.glsl"

const int kTaps = 12;
uniform float radius;      // m
uniform vec2 taps[kTaps];  // in the unit disc
uniform vec2 turns[16];    // unit vectors: the disc is turned from pixel to pixel of a 4 x 4 block
out vec2 open_and_distance;
void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy), q = 2 * pixel + 1;  // the texel that a blit takes
  float z = distance_at(q);
  vec3 p = ray(q) * z, n = 2.0 * texelFetch(surface_map, q, 0).xyz - 1.0;
  vec2 turn = turns[(pixel.y & 3) * 4 + (pixel.x & 3)];
  vec2 reach = 0.5 * radius / (z * tangents) * large_size;
  float closed = 0.0;
  for (int i = 0; i < kTaps; ++i) {
    vec2 tap = mat2(turn, vec2(-turn.y, turn.x)) * taps[i];
    ivec2 at = clamp(q + ivec2(round(tap * reach)), ivec2(0), ivec2(large_size) - 1);
    vec3 v = ray(at) * distance_at(at) - p;
    float vv = max(dot(v, v), 1e-12);
    closed += max(dot(v, n) * inversesqrt(vv) - 0.08, 0.0) * max(1.0 - vv / (radius * radius), 0.0);
  }
  open_and_distance = vec2(max(1.0 - 2.8 * closed / float(kTaps), 0.0), z);
}
