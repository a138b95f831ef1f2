// SPDX-License-Identifier: Apache-2.0

// Of a skin with a window cut into it: how far (m) a place of the rest pose lies in the window.
uniform vec4 cut[6];  // planes of the rest pose
uniform int cuts;
float in_window(vec3 rest) {
  float open = 1e9;
  for (int i = 0; i < cuts; ++i) {
    open = min(open, dot(cut[i].xyz, rest) - cut[i].w);
  }
  return open;
}
