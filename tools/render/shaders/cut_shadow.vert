// SPDX-License-Identifier: Apache-2.0
// As shadow.vert, with the rest position, which tells whether it lies in the window.
#version 330 core
layout(location = 0) in vec3 position;
layout(location = 2) in vec4 coordinate;
uniform mat4 light_from_world;
out vec3 rest;
void main() {
  rest = coordinate.xyz;
  gl_Position = light_from_world * vec4(position, 1);
}
