// SPDX-License-Identifier: Apache-2.0

// What the passes over the screen share: distance (m) and ray of a texel of the large buffers.
uniform sampler2D depth_map, colour_map, surface_map;
uniform vec2 near_far, tangents, large_size;
float distance_at(ivec2 q) {
  float d = texelFetch(depth_map, q, 0).r;
  return near_far.x * near_far.y / (near_far.y - d * (near_far.y - near_far.x));
}
vec3 ray(ivec2 q) {
  return vec3((2.0 * (vec2(q) + 0.5) / large_size - 1.0) * tangents, -1);
}
