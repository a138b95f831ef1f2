// SPDX-License-Identifier: Apache-2.0
#pragma once

// GLSL 3.30 core. All is in view space (the eye at 0, looking along -z) unless it says world.
// Colours are stored as square roots of light (gamma 2: cheap, and near enough to sRGB).
namespace thew::shaders {

// Covers the target with one triangle.
inline constexpr char kScreenVertex[] = R"(#version 330 core
void main() {
  gl_Position = vec4(4.0 * float(gl_VertexID & 1) - 1.0, 2.0 * float(gl_VertexID & 2) - 1.0, 1, 1);
})";

inline constexpr char kShadowVertex[] = R"(#version 330 core
layout(location = 0) in vec3 position;
uniform mat4 light_from_world;
void main() { gl_Position = light_from_world * vec4(position, 1); }
)";

inline constexpr char kShadowFragment[] = R"(#version 330 core
void main() {})";

// Of a skin with a window cut into it. THEW_CUT goes after kVersion: metres into the window.
#define THEW_CUT                                              \
  "uniform vec4 cut[6];  // planes of the rest pose\n"        \
  "uniform int cuts;\n"                                       \
  "float in_window(vec3 rest) {\n"                            \
  "  float open = 1e9;\n"                                     \
  "  for (int i = 0; i < cuts; ++i) {\n"                      \
  "    open = min(open, dot(cut[i].xyz, rest) - cut[i].w);\n" \
  "  }\n"                                                     \
  "  return open;\n"                                          \
  "}\n"
inline constexpr char kCutShadowVertex[] = R"(#version 330 core
layout(location = 0) in vec3 position;
layout(location = 2) in vec4 coordinate;
uniform mat4 light_from_world;
out vec3 rest;
void main() {
  rest = coordinate.xyz;
  gl_Position = light_from_world * vec4(position, 1);
})";
inline constexpr char kCutShadowFragment[] = "#version 330 core\n" THEW_CUT R"(
in vec3 rest;
void main() {
  if (in_window(rest) > 0.0) discard;
})";

inline constexpr char kSurfaceVertex[] = R"(#version 330 core
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
})";

// Colour, gloss, normal and look of what is seen. Goes after kVersion and "#define LOOK n", n being
// a Look: one program for each, because the driver runs all branches of an `if`.
inline constexpr char kVersion[] = "#version 330 core\n";
inline constexpr char kSurfaceFragment[] = THEW_CUT R"(
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
})";

// What both passes over the screen share. Depth and view position of a texel of the large buffers.
#define THEW_SCREEN_COMMON                                                             \
  "#version 330 core\n"                                                                \
  "uniform sampler2D depth_map, colour_map, surface_map;\n"                            \
  "uniform vec2 near_far, tangents, large_size;\n"                                     \
  "float distance_at(ivec2 q) {\n"                                                     \
  "  float d = texelFetch(depth_map, q, 0).r;\n"                                       \
  "  return near_far.x * near_far.y / (near_far.y - d * (near_far.y - near_far.x));\n" \
  "}\n"                                                                                \
  "vec3 ray(ivec2 q) {\n"                                                              \
  "  return vec3((2.0 * (vec2(q) + 0.5) / large_size - 1.0) * tangents, -1);\n"        \
  "}\n"

// How much of the hemisphere over a point is closed within `radius`, from the depths around it.
inline constexpr char kOcclusionFragment[] = THEW_SCREEN_COMMON R"(
const int kTaps = 12;
uniform float radius;      // m
uniform vec2 taps[kTaps];  // in the unit disc
uniform vec2 turns[16];    // unit vectors: the disc is turned from pixel to pixel of a 4 x 4 block
out vec2 open_and_distance;
void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy), q = 2 * pixel + 1;  // the texel that a blit takes
  float z = distance_at(q);
  vec3 p = ray(q) * z, n = 2.0 * texelFetch(surface_map, q, 0).xyz - 1.0;
  vec2 turn = turns[(pixel.y & 3) * 4 + (pixel.x & 3)];
  vec2 reach = 0.5 * radius / (z * tangents) * large_size;
  float closed = 0.0;
  for (int i = 0; i < kTaps; ++i) {
    vec2 tap = mat2(turn, vec2(-turn.y, turn.x)) * taps[i];
    ivec2 at = clamp(q + ivec2(round(tap * reach)), ivec2(0), ivec2(large_size) - 1);
    vec3 v = ray(at) * distance_at(at) - p;
    float vv = max(dot(v, v), 1e-12);
    closed += max(dot(v, n) * inversesqrt(vv) - 0.08, 0.0) * max(1.0 - vv / (radius * radius), 0.0);
  }
  open_and_distance = vec2(max(1.0 - 2.8 * closed / float(kTaps), 0.0), z);
})";

#define THEW_SHADOW_COMMON                                                    \
  "uniform sampler2DShadow shadow_map;\n"                                     \
  "uniform mat4 light_from_view;\n"                                           \
  "uniform vec3 up;  // towards the sky\n"                                    \
  "vec3 in_shadow_map(vec3 p) {\n"                                            \
  "  vec3 s = 0.5 * (light_from_view * vec4(p, 1)).xyz + 0.5;\n"              \
  "  return vec3(s.xy, min(s.z, 1.0));  // what lies beyond the map is lit\n" \
  "}\n"                                                                       \
  "float lit(vec3 p, float spread) {\n"                                       \
  "  vec3 s = in_shadow_map(p);\n"                                            \
  "  vec2 e = spread / vec2(textureSize(shadow_map, 0));\n"                   \
  "  return 0.25 * (texture(shadow_map, s + vec3(-e.x, -0.4 * e.y, 0)) +\n"   \
  "                 texture(shadow_map, s + vec3(0.4 * e.x, -e.y, 0)) +\n"    \
  "                 texture(shadow_map, s + vec3(e.x, 0.4 * e.y, 0)) +\n"     \
  "                 texture(shadow_map, s + vec3(-0.4 * e.x, e.y, 0)));\n"    \
  "}\n"

// Light on what is seen.
inline constexpr char kLightFragment[] = THEW_SCREEN_COMMON THEW_SHADOW_COMMON R"(
uniform sampler2D occlusion_map;
uniform vec3 key;     // towards the key light
uniform float texel;  // of the shadow map (m)
out vec4 lit_colour;

vec3 shade(ivec2 q, float z, float open) {
  vec4 texel_colour = texelFetch(colour_map, q, 0), s = texelFetch(surface_map, q, 0);
  vec3 albedo = texel_colour.rgb * texel_colour.rgb;
  int look = int(s.a * 3.0 + 0.5);
  if (look == 3) return albedo;
  vec3 n = normalize(2.0 * s.xyz - 1.0), p = ray(q) * z, v = normalize(-p);
  float facing = dot(n, key);
  float shadow = facing <= 0.0 ? 0.0 : lit(p + n * texel * 1.5, 1.0);
  vec3 direct = vec3(max(facing, 0.0) * shadow);
  if (look == 2) {  // light that wanders under the skin comes out red beyond the terminator
    vec3 wrap = vec3(0.40, 0.16, 0.10);
    float sheltered = mix(1.0, shadow, smoothstep(0.0, 0.35, facing));
    direct = clamp((facing + wrap) / (1.0 + wrap), 0.0, 1.0) *
             mix(vec3(0.22, 0.04, 0.02), vec3(1), sheltered);
  }
  vec3 sky = mix(vec3(0.25, 0.23, 0.22), vec3(0.50, 0.53, 0.58), 0.5 * dot(n, up) + 0.5);
  float rim = pow(1.0 - max(dot(n, v), 0.0), 3.0) * (0.5 + 0.5 * dot(n, up));
  vec3 light = 1.05 * vec3(1.0, 0.975, 0.94) * direct + sky * open * mix(albedo, vec3(1), open);
  float glint = max(dot(n, normalize(key + v)), 0.0);
  glint *= glint; glint *= glint; glint *= glint; glint *= glint;  // to the 16th
  float shine = texel_colour.a * (0.35 * glint + 0.5 * glint * glint * glint) * shadow * open;
  return albedo * light + 0.42 * shine + 0.10 * rim * open * open;
}

// The 4 x 4 block in which each turn of the disc occurs once, without other surfaces.
float openness(ivec2 pixel, float z) {
  vec2 total = vec2(1e-4);
  for (int i = 0; i < 16; ++i) {
    ivec2 at = clamp(pixel + ivec2((i & 3) - 2, (i >> 2) - 2), ivec2(0), ivec2(large_size) / 2 - 1);
    vec2 o = texelFetch(occlusion_map, at, 0).rg;
    total += max(1.0 - abs(o.y - z) / (0.02 * z), 0.0) * vec2(o.x, 1);
  }
  return total.x / total.y;
}

void main() {
  ivec2 q = ivec2(gl_FragCoord.xy);
  float z = distance_at(q);
  lit_colour = vec4(sqrt(shade(q, z, openness(q / 2, z))), 1);
})";

// The mean of 2 x 2 lit samples a pixel, over ground and background.
inline constexpr char kPictureFragment[] = THEW_SCREEN_COMMON THEW_SHADOW_COMMON R"(
uniform sampler2D lit_map;
uniform vec3 centre;          // of the scene at rest
uniform float ground;         // height of the ground over the eye (m)
uniform float ground_radius;  // m, 0: no ground
out vec4 pixel_colour;

vec3 background(vec2 q) {
  vec2 s = q / large_size;
  float v = 0.93 - 0.07 * (1.0 - s.y) - 0.06 * dot(s - 0.5, s - 0.5);
  return v * v * vec3(1.0, 0.995, 0.985);
}

vec3 behind(ivec2 q) {
  vec3 grey = background(vec2(q)), r = ray(q);
  float slope = dot(r, up);
  if (ground_radius <= 0.0 || slope * ground <= 0.0 || ground > 0.0) return grey;
  vec3 p = r * (ground / slope);
  vec3 d = p - centre;
  d -= dot(d, up) * up;
  float fade = 1.0 - smoothstep(0.5, 3.0, length(d) / ground_radius);
  if (fade <= 0.0) return grey;
  return grey * mix(1.0, mix(0.60, 1.02, lit(p, 6.0)), fade);
}

void main() {
  ivec2 q = 2 * ivec2(gl_FragCoord.xy);
  vec4 sum = vec4(0);
  for (int i = 0; i < 4; ++i) {
    vec4 c = texelFetch(lit_map, q + ivec2(i & 1, i >> 1), 0);
    sum += vec4(c.rgb * c.rgb, c.a);
  }
  pixel_colour = vec4(sqrt(0.25 * (sum.rgb + (4.0 - sum.a) * behind(q))), 1);
})";

}  // namespace thew::shaders
