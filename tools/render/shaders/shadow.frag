// SPDX-License-Identifier: Apache-2.0
// Only the depth is kept.
#version 330 core
void main() {}
