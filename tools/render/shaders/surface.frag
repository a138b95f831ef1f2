// SPDX-License-Identifier: Apache-2.0
// Colour, gloss, normal and look of what is seen. The renderer defines LOOK behind the version:
// one program for each look, because the driver runs all branches of an `if`.
#version 330 core
#include "window.glsl"

#define MUSCLE 0
#define BONE 1
#define SKIN 2
#define FLAT 3
#define WEIGHT 4
#define CUT 6
in vec3 at, across;
in vec4 where;
in float share;
flat in vec3 base;
uniform float rim;         // m, of the window's edge
uniform float weight_top;  // end of the colour scale, 0: no weights are shown
layout(location = 0) out vec4 colour;   // and gloss
layout(location = 1) out vec4 surface;  // normal, and the look of four that light tells apart

float hash(ivec3 cell) {  // integers: the same on every driver
  uint h = uint(cell.x) * 0x8da6b343u ^ uint(cell.y) * 0xd8163841u ^ uint(cell.z) * 0xcb1ab31fu;
  h = (h ^ (h >> 15)) * 0x2c1b3c6du;
  return float((h ^ (h >> 13)) & 0xffffu) / 65535.0;
}

// Smooth noise 0..1 over the muscle's surface: `cells` fibres a turn, long along u.
float streak(float turn, float u, int cells, float lengths) {
  vec2 p = vec2(turn * float(cells), u * lengths);
  ivec2 c = ivec2(floor(p));
  vec2 f = p - vec2(c);
  f = f * f * (3.0 - 2.0 * f);
  // A remainder would cost more than all the rest: there is no integer division of vectors.
  int x0 = c.x < 0 ? c.x + cells : c.x, x1 = x0 + 1 == cells ? 0 : x0 + 1;
  return mix(mix(hash(ivec3(x0, c.y, cells)), hash(ivec3(x1, c.y, cells)), f.x),
             mix(hash(ivec3(x0, c.y + 1, cells)), hash(ivec3(x1, c.y + 1, cells)), f.x), f.y);
}

float cloud(vec3 p) {
  ivec3 c = ivec3(floor(p));
  vec3 f = p - vec3(c);
  f = f * f * (3.0 - 2.0 * f);
  ivec2 e = ivec2(0, 1);
  vec4 low = vec4(hash(c), hash(c + e.yxx), hash(c + e.xyx), hash(c + e.yyx));
  vec4 high = vec4(hash(c + e.xxy), hash(c + e.yxy), hash(c + e.xyy), hash(c + e.yyy));
  vec4 z = mix(low, high, f.z);
  return mix(mix(z.x, z.y, f.x), mix(z.z, z.w, f.x), f.y);
}

// Tilts the normal against the slope of a height (m) over the screen (Mikkelsen 2010).
vec3 tilt(vec3 n, float height) {
  vec3 dx = dFdx(at), dy = dFdy(at);
  vec3 rx = cross(dy, n), ry = cross(n, dx);
  float area = dot(dx, rx);
  vec3 slope = sign(area) * (dFdx(height) * rx + dFdy(height) * ry);
  return normalize(max(abs(area), 1e-14) * n - slope);
}

void muscle(inout vec3 n) {
  const float kTurn = 6.2831853;
  float turn = atan(where.z, where.y) / kTurn;
  // Of the two ends of the seam: the width of a pixel in turns, from the direction itself.
  float pixel = length(fwidth(where.yz)) / (kTurn * max(length(where.yz), 0.1));
  float u = where.x + 7.0 * base.g;  // another pattern for each muscle
  float fibres = 0.0, coarse = 0.0;
  int cells[4] = int[4](13, 31, 67, 139);
  float depth[4] = float[4](0.32, 0.55, 0.55, 0.45);
  for (int i = 0; i < 4; ++i) {
    // Strands finer than two pixels fade to their mean.
    float seen = 1.0 - smoothstep(0.25, 0.6, pixel * float(cells[i]));
    if (seen <= 0.0) break;
    float strand = depth[i] * seen * (streak(turn, u, cells[i], 2.5 + 3.0 * float(i)) - 0.5);
    fibres += strand;
    if (i < 3) coarse += strand / (1.0 + float(i));
  }
  float belly = smoothstep(0.3, 0.7, where.w + 0.55 * fibres * where.w * (1.0 - where.w) * 4.0);
  vec3 red = base * (1.0 + 0.75 * fibres);
  red = mix(red, vec3(0.80, 0.52, 0.47), 0.30 * smoothstep(0.18, 0.5, fibres));  // fat between
  vec3 pale = vec3(0.90, 0.865, 0.80) * (1.0 + 0.22 * fibres);
  colour = vec4(mix(pale, red, belly), mix(0.55, 0.42, belly));
  n = tilt(n, 0.0009 * coarse * (0.3 + 0.7 * belly));
}

vec3 weight_colour(float t) {  // pale, amber, crimson, aubergine
  const vec3 k[4] = vec3[4](vec3(0.93, 0.92, 0.87), vec3(0.95, 0.72, 0.36), vec3(0.80, 0.27, 0.22),
                            vec3(0.33, 0.07, 0.24));
  t = 3.0 * clamp(t, 0.0, 1.0);
  vec3 c = mix(k[0], k[1], clamp(t, 0.0, 1.0));
  c = mix(c, k[2], clamp(t - 1.0, 0.0, 1.0));
  return mix(c, k[3], clamp(t - 2.0, 0.0, 1.0));
}

void main() {
  vec3 n = normalize(gl_FrontFacing ? across : -across);
#if LOOK == MUSCLE
  muscle(n);
#elif LOOK == BONE
  float mottle = cloud(90.0 * where.xyz) + 0.5 * cloud(260.0 * where.xyz) - 0.75;
  vec3 ivory = weight_top > 0.0 ? vec3(0.76, 0.77, 0.78) : base;
  colour = vec4(ivory * (1.0 + 0.09 * mottle), 0.22);
#elif LOOK == SKIN || LOOK == CUT
#if LOOK == CUT
  float open = in_window(where.xyz);
  if (open > 0.0) discard;
#endif
  float mottle = cloud(55.0 * where.xyz) + 0.6 * cloud(170.0 * where.xyz) - 0.8;
  colour = vec4(base * (vec3(1) + mottle * vec3(0.035, 0.06, 0.065)), 0.3);
#if LOOK == CUT
  if (!gl_FrontFacing || open > -rim) colour = vec4(0.93, 0.83, 0.62, 0.3);  // fat
#endif
#elif LOOK == WEIGHT
  colour = vec4(share < 0.0 ? vec3(0.6) : weight_colour(share / weight_top), 0.15);
#else
  colour = vec4(base, 0.0);
#endif
  surface = vec4(0.5 * n + 0.5, float(LOOK & 3) / 3.0);
}
