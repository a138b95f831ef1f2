// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <initializer_list>
#include <vector>

#include "tools/render/camera.h"
#include "tools/render/gl_context.h"
#include "tools/render/pixel_rect.h"

namespace thew::tools {

/// What the renderer's passes draw into and later ones read, and the calls that they share.
/// Textures are called `..._map`; those of surfaces and light have 2 x 2 samples a pixel.
class Canvas {
 public:
  Canvas(int width, int height);

  /// Error(kOutput) where the driver cannot. All is to be cleared then.
  void resize(int width, int height);
  PixelRect whole() const { return {0, 0, width, height}; }

  // Uniforms of the program that begin() named last.
  void set(const char* name, int value) const;
  void set(const char* name, double value) const;
  void set(const char* name, double x, double y) const;
  void set(const char* name, const Vec3& value) const;
  void set(const char* name, const Mat4& value) const;
  GLint at(const char* name) const { return program_->at(name); }
  void bind(const char* name, int unit, GLuint texture) const;

  /// Draws into a target of this size from here on.
  void begin(const GlProgram& program, GLuint target, int target_width, int target_height);
  /// Surfaces, in this rectangle, until end_surfaces().
  void begin_surfaces(const GlProgram& program, const PixelRect& rect);
  void end_surfaces();
  /// A pass over a rectangle of the screen, `scale` samples a pixel each way.
  void begin_screen(const GlProgram& program, GLuint target, int scale, const Camera& camera,
                    const PixelRect& rect);
  /// That pass, over all of the rectangle or only where a surface is seen.
  void draw_screen();
  void draw_covered();
  /// Surfaces, occlusion and light, in this rectangle.
  void clear(const PixelRect& rect);

  int width = 0, height = 0;
  GlContext context;
  const Gl& gl;
  GLuint shadow_map, colour_map, surface_map, depth_map, occlusion_map, lit_map;
  GLuint shadow_target, surface_target, occlusion_target, lit_target;

 private:
  GLuint make_texture(GLint format, GLenum layout, GLenum type, int w, int h);
  GLuint make_depth_texture(int w, int h);
  GLuint make_target(std::initializer_list<GLuint> colours, GLuint depth);
  void make_targets();
  void scissor(const PixelRect& rect, int scale) const;

  std::vector<GLuint> textures_, targets_;  ///< all, to be deleted
  GLuint no_array_;                         ///< the screen's vertices have no attributes
  const GlProgram* program_ = nullptr;
  PixelRect rect_;  ///< of the pass over the screen
  int scale_ = 1;
};

}  // namespace thew::tools
