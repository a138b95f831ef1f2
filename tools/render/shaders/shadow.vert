// SPDX-License-Identifier: Apache-2.0
// A surface in the shadow map, of which only the depth is kept.
#version 330 core
layout(location = 0) in vec3 position;
uniform mat4 light_from_world;
void main() { gl_Position = light_from_world * vec4(position, 1); }
