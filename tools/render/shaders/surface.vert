// SPDX-License-Identifier: Apache-2.0
// A surface in view space, with what its colour is made of.
#version 330 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 coordinate;
layout(location = 3) in float weight;
layout(location = 4) in vec3 tint;
uniform mat4 view_from_world, clip_from_view;
out vec3 at, across;
out vec4 where;
out float share;
flat out vec3 base;
void main() {
  vec4 p = view_from_world * vec4(position, 1);
  at = p.xyz;
  across = mat3(view_from_world) * normal;
  where = coordinate;
  share = weight;
  base = tint;
  gl_Position = clip_from_view * p;
}
