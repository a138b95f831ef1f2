// SPDX-License-Identifier: Apache-2.0

// What both passes with light share: how much of the key light reaches a point of view space.
uniform sampler2DShadow shadow_map;
uniform mat4 light_from_view;
uniform vec3 up;  // towards the sky
vec3 in_shadow_map(vec3 p) {
  vec3 s = 0.5 * (light_from_view * vec4(p, 1)).xyz + 0.5;
  return vec3(s.xy, min(s.z, 1.0));  // what lies beyond the map is lit
}
// From two of the four places around it.
float half_lit(vec3 s, vec2 at) {
  return 0.5 * (texture(shadow_map, s - vec3(at, 0)) + texture(shadow_map, s + vec3(at, 0)));
}
vec2 spread_of(float texels) { return texels / vec2(textureSize(shadow_map, 0)); }
