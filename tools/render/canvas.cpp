// SPDX-License-Identifier: Apache-2.0
#include "tools/render/canvas.h"

#include <algorithm>
#include <string>

#include "rig/types.h"

namespace thew::tools {

Canvas::Canvas(int w, int h) : width(w), height(h), context(w, h), gl(context.gl()) {
  gl.GenVertexArrays(1, &no_array_);
  make_targets();
}

void Canvas::resize(int w, int h) {
  gl.DeleteFramebuffers(targets_.size(), targets_.data());
  gl.DeleteTextures(textures_.size(), textures_.data());
  textures_.clear();
  targets_.clear();
  context.resize(w, h);
  width = w, height = h;
  make_targets();
}

void Canvas::make_targets() {
  const int w = 2 * width, h = 2 * height;
  shadow_map = make_depth_texture(kShadowSize, kShadowSize);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  depth_map = make_depth_texture(w, h);
  colour_map = make_texture(GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, w, h);
  surface_map = make_texture(GL_RGB10_A2, GL_RGBA, GL_UNSIGNED_INT_10_10_10_2, w, h);
  occlusion_map = make_texture(GL_RG32F, GL_RG, GL_FLOAT, width, height);
  lit_map = make_texture(GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, w, h);
  shadow_target = make_target({}, shadow_map);
  surface_target = make_target({colour_map, surface_map}, depth_map);
  occlusion_target = make_target({occlusion_map}, make_depth_texture(width, height));
  lit_target = make_target({lit_map}, make_depth_texture(w, h));
}

GLuint Canvas::make_texture(GLint format, GLenum layout, GLenum type, int w, int h) {
  GLuint texture;
  gl.GenTextures(1, &texture);
  textures_.push_back(texture);
  gl.BindTexture(GL_TEXTURE_2D, texture);
  gl.TexImage2D(GL_TEXTURE_2D, 0, format, w, h, 0, layout, type, nullptr);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  return texture;
}

GLuint Canvas::make_depth_texture(int w, int h) {
  return make_texture(GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT, w, h);
}

GLuint Canvas::make_target(std::initializer_list<GLuint> colours, GLuint depth) {
  GLuint target;
  gl.GenFramebuffers(1, &target);
  targets_.push_back(target);
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

void Canvas::set(const char* name, int value) const { gl.Uniform1i(at(name), value); }
void Canvas::set(const char* name, double value) const {
  gl.Uniform1f(at(name), static_cast<float>(value));
}
void Canvas::set(const char* name, double x, double y) const {
  gl.Uniform2f(at(name), static_cast<float>(x), static_cast<float>(y));
}
void Canvas::set(const char* name, const Vec3& value) const {
  const Eigen::Vector3f v = value.cast<float>();
  gl.Uniform3f(at(name), v.x(), v.y(), v.z());
}
void Canvas::set(const char* name, const Mat4& value) const {
  const Eigen::Matrix4f m = value.cast<float>();
  gl.UniformMatrix4fv(at(name), 1, GL_FALSE, m.data());
}

void Canvas::bind(const char* name, int unit, GLuint texture) const {
  gl.ActiveTexture(GL_TEXTURE0 + unit);
  gl.BindTexture(GL_TEXTURE_2D, texture);
  set(name, unit);
}

void Canvas::begin(const GlProgram& program, GLuint target, int target_width, int target_height) {
  program_ = &program;
  gl.UseProgram(program.name);
  gl.BindFramebuffer(GL_FRAMEBUFFER, target);
  gl.Viewport(0, 0, target_width, target_height);
}

void Canvas::begin_surfaces(const GlProgram& program, const PixelRect& rect) {
  begin(program, surface_target, 2 * width, 2 * height);
  scissor(rect, 2);
  gl.Enable(GL_DEPTH_TEST);
}

void Canvas::end_surfaces() {
  gl.Disable(GL_SCISSOR_TEST);
  gl.Disable(GL_DEPTH_TEST);
}

void Canvas::begin_screen(const GlProgram& program, GLuint target, int scale, const Camera& camera,
                          const PixelRect& rect) {
  begin(program, target, scale * width, scale * height);
  rect_ = rect;
  scale_ = scale;
  bind("depth_map", 0, depth_map);
  bind("colour_map", 1, colour_map);
  bind("surface_map", 2, surface_map);
  set("near_far", camera.near, camera.far);
  set("tangents", camera.tan_x, camera.tan_y);
  set("large_size", 2.0 * width, 2.0 * height);
}

void Canvas::scissor(const PixelRect& rect, int scale) const {
  gl.Enable(GL_SCISSOR_TEST);
  gl.Scissor(scale * rect.left, scale * rect.bottom, scale * rect.width(), scale * rect.height());
}

void Canvas::draw_screen() {
  scissor(rect_, scale_);
  gl.BindVertexArray(no_array_);
  gl.DrawArrays(GL_TRIANGLES, 0, 3);
  gl.Disable(GL_SCISSOR_TEST);
}

// Draws at the far plane where something is nearer, so that the driver skips the background block
// by block; it would run both sides of an `if`. Tests against a copy of the depths, as the shader
// reads the original.
void Canvas::draw_covered() {
  // A copy of equal size is taken by lines of memory, which a scissor would rule out. Of the other
  // all is named, so that which texel of four it takes does not depend on the rectangle.
  const PixelRect from = scale_ == 2 ? rect_ : whole();
  if (scale_ != 2) scissor(rect_, scale_);
  gl.BindFramebuffer(GL_READ_FRAMEBUFFER, surface_target);
  gl.BlitFramebuffer(2 * from.left, 2 * from.bottom, 2 * from.right, 2 * from.top,
                     scale_ * from.left, scale_ * from.bottom, scale_ * from.right,
                     scale_ * from.top, GL_DEPTH_BUFFER_BIT, GL_NEAREST);
  gl.Enable(GL_DEPTH_TEST);
  gl.DepthFunc(GL_GREATER);
  gl.DepthMask(GL_FALSE);
  draw_screen();
  gl.DepthMask(GL_TRUE);
  gl.DepthFunc(GL_LESS);
  gl.Disable(GL_DEPTH_TEST);
}

// By texels sent, strip by strip, which are lines of memory: a clear within a scissor is drawn, and
// one without it takes the whole target. Colour and normal are read only where there is depth.
void Canvas::clear(const PixelRect& rect) {
  constexpr int kRows = 32;
  const auto fill = [&](GLuint texture, int scale, GLenum layout, GLenum type, const void* texels) {
    gl.BindTexture(GL_TEXTURE_2D, texture);
    for (int y = scale * rect.bottom; y < scale * rect.top; y += kRows) {
      gl.TexSubImage2D(GL_TEXTURE_2D, 0, scale * rect.left, y, scale * rect.width(),
                       std::min(kRows, scale * rect.top - y), layout, type, texels);
    }
  };
  const std::vector<float> far(2ul * width * kRows, 1.0f), zero(far.size(), 0.0f);
  gl.ActiveTexture(GL_TEXTURE0);
  fill(depth_map, 2, GL_DEPTH_COMPONENT, GL_FLOAT, far.data());
  fill(occlusion_map, 1, GL_RG, GL_FLOAT, zero.data());
  fill(lit_map, 2, GL_RGBA, GL_UNSIGNED_BYTE, zero.data());
}

}  // namespace thew::tools
