// SPDX-License-Identifier: Apache-2.0
// Covers the target with one triangle.
#version 330 core
void main() {
  gl_Position = vec4(4.0 * float(gl_VertexID & 1) - 1.0, 2.0 * float(gl_VertexID & 2) - 1.0, 1, 1);
}
