// SPDX-License-Identifier: Apache-2.0
#include "tools/render/renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>

#include "rig/math.h"
#include "sim/framing.h"
#include "tools/render/camera.h"
#include "tools/render/canvas.h"
#include "tools/render/draw_geometry.h"
#include "tools/render/pixel_rect.h"
#include "tools/render/shaders.h"

namespace thew::tools {
namespace {

constexpr double kGroundGap = 0.04;  // m below the lowest vertex at rest
// Of a pixel where all that there is fills the height: what no one sees of an outline's corners.
constexpr double kFlatness = 0.1;
constexpr int kOcclusionTaps = 12;
constexpr double kShadowBlur = 6.5;  // texels: as far as picture.frag looks, and a texel's own two
constexpr std::size_t kBackdrops = 8;  // kept, of views as they take turns

/// What a surface is drawn as; the first three are those of BakeMesh::Kind, kFlat is unlit ink.
/// Light tells them apart by the last two bits.
constexpr int kProp = static_cast<int>(BakeMesh::Kind::kProp);  // it looks as bone does
enum Look { kMuscle, kBone, kSkin, kFlat, kWeight, kCut = 6, kLooks };

void check_size(int width, int height) {
  if (std::min(width, height) >= 16 && std::max(width, height) <= 8192) return;
  throw Error(ErrorCode::kUsage, "render size " + std::to_string(width) + " x " +
                                     std::to_string(height) +
                                     ": outside 16..8192 pixels; change render.width or height");
}

/// What a shadow map depends on besides the vertices.
struct ShadowKey {
  Mat4 light_from_world;
  ShownKinds shown;
  std::vector<std::array<double, 4>> cut;
  bool operator==(const ShadowKey&) const = default;
};

/// What is seen from an eye where nothing stands and nothing casts a shadow.
struct Backdrop {
  Vec3 eye, target, up, moved;
  double field_of_view;
  Image image;
  bool is_of(const SceneView& view) const {
    return eye == view.eye && target == view.target && up == view.up && moved == view.moved &&
           field_of_view == view.field_of_view;
  }
};

/// Of one picture. Nothing else is drawn, so that what lies about costs nothing.
struct Shot {
  ShownKinds shown;
  Camera camera;
  Light light;
  std::vector<DrawVertex> quads;  ///< segments as long as weights
  PixelRect figure;               ///< where surfaces are seen
  PixelRect ground;               ///< and where their shadow on the ground

  Mat4 light_from_view() const {
    return light.light_from_world * camera.view_from_world.inverse().matrix();
  }
};

}  // namespace

struct Renderer::Data {
  Data(int width, int height, const std::vector<BakeMesh>& meshes);

  void set_disc();
  void show(int width, int height, const std::vector<BakeMesh>& meshes);
  void make_arrays();
  void send(const std::vector<std::vector<Vec3>>& positions, const ShownKinds& shown);
  Shot frame_shot(const SceneView& view, const ShownKinds& shown);
  const Image& backdrop_of(const SceneView& view, const Camera& camera);
  double ground_height() const { return rest.low.y() - kGroundGap; }
  void draw_kind(int kind, bool inside = false);
  void set_cut(const SceneView& view);
  void begin_surface(Look look, const Shot& shot);
  void draw_shadow(const SceneView& view, const Shot& shot);
  void draw_surfaces(const SceneView& view, const Shot& shot);
  void draw_occlusion(const Shot& shot);
  void draw_weights(const Shot& shot);
  void bind_shadow(const Camera& camera, const Mat4& light_from_view);
  void draw_light(const Shot& shot);
  void draw_picture(const SceneView& view, const Camera& camera, const Mat4& light_from_view,
                    const PixelRect& rect);
  void read_pixels(const PixelRect& rect, Image& image);

  const std::vector<BakeMesh>* meshes = nullptr;
  Canvas canvas;
  DrawGeometry geometry;
  Bounds rest;
  std::vector<SentMesh> sent;         ///< by mesh
  std::vector<Backdrop> backdrops;    ///< the latest last
  std::optional<ShadowKey> shadowed;  ///< what the shadow map holds
  PixelRect drawn;                    ///< beyond it the targets of the screen are clear
  GlProgram shadow_program, cut_shadow_program, surface_programs[kLooks], occlusion_program,
      light_program, picture_program;
  GLuint surface_array, quad_array, vertex_buffer, quad_buffer;
  GLuint arrays[2], buffers[4];
};

Renderer::Data::Data(int w, int h, const std::vector<BakeMesh>& all) : canvas(w, h) {
  GlContext& context = canvas.context;
  shadow_program = context.build_program(kShadowVert, kShadowFrag);
  cut_shadow_program = context.build_program(kCutShadowVert, kCutShadowFrag);
  for (const Look look : {kMuscle, kBone, kSkin, kFlat, kWeight, kCut}) {
    surface_programs[look] = context.build_program(kSurfaceVert, surface_source(look).c_str());
  }
  occlusion_program = context.build_program(kScreenVert, kOcclusionFrag);
  light_program = context.build_program(kScreenVert, kLightFrag);
  picture_program = context.build_program(kScreenVert, kPictureFrag);
  set_disc();
  canvas.gl.GenVertexArrays(2, arrays);
  canvas.gl.GenBuffers(4, buffers);
  surface_array = arrays[0], quad_array = arrays[1];
  vertex_buffer = buffers[0], quad_buffer = buffers[1];
  drawn = canvas.whole();
  show(w, h, all);
}

// Where the occlusion looks around a pixel.
void Renderer::Data::set_disc() {
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
  canvas.gl.UseProgram(occlusion_program.name);
  canvas.gl.Uniform2fv(occlusion_program.at("taps"), kOcclusionTaps, taps);
  canvas.gl.Uniform2fv(occlusion_program.at("turns"), 16, turns);
}

void Renderer::Data::show(int w, int h, const std::vector<BakeMesh>& all) {
  if (w != canvas.width || h != canvas.height) {
    canvas.resize(w, h);
    drawn = canvas.whole();
  }
  meshes = &all;
  rest = {};
  for (const BakeMesh& mesh : all) {
    for (const Vec3& p : mesh.rest.vertices) rest.add(p);
  }
  geometry = make_draw_geometry(all, rest.empty() ? 0.0 : kFlatness * 2.0 * rest.radius() / h);
  sent.assign(all.size(), {});
  backdrops.clear();
  shadowed.reset();
  make_arrays();
  canvas.context.finish();  // reports what could not be allocated
}

void Renderer::Data::make_arrays() {
  // Mesa holds what it is given once more, and what it has turned into screen space.
  check_room(4 * (geometry.constants.size() * (sizeof(DrawConstant) + 2 * sizeof(DrawVertex)) +
                  geometry.indices.size() * sizeof(std::uint32_t)));
  const Gl& gl = canvas.gl;
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
  gl.BindBuffer(GL_ARRAY_BUFFER, vertex_buffer);
  gl.BufferData(GL_ARRAY_BUFFER, geometry.vertices.size() * sizeof(DrawVertex), nullptr,
                GL_DYNAMIC_DRAW);
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

// What has moved since it was sent last: of a frame its first view sends all, and bones that rest
// are sent once.
void Renderer::Data::send(const std::vector<std::vector<Vec3>>& positions,
                          const ShownKinds& shown) {
  canvas.gl.BindBuffer(GL_ARRAY_BUFFER, vertex_buffer);
  for (std::size_t m = 0; m < meshes->size(); ++m) {
    if (!shown[static_cast<int>((*meshes)[m].kind)] || !moves(positions[m], sent[m])) continue;
    const DrawMesh& mesh = geometry.meshes[m];
    place_vertices(mesh, sent[m].positions, geometry);
    canvas.gl.BufferSubData(GL_ARRAY_BUFFER, mesh.first_vertex * sizeof(DrawVertex),
                            mesh.vertex_count * sizeof(DrawVertex),
                            geometry.vertices.data() + mesh.first_vertex);
    shadowed.reset();
  }
}

Shot Renderer::Data::frame_shot(const SceneView& view, const ShownKinds& shown) {
  Shot shot;
  Bounds seen;
  for (std::size_t m = 0; m < meshes->size(); ++m) {
    if (!shown[static_cast<int>((*meshes)[m].kind)] || sent[m].bounds.empty()) continue;
    seen.add(sent[m].bounds.low);
    seen.add(sent[m].bounds.high);
  }
  const int w = canvas.width, h = canvas.height;
  shot.shown = shown;
  shot.camera = make_camera(view, double(w) / h, seen);
  shot.light = make_light(view, shot.camera, seen, rest.radius());
  if (view.show == "weights") {  // 1.5 samples wide
    shot.quads = weight_quads(*meshes, geometry, view.eye, 0.03 * rest.radius(),
                              1.5 * shot.camera.tan_y / h);
  }
  SeenRect figure(shot.camera, w, h);
  ShadowOutline outline(shot.light);
  for (std::size_t m = 0; m < meshes->size(); ++m) {
    if (!shown[static_cast<int>((*meshes)[m].kind)]) continue;
    const DrawVertex* vertex = geometry.vertices.data() + geometry.meshes[m].first_vertex;
    for (std::size_t i = 0; i < geometry.meshes[m].vertex_count; ++i) {
      const Vec3 p = position_of(vertex[i]);
      figure.add(p);
      outline.add(p);
    }
  }
  for (const DrawVertex& corner : shot.quads) figure.add(position_of(corner));
  shot.figure = figure.rect();
  shot.ground = outline.on_ground(ground_height(), kShadowBlur, shot.camera, w, h);
  return shot;
}

// `inside`: its back may be seen.
void Renderer::Data::draw_kind(int kind, bool inside) {
  const Gl& gl = canvas.gl;
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
  canvas.set("cuts", static_cast<int>(view.cut.size()));
  canvas.gl.Uniform4fv(canvas.at("cut"), static_cast<GLsizei>(view.cut.size()), planes.data());
}

// Views of one frame from one side often share it.
void Renderer::Data::draw_shadow(const SceneView& view, const Shot& shot) {
  const bool cut = view.show == "cutaway";
  ShadowKey key{shot.light.light_from_world, shot.shown, {}};
  if (cut) key.cut = view.cut;
  if (shadowed == key) return;
  const Gl& gl = canvas.gl;
  canvas.begin(shadow_program, canvas.shadow_target, kShadowSize, kShadowSize);
  gl.Enable(GL_DEPTH_TEST);
  gl.Clear(GL_DEPTH_BUFFER_BIT);
  gl.Enable(GL_POLYGON_OFFSET_FILL);
  gl.PolygonOffset(2.0f, 2.0f);
  canvas.set("light_from_world", shot.light.light_from_world);
  for (const int kind : {+kMuscle, +kBone, kProp, +kSkin}) {
    if (!shot.shown[kind]) continue;
    if (kind == kSkin && cut) {
      canvas.begin(cut_shadow_program, canvas.shadow_target, kShadowSize, kShadowSize);
      canvas.set("light_from_world", shot.light.light_from_world);
      set_cut(view);
    }
    draw_kind(kind);
  }
  gl.Disable(GL_POLYGON_OFFSET_FILL);
  gl.Disable(GL_DEPTH_TEST);
  shadowed = key;
}

void Renderer::Data::begin_surface(Look look, const Shot& shot) {
  canvas.begin_surfaces(surface_programs[look], shot.figure);
  canvas.set("view_from_world", shot.camera.view_from_world.matrix());
  canvas.set("clip_from_view", shot.camera.clip_from_view);
}

void Renderer::Data::draw_surfaces(const SceneView& view, const Shot& shot) {
  const bool weights = view.show == "weights", cut = view.show == "cutaway";
  const auto look_of = [&](int kind) {
    if (kind == kMuscle && weights) return kWeight;
    if (kind == kProp) return kBone;
    return kind == kSkin && cut ? kCut : static_cast<Look>(kind);
  };
  for (const int kind : {+kMuscle, +kBone, kProp, +kSkin}) {
    if (!shot.shown[kind]) continue;
    begin_surface(look_of(kind), shot);
    canvas.set("weight_top", weights || kind == kMuscle ? double{geometry.largest_weight} : 0.0);
    if (kind == kSkin && cut) {
      set_cut(view);
      canvas.set("rim", 0.006 * rest.radius());
    }
    draw_kind(kind, cut);
  }
  canvas.end_surfaces();
}

void Renderer::Data::draw_occlusion(const Shot& shot) {
  canvas.begin_screen(occlusion_program, canvas.occlusion_target, 1, shot.camera, shot.figure);
  canvas.set("radius", 0.05 * rest.radius());
  canvas.draw_covered();
}

// After the occlusion, which is not to see them.
void Renderer::Data::draw_weights(const Shot& shot) {
  if (shot.quads.empty()) return;
  const Gl& gl = canvas.gl;
  begin_surface(kFlat, shot);
  gl.BindVertexArray(quad_array);
  gl.BindBuffer(GL_ARRAY_BUFFER, quad_buffer);
  gl.BufferData(GL_ARRAY_BUFFER, shot.quads.size() * sizeof(DrawVertex), shot.quads.data(),
                GL_STREAM_DRAW);
  gl.VertexAttrib4f(4, 0.16f, 0.15f, 0.20f, 1.0f);  // ink
  gl.DrawArrays(GL_TRIANGLES, 0, shot.quads.size());
  canvas.end_surfaces();
}

void Renderer::Data::bind_shadow(const Camera& camera, const Mat4& light_from_view) {
  canvas.bind("shadow_map", 3, canvas.shadow_map);
  canvas.set("light_from_view", light_from_view);
  canvas.set("up", Vec3(camera.view_from_world.linear().col(1)));
}

void Renderer::Data::draw_light(const Shot& shot) {
  canvas.begin_screen(light_program, canvas.lit_target, 2, shot.camera, shot.figure);
  bind_shadow(shot.camera, shot.light_from_view());
  canvas.bind("occlusion_map", 4, canvas.occlusion_map);
  canvas.set("key", Vec3(shot.camera.view_from_world.linear() * shot.light.direction));
  canvas.set("texel", shot.light.texel);
  canvas.draw_covered();
}

// The ground is lit about what is looked at: it goes along with the camera.
void Renderer::Data::draw_picture(const SceneView& view, const Camera& camera,
                                  const Mat4& light_from_view, const PixelRect& rect) {
  canvas.begin_screen(picture_program, 0, 1, camera, rect);
  bind_shadow(camera, light_from_view);
  canvas.bind("lit_map", 4, canvas.lit_map);
  const Transform& to_view = camera.view_from_world;
  const double eye = to_view.inverse().translation().y();
  canvas.set("centre", Vec3(to_view * Vec3(rest.centre() + view.moved)));
  canvas.set("ground", rest.empty() ? 0.0 : ground_height() - eye);
  canvas.set("ground_radius", rest.radius());
  canvas.draw_screen();
}

// While the canvas is clear. It does not depend on the frame, and most pixels show it.
const Image& Renderer::Data::backdrop_of(const SceneView& view, const Camera& camera) {
  const auto known = std::find_if(backdrops.begin(), backdrops.end(),
                                  [&](const Backdrop& b) { return b.is_of(view); });
  if (known != backdrops.end()) return known->image;
  Mat4 before_all = Mat4::Zero();
  before_all(2, 3) = -3.0;  // nothing in the shadow map lies before it
  draw_picture(view, camera, before_all, canvas.whole());
  const int w = canvas.width, h = canvas.height;
  Image image{w, h, std::vector<std::uint8_t>(3ul * w * h), canvas.context.driver()};
  read_pixels(canvas.whole(), image);
  if (backdrops.size() == kBackdrops) backdrops.erase(backdrops.begin());
  backdrops.push_back(
      {view.eye, view.target, view.up, view.moved, view.field_of_view, std::move(image)});
  return backdrops.back().image;
}

void Renderer::Data::read_pixels(const PixelRect& rect, Image& image) {
  const std::uint8_t* rgba = canvas.context.finish().data();
  for (int y = rect.bottom; y < rect.top; ++y) {
    const std::uint8_t* in = rgba + 4ul * (std::size_t{1} * canvas.width * y + rect.left);
    std::uint8_t* out = image.rgb.data() +
                        3ul * (std::size_t{1} * canvas.width * (canvas.height - 1 - y) + rect.left);
    for (int x = rect.left; x < rect.right; ++x, in += 4, out += 3) std::copy_n(in, 3, out);
  }
}

Renderer::Renderer(int width, int height, const std::vector<BakeMesh>& meshes) {
  check_size(width, height);
  data_ = std::make_unique<Data>(width, height, meshes);
}

Renderer::~Renderer() = default;

void Renderer::show(int width, int height, const std::vector<BakeMesh>& meshes) {
  check_size(width, height);
  data_->canvas.context.make_current();
  data_->show(width, height, meshes);
}

const std::string& Renderer::driver() const { return data_->canvas.context.driver(); }

Image Renderer::draw(const SceneView& view, const std::vector<std::vector<Vec3>>& positions) {
  check_view(view);
  Data& data = *data_;
  Canvas& canvas = data.canvas;
  canvas.context.make_current();
  ShownKinds shown;
  for (std::size_t k = 0; k < shown.size(); ++k)
    shown[k] = shows(view, static_cast<BakeMesh::Kind>(k));
  data.send(positions, shown);
  const Shot shot = data.frame_shot(view, shown);
  canvas.clear(data.drawn);
  data.drawn = {};
  Image image = data.backdrop_of(view, shot.camera);
  data.drawn = shot.figure;
  data.draw_shadow(view, shot);
  data.draw_surfaces(view, shot);
  data.draw_occlusion(shot);
  data.draw_weights(shot);
  data.draw_light(shot);
  const std::vector<PixelRect> rects = few(shot.figure, shot.ground);
  for (const PixelRect& rect : rects) {
    data.draw_picture(view, shot.camera, shot.light_from_view(), rect);
  }
  for (const PixelRect& rect : rects) data.read_pixels(rect, image);
  return image;
}

}  // namespace thew::tools
