// SPDX-License-Identifier: Apache-2.0

// What both passes with light share: how much of the key light reaches a point of view space.
uniform sampler2DShadow shadow_map;
uniform mat4 light_from_view;
uniform vec3 up;  // towards the sky
vec3 in_shadow_map(vec3 p) {
  vec3 s = 0.5 * (light_from_view * vec4(p, 1)).xyz + 0.5;
  return vec3(s.xy, min(s.z, 1.0));  // what lies beyond the map is lit
}
float lit(vec3 p, float spread) {
  vec3 s = in_shadow_map(p);
  vec2 e = spread / vec2(textureSize(shadow_map, 0));
  return 0.25 * (texture(shadow_map, s + vec3(-e.x, -0.4 * e.y, 0)) +
                 texture(shadow_map, s + vec3(0.4 * e.x, -e.y, 0)) +
                 texture(shadow_map, s + vec3(e.x, 0.4 * e.y, 0)) +
                 texture(shadow_map, s + vec3(-0.4 * e.x, e.y, 0)));
}
