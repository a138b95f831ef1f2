// SPDX-License-Identifier: Apache-2.0
// The skin in the window casts no shadow.
#version 330 core
#include "window.glsl"

in vec3 rest;
void main() {
  if (in_window(rest) > 0.0) discard;
}
