// SPDX-License-Identifier: Apache-2.0
// Light on what is seen. Of what surrounds a place each of a pixel's four samples looks at another
// part, since their mean is all that is shown.
#version 330 core
#include "depth.glsl"
#include "shadow.glsl"

uniform sampler2D occlusion_map;
uniform vec3 key;     // towards the key light
uniform float texel;  // of the shadow map (m)
out vec4 lit_colour;

vec3 shade(ivec2 q, float z, float open) {
  vec4 texel_colour = texelFetch(colour_map, q, 0), s = texelFetch(surface_map, q, 0);
  vec3 albedo = texel_colour.rgb * texel_colour.rgb;
  int look = int(s.a * 3.0 + 0.5);
  if (look == 3) return albedo;
  vec3 n = normalize(2.0 * s.xyz - 1.0), p = ray(q) * z, v = normalize(-p);
  float facing = dot(n, key);
  vec2 at = (((q.x ^ q.y) & 1) == 0 ? vec2(1.0, 0.4) : vec2(-0.4, 1.0)) * spread_of(1.0);
  float shadow = facing <= 0.0 ? 0.0 : half_lit(in_shadow_map(p + n * texel * 1.5), at);
  vec3 direct = vec3(max(facing, 0.0) * shadow);
  if (look == 2) {  // light that wanders under the skin comes out red beyond the terminator
    vec3 wrap = vec3(0.40, 0.16, 0.10);
    float sheltered = mix(1.0, shadow, smoothstep(0.0, 0.35, facing));
    direct = clamp((facing + wrap) / (1.0 + wrap), 0.0, 1.0) *
             mix(vec3(0.22, 0.04, 0.02), vec3(1), sheltered);
  }
  vec3 sky = mix(vec3(0.25, 0.23, 0.22), vec3(0.50, 0.53, 0.58), 0.5 * dot(n, up) + 0.5);
  float rim = pow(1.0 - max(dot(n, v), 0.0), 3.0) * (0.5 + 0.5 * dot(n, up));
  vec3 light = 1.05 * vec3(1.0, 0.975, 0.94) * direct + sky * open * mix(albedo, vec3(1), open);
  float glint = max(dot(n, normalize(key + v)), 0.0);
  glint *= glint; glint *= glint; glint *= glint; glint *= glint;  // to the 16th
  float shine = texel_colour.a * (0.35 * glint + 0.5 * glint * glint * glint) * shadow * open;
  return albedo * light + 0.42 * shine + 0.10 * rim * open * open;
}

// Of the 4 x 4 block of pixels in which each turn of the disc occurs once a quarter, and a little of
// the pixel itself, without other surfaces.
float openness(ivec2 q, float z) {
  vec2 total = vec2(1e-4);
  for (int i = 0; i < 5; ++i) {
    ivec2 at = q / 2 + (i < 4 ? 2 * ivec2(i & 1, i >> 1) + (q & 1) - 2 : ivec2(0));
    vec2 o = texelFetch(occlusion_map, clamp(at, ivec2(0), ivec2(large_size) / 2 - 1), 0).rg;
    float alike = max(1.0 - abs(o.y - z) / (0.02 * z), 0.0);
    total += (i < 4 ? 1.0 : 0.1) * alike * vec2(o.x, 1);
  }
  return total.x / total.y;
}

void main() {
  ivec2 q = ivec2(gl_FragCoord.xy);
  float z = distance_at(q);
  lit_colour = vec4(sqrt(shade(q, z, openness(q, z))), 1);
}
