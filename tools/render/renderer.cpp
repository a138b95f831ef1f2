// SPDX-License-Identifier: Apache-2.0
#include "tools/render/renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "rig/math.h"
#include "tools/render/camera.h"
#include "tools/render/draw_geometry.h"
#include "tools/render/gl_context.h"
#include "tools/render/shaders.h"

namespace thew::tools {
namespace {

constexpr double kGroundGap = 0.04;  // m below the lowest vertex at rest
constexpr int kOcclusionTaps = 12;

/// What a surface is drawn as; the first three are those of BakeMesh::Kind, kFlat is unlit ink.
/// Light tells them apart by the last two bits.
enum Look { kMuscle, kBone, kSkin, kFlat, kWeight, kCut = 6, kLooks };

void check_size(int width, int height) {
  if (std::min(width, height) >= 16 && std::max(width, height) <= 8192) return;
  throw Error(ErrorCode::kUsage, "render size " + std::to_string(width) + " x " +
                                     std::to_string(height) +
                                     ": outside 16..8192 pixels; change render.width or height");
}

}  // namespace

struct Renderer::Data {
  Data(int width, int height, const std::vector<BakeMesh>& meshes);

  void show(int width, int height, const std::vector<BakeMesh>& meshes);
  void make_targets(int w, int h);
  GLuint make_texture(GLint format, GLenum layout, GLenum type, int w, int h);
  GLuint make_target(std::initializer_list<GLuint> colours, GLuint depth);
  void make_arrays();
  void set(const char* name, int value);
  void set(const char* name, double value);
  void set(const char* name, double x, double y);
  void set(const char* name, const Vec3& value);
  void set(const char* name, const Mat4& value);
  void begin(GLuint program, GLuint target, int w, int h);
  void bind(const char* name, int unit, GLuint texture);
  void begin_screen(GLuint program, GLuint target, const Camera& camera);
  void draw_covered(int scale);
  Bounds load(const std::vector<std::vector<Vec3>>& positions, const ShownKinds& shown);
  void draw_kind(int kind, bool inside = false);
  void set_cut(const SceneView& view);
  void begin_surface(Look look, const Camera& camera);
  void draw_shadow(const SceneView& view, const Light& light, const ShownKinds& shown);
  void draw_surfaces(const SceneView& view, const Camera& camera, const ShownKinds& shown);
  void draw_occlusion(const Camera& camera);
  void draw_weights(const Camera& camera, const Vec3& eye);
  void bind_shadow(const Camera& camera, const Light& light);
  void draw_light(const Camera& camera, const Light& light);
  void draw_picture(const Camera& camera, const Light& light);
  Image read_image();

  int width, height;
  const std::vector<BakeMesh>* meshes;
  GlContext context;
  const Gl& gl;
  DrawGeometry geometry;
  Bounds rest;
  GLuint program = 0;
  GLuint shadow_program, cut_shadow_program, surface_programs[kLooks] = {}, occlusion_program,
                                             light_program, picture_program;
  GLuint shadow_map, colour_map, surface_map, depth_map, occlusion_map, lit_map;
  GLuint shadow_target, surface_target, occlusion_target, lit_target;
  GLuint surface_array, quad_array, vertex_buffer, quad_buffer;
  std::vector<GLuint> textures, targets;  // all of this size
  GLuint arrays[2], buffers[4];
};

Renderer::Data::Data(int w, int h, const std::vector<BakeMesh>& all)
    : width(w), height(h), meshes(&all), context(w, h), gl(context.gl()) {
  shadow_program = context.build_program(kShadowVert, kShadowFrag);
  cut_shadow_program = context.build_program(kCutShadowVert, kCutShadowFrag);
  for (const Look look : {kMuscle, kBone, kSkin, kFlat, kWeight, kCut}) {
    surface_programs[look] = context.build_program(kSurfaceVert, surface_source(look).c_str());
  }
  occlusion_program = context.build_program(kScreenVert, kOcclusionFrag);
  light_program = context.build_program(kScreenVert, kLightFrag);
  picture_program = context.build_program(kScreenVert, kPictureFrag);
  gl.GenVertexArrays(2, arrays);
  gl.GenBuffers(4, buffers);
  surface_array = arrays[0], quad_array = arrays[1];
  vertex_buffer = buffers[0], quad_buffer = buffers[1];
  make_targets(w, h);
  show(w, h, all);
}

void Renderer::Data::show(int w, int h, const std::vector<BakeMesh>& all) {
  if (w != width || h != height) {
    gl.DeleteFramebuffers(targets.size(), targets.data());
    gl.DeleteTextures(textures.size(), textures.data());
    context.resize(w, h);
    width = w, height = h;
    make_targets(w, h);
  }
  meshes = &all;
  geometry = make_draw_geometry(all);
  rest = {};
  for (const BakeMesh& mesh : all) {
    for (const Vec3& p : mesh.rest.vertices) rest.add(p);
  }
  make_arrays();
  context.finish();  // reports what could not be allocated
}

void Renderer::Data::make_targets(int w, int h) {
  textures.clear();
  targets.clear();
  const auto depth_texture = [&](int x, int y) {
    return make_texture(GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT, x, y);
  };
  shadow_map = depth_texture(kShadowSize, kShadowSize);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  depth_map = depth_texture(2 * w, 2 * h);
  colour_map = make_texture(GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, 2 * w, 2 * h);
  surface_map = make_texture(GL_RGB10_A2, GL_RGBA, GL_UNSIGNED_INT_10_10_10_2, 2 * w, 2 * h);
  occlusion_map = make_texture(GL_RG32F, GL_RG, GL_FLOAT, w, h);
  lit_map = make_texture(GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, 2 * w, 2 * h);
  shadow_target = make_target({}, shadow_map);
  surface_target = make_target({colour_map, surface_map}, depth_map);
  occlusion_target = make_target({occlusion_map}, depth_texture(w, h));
  lit_target = make_target({lit_map}, depth_texture(2 * w, 2 * h));
}

GLuint Renderer::Data::make_texture(GLint format, GLenum layout, GLenum type, int w, int h) {
  GLuint texture;
  gl.GenTextures(1, &texture);
  textures.push_back(texture);
  gl.BindTexture(GL_TEXTURE_2D, texture);
  gl.TexImage2D(GL_TEXTURE_2D, 0, format, w, h, 0, layout, type, nullptr);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  return texture;
}

GLuint Renderer::Data::make_target(std::initializer_list<GLuint> colours, GLuint depth) {
  GLuint target;
  gl.GenFramebuffers(1, &target);
  targets.push_back(target);
  gl.BindFramebuffer(GL_FRAMEBUFFER, target);
  std::vector<GLenum> drawn;
  for (const GLuint colour : colours) {
    drawn.push_back(GL_COLOR_ATTACHMENT0 + drawn.size());
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, drawn.back(), GL_TEXTURE_2D, colour, 0);
  }
  gl.DrawBuffers(drawn.size(), drawn.data());
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth, 0);
  if (gl.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
    throw Error(ErrorCode::kOutput, "renderer: " + context.driver() + " cannot draw an image of " +
                                        std::to_string(width) + " x " + std::to_string(height) +
                                        "; choose a smaller size");
  }
  return target;
}

void Renderer::Data::make_arrays() {
  // Mesa holds what it is given once more, and what it has turned into screen space.
  check_room(4 * (geometry.constants.size() * (sizeof(DrawConstant) + 2 * sizeof(DrawVertex)) +
                  geometry.indices.size() * sizeof(std::uint32_t)));
  const auto attribute = [&](GLuint index, int size, GLenum type, std::size_t stride,
                             std::size_t offset) {
    gl.EnableVertexAttribArray(index);
    gl.VertexAttribPointer(index, size, type, type == GL_UNSIGNED_BYTE, stride,
                           reinterpret_cast<const void*>(offset));
  };
  for (int k : {0, 1}) {
    gl.BindVertexArray(arrays[k]);
    gl.BindBuffer(GL_ARRAY_BUFFER, buffers[k]);
    attribute(0, 3, GL_FLOAT, sizeof(DrawVertex), offsetof(DrawVertex, position));
    attribute(1, 3, GL_FLOAT, sizeof(DrawVertex), offsetof(DrawVertex, normal));
  }
  gl.BindVertexArray(surface_array);
  gl.BindBuffer(GL_ARRAY_BUFFER, buffers[2]);
  gl.BufferData(GL_ARRAY_BUFFER, geometry.constants.size() * sizeof(DrawConstant),
                geometry.constants.data(), GL_STATIC_DRAW);
  attribute(2, 4, GL_FLOAT, sizeof(DrawConstant), offsetof(DrawConstant, coordinate));
  attribute(3, 1, GL_FLOAT, sizeof(DrawConstant), offsetof(DrawConstant, weight));
  attribute(4, 3, GL_UNSIGNED_BYTE, sizeof(DrawConstant), offsetof(DrawConstant, tint));
  gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[3]);
  gl.BufferData(GL_ELEMENT_ARRAY_BUFFER, geometry.indices.size() * sizeof(std::uint32_t),
                geometry.indices.data(), GL_STATIC_DRAW);
}

void Renderer::Data::set(const char* name, int value) {
  gl.Uniform1i(gl.GetUniformLocation(program, name), value);
}
void Renderer::Data::set(const char* name, double value) {
  gl.Uniform1f(gl.GetUniformLocation(program, name), static_cast<float>(value));
}
void Renderer::Data::set(const char* name, double x, double y) {
  gl.Uniform2f(gl.GetUniformLocation(program, name), static_cast<float>(x), static_cast<float>(y));
}
void Renderer::Data::set(const char* name, const Vec3& value) {
  const Eigen::Vector3f v = value.cast<float>();
  gl.Uniform3f(gl.GetUniformLocation(program, name), v.x(), v.y(), v.z());
}
void Renderer::Data::set(const char* name, const Mat4& value) {
  const Eigen::Matrix4f m = value.cast<float>();
  gl.UniformMatrix4fv(gl.GetUniformLocation(program, name), 1, GL_FALSE, m.data());
}

void Renderer::Data::begin(GLuint next, GLuint target, int w, int h) {
  program = next;
  gl.UseProgram(program);
  gl.BindFramebuffer(GL_FRAMEBUFFER, target);
  gl.Viewport(0, 0, w, h);
}

void Renderer::Data::bind(const char* name, int unit, GLuint texture) {
  gl.ActiveTexture(GL_TEXTURE0 + unit);
  gl.BindTexture(GL_TEXTURE_2D, texture);
  set(name, unit);
}

void Renderer::Data::begin_screen(GLuint next, GLuint target, const Camera& camera) {
  const int scale = target == lit_target ? 2 : 1;
  begin(next, target, scale * width, scale * height);
  gl.BindVertexArray(quad_array);
  gl.Disable(GL_DEPTH_TEST);
  bind("depth_map", 0, depth_map);
  bind("colour_map", 1, colour_map);
  bind("surface_map", 2, surface_map);
  set("near_far", camera.near, camera.far);
  set("tangents", camera.tan_x, camera.tan_y);
  set("large_size", 2.0 * width, 2.0 * height);
}

// Draws at the far plane where something is nearer, so that the driver skips the background block
// by block; it would run both sides of an `if`. Tests against a copy of the depths, as the shader
// reads the original.
void Renderer::Data::draw_covered(int scale) {
  gl.Clear(GL_COLOR_BUFFER_BIT);
  gl.BindFramebuffer(GL_READ_FRAMEBUFFER, surface_target);
  gl.BlitFramebuffer(0, 0, 2 * width, 2 * height, 0, 0, scale * width, scale * height,
                     GL_DEPTH_BUFFER_BIT, GL_NEAREST);
  gl.Enable(GL_DEPTH_TEST);
  gl.DepthFunc(GL_GREATER);
  gl.DepthMask(GL_FALSE);
  gl.DrawArrays(GL_TRIANGLES, 0, 3);
  gl.DepthMask(GL_TRUE);
  gl.DepthFunc(GL_LESS);
}

Bounds Renderer::Data::load(const std::vector<std::vector<Vec3>>& positions,
                            const ShownKinds& shown) {
  place_vertices(*meshes, positions, shown, geometry);
  gl.BindBuffer(GL_ARRAY_BUFFER, vertex_buffer);
  gl.BufferData(GL_ARRAY_BUFFER, geometry.vertices.size() * sizeof(DrawVertex),
                geometry.vertices.data(), GL_STREAM_DRAW);
  Bounds seen;
  for (std::size_t m = 0; m < meshes->size(); ++m) {
    if (!shown[static_cast<int>((*meshes)[m].kind)]) continue;
    for (const Vec3& p : positions[m]) seen.add(p);
  }
  return seen;
}

// `inside`: its back may be seen.
void Renderer::Data::draw_kind(int kind, bool inside) {
  const std::size_t first = geometry.first_index[kind], end = geometry.first_index[kind + 1];
  gl.BindVertexArray(surface_array);
  if (geometry.closed[kind] && !inside) gl.Enable(GL_CULL_FACE);
  gl.DrawElements(GL_TRIANGLES, end - first, GL_UNSIGNED_INT,
                  reinterpret_cast<const void*>(first * sizeof(std::uint32_t)));
  gl.Disable(GL_CULL_FACE);
}

void Renderer::Data::set_cut(const SceneView& view) {
  std::vector<float> planes;
  for (const auto& plane : view.cut) {
    for (const double k : plane) planes.push_back(static_cast<float>(k));
  }
  set("cuts", static_cast<int>(view.cut.size()));
  gl.Uniform4fv(gl.GetUniformLocation(program, "cut"), static_cast<GLsizei>(view.cut.size()),
                planes.data());
}

void Renderer::Data::draw_shadow(const SceneView& view, const Light& light,
                                 const ShownKinds& shown) {
  begin(shadow_program, shadow_target, kShadowSize, kShadowSize);
  gl.Enable(GL_DEPTH_TEST);
  gl.Clear(GL_DEPTH_BUFFER_BIT);
  gl.Enable(GL_POLYGON_OFFSET_FILL);
  gl.PolygonOffset(2.0f, 2.0f);
  set("light_from_world", light.light_from_world);
  for (const int kind : {kMuscle, kBone, kSkin}) {
    if (!shown[kind]) continue;
    if (kind == kSkin && view.show == "cutaway") {
      begin(cut_shadow_program, shadow_target, kShadowSize, kShadowSize);
      set("light_from_world", light.light_from_world);
      set_cut(view);
    }
    draw_kind(kind);
  }
  gl.Disable(GL_POLYGON_OFFSET_FILL);
}

void Renderer::Data::begin_surface(Look look, const Camera& camera) {
  begin(surface_programs[look], surface_target, 2 * width, 2 * height);
  gl.Enable(GL_DEPTH_TEST);
  set("view_from_world", camera.view_from_world.matrix());
  set("clip_from_view", camera.clip_from_view);
}

void Renderer::Data::draw_surfaces(const SceneView& view, const Camera& camera,
                                   const ShownKinds& shown) {
  const bool weights = view.show == "weights", cut = view.show == "cutaway";
  const auto look_of = [&](int kind) {
    if (kind == kMuscle && weights) return kWeight;
    return kind == kSkin && cut ? kCut : static_cast<Look>(kind);
  };
  bool first = true;
  for (const int kind : {kMuscle, kBone, kSkin}) {
    if (!shown[kind]) continue;
    begin_surface(look_of(kind), camera);
    if (first) gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    first = false;
    set("weight_top", weights || kind == kMuscle ? double{geometry.largest_weight} : 0.0);
    if (kind == kSkin && cut) {
      set_cut(view);
      set("rim", 0.006 * rest.radius());
    }
    draw_kind(kind, cut);
  }
}

void Renderer::Data::draw_occlusion(const Camera& camera) {
  begin_screen(occlusion_program, occlusion_target, camera);
  set("radius", 0.05 * rest.radius());
  float taps[2 * kOcclusionTaps], turns[32];
  for (int i = 0; i < kOcclusionTaps; ++i) {  // the sunflower's spiral, even over the disc
    const SinCos turn = sin_cos(2.399963229728653 * i);
    const double r = std::sqrt((i + 0.5) / kOcclusionTaps);
    taps[2 * i] = static_cast<float>(r * turn.cos);
    taps[2 * i + 1] = static_cast<float>(r * turn.sin);
  }
  for (int i = 0; i < 16; ++i) {  // 7 i mod 16: neighbours far apart
    const SinCos turn = sin_cos(2.0 * kPi * (7 * i % 16) / 16.0);
    turns[2 * i] = static_cast<float>(turn.cos);
    turns[2 * i + 1] = static_cast<float>(turn.sin);
  }
  gl.Uniform2fv(gl.GetUniformLocation(program, "taps"), kOcclusionTaps, taps);
  gl.Uniform2fv(gl.GetUniformLocation(program, "turns"), 16, turns);
  draw_covered(1);
}

// After the occlusion, which is not to see them. 1.5 samples wide.
void Renderer::Data::draw_weights(const Camera& camera, const Vec3& eye) {
  const std::vector<DrawVertex> quads =
      weight_quads(*meshes, geometry, eye, 0.03 * rest.radius(), 1.5 * camera.tan_y / height);
  begin_surface(kFlat, camera);
  gl.BindVertexArray(quad_array);
  gl.BindBuffer(GL_ARRAY_BUFFER, quad_buffer);
  gl.BufferData(GL_ARRAY_BUFFER, quads.size() * sizeof(DrawVertex), quads.data(), GL_STREAM_DRAW);
  gl.VertexAttrib4f(4, 0.16f, 0.15f, 0.20f, 1.0f);  // ink
  gl.DrawArrays(GL_TRIANGLES, 0, quads.size());
}

void Renderer::Data::bind_shadow(const Camera& camera, const Light& light) {
  bind("shadow_map", 3, shadow_map);
  const Transform& view = camera.view_from_world;
  set("light_from_view", Mat4(light.light_from_world * view.inverse().matrix()));
  set("up", Vec3(view.linear().col(1)));
}

void Renderer::Data::draw_light(const Camera& camera, const Light& light) {
  begin_screen(light_program, lit_target, camera);
  bind_shadow(camera, light);
  bind("occlusion_map", 4, occlusion_map);
  set("key", Vec3(camera.view_from_world.linear() * light.direction));
  set("texel", light.texel);
  draw_covered(2);
}

void Renderer::Data::draw_picture(const Camera& camera, const Light& light) {
  begin_screen(picture_program, 0, camera);
  bind_shadow(camera, light);
  bind("lit_map", 4, lit_map);
  const Transform& view = camera.view_from_world;
  const double eye = view.inverse().translation().y();
  set("centre", Vec3(view * rest.centre()));
  set("ground", rest.empty() ? 0.0 : rest.low.y() - kGroundGap - eye);
  set("ground_radius", rest.radius());
  gl.DrawArrays(GL_TRIANGLES, 0, 3);
}

Image Renderer::Data::read_image() {
  const std::uint8_t* rgba = context.finish().data();
  Image image{width, height, std::vector<std::uint8_t>(3ul * width * height), context.driver()};
  std::uint8_t* out = image.rgb.data();
  for (int y = height - 1; y >= 0; --y) {
    const std::uint8_t* in = rgba + 4ul * width * y;
    for (int x = 0; x < width; ++x, in += 4, out += 3) std::copy_n(in, 3, out);
  }
  return image;
}

Renderer::Renderer(int width, int height, const std::vector<BakeMesh>& meshes) {
  check_size(width, height);
  data_ = std::make_unique<Data>(width, height, meshes);
}

Renderer::~Renderer() = default;

void Renderer::show(int width, int height, const std::vector<BakeMesh>& meshes) {
  check_size(width, height);
  data_->context.make_current();
  data_->show(width, height, meshes);
}

const std::string& Renderer::driver() const { return data_->context.driver(); }

Image Renderer::draw(const SceneView& view, const std::vector<std::vector<Vec3>>& given) {
  check_view(view);
  const std::vector<std::vector<Vec3>> positions = as_in_cache(given);
  Data& data = *data_;
  data.context.make_current();
  const bool skin = view.show == "skin", cut = view.show == "cutaway";
  const ShownKinds shown = {!skin, !skin, skin || cut};
  const Bounds seen = data.load(positions, shown);
  const Camera camera = make_camera(view, double(data.width) / data.height, seen);
  const Light light = make_light(view, camera, seen, data.rest.radius());
  data.draw_shadow(view, light, shown);
  data.draw_surfaces(view, camera, shown);
  data.draw_occlusion(camera);
  if (view.show == "weights") data.draw_weights(camera, view.eye);
  data.draw_light(camera, light);
  data.draw_picture(camera, light);
  return data.read_image();
}

}  // namespace thew::tools
