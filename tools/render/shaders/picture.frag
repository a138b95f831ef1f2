// SPDX-License-Identifier: Apache-2.0
// The mean of 2 x 2 lit samples a pixel, over ground and background.
#version 330 core
#include "depth.glsl"
#include "shadow.glsl"

uniform sampler2D lit_map;
uniform vec3 centre;          // of the scene at rest
uniform float ground;         // height of the ground over the eye (m)
uniform float ground_radius;  // m, 0: no ground
out vec4 pixel_colour;

vec3 background(vec2 q) {
  vec2 s = q / large_size;
  float v = 0.93 - 0.07 * (1.0 - s.y) - 0.06 * dot(s - 0.5, s - 0.5);
  return v * v * vec3(1.0, 0.995, 0.985);
}

// Over a square of 11 texels. Where its middle and its quarters agree, it is lit or dark all over.
float ground_lit(vec3 s) {
  vec2 e = spread_of(1.5);
  float some = half_lit(s, vec2(3.0, 1.0) * e) + half_lit(s, vec2(-1.0, 3.0) * e) +
               texture(shadow_map, s);
  if (some <= 0.0 || some >= 3.0) return some / 3.0;
  float lit = 0.0;
  for (int i = 0; i < 4; ++i) {
    lit += half_lit(s, vec2(2 * i - 3, 1.0) * e) + half_lit(s, vec2(2 * i - 3, 3.0) * e);
  }
  return lit / 8.0;
}

vec3 behind(ivec2 q) {
  vec3 grey = background(vec2(q)), r = ray(q);
  float slope = dot(r, up);
  if (ground_radius <= 0.0 || slope * ground <= 0.0 || ground > 0.0) return grey;
  vec3 p = r * (ground / slope);
  vec3 d = p - centre;
  d -= dot(d, up) * up;
  float fade = 1.0 - smoothstep(0.5, 3.0, length(d) / ground_radius);
  if (fade <= 0.0) return grey;
  float lit = ground_lit(in_shadow_map(p));
  // A shadow that reaches beyond the picture fades before its edge, which would cut it.
  vec2 from_edge = min(vec2(q), large_size - vec2(q)) / large_size.y;
  fade *= smoothstep(0.0, 0.06, min(from_edge.x, from_edge.y));
  return grey * mix(1.0, mix(0.60, 1.02, lit), fade);
}

void main() {
  ivec2 q = 2 * ivec2(gl_FragCoord.xy);
  vec4 sum = vec4(0);
  for (int i = 0; i < 4; ++i) {
    vec4 c = texelFetch(lit_map, q + ivec2(i & 1, i >> 1), 0);
    sum += vec4(c.rgb * c.rgb, c.a);
  }
  pixel_colour = vec4(sqrt(0.25 * (sum.rgb + (4.0 - sum.a) * behind(q))), 1);
}
