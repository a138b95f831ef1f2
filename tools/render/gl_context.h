// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <GL/glcorearb.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

struct osmesa_context;  // OSMesaContext points to it

namespace thew::tools {

// Every GL function that the renderer calls, by its name without "gl". None is linked: libGL beside
// OSMesa would turn each call into a no-op.
#define THEW_GL_FUNCTIONS(X)                          \
  X(GETSTRING, GetString)                             \
  X(GETERROR, GetError)                               \
  X(FINISH, Finish)                                   \
  X(ENABLE, Enable)                                   \
  X(DISABLE, Disable)                                 \
  X(VIEWPORT, Viewport)                               \
  X(CLEAR, Clear)                                     \
  X(SCISSOR, Scissor)                                 \
  X(DEPTHFUNC, DepthFunc)                             \
  X(DEPTHMASK, DepthMask)                             \
  X(BLITFRAMEBUFFER, BlitFramebuffer)                 \
  X(POLYGONOFFSET, PolygonOffset)                     \
  X(GENTEXTURES, GenTextures)                         \
  X(DELETETEXTURES, DeleteTextures)                   \
  X(BINDTEXTURE, BindTexture)                         \
  X(ACTIVETEXTURE, ActiveTexture)                     \
  X(TEXIMAGE2D, TexImage2D)                           \
  X(TEXSUBIMAGE2D, TexSubImage2D)                     \
  X(TEXPARAMETERI, TexParameteri)                     \
  X(GENFRAMEBUFFERS, GenFramebuffers)                 \
  X(DELETEFRAMEBUFFERS, DeleteFramebuffers)           \
  X(BINDFRAMEBUFFER, BindFramebuffer)                 \
  X(FRAMEBUFFERTEXTURE2D, FramebufferTexture2D)       \
  X(CHECKFRAMEBUFFERSTATUS, CheckFramebufferStatus)   \
  X(DRAWBUFFERS, DrawBuffers)                         \
  X(GENBUFFERS, GenBuffers)                           \
  X(BINDBUFFER, BindBuffer)                           \
  X(BUFFERDATA, BufferData)                           \
  X(BUFFERSUBDATA, BufferSubData)                     \
  X(GENVERTEXARRAYS, GenVertexArrays)                 \
  X(BINDVERTEXARRAY, BindVertexArray)                 \
  X(VERTEXATTRIBPOINTER, VertexAttribPointer)         \
  X(ENABLEVERTEXATTRIBARRAY, EnableVertexAttribArray) \
  X(VERTEXATTRIB4F, VertexAttrib4f)                   \
  X(DRAWELEMENTS, DrawElements)                       \
  X(DRAWARRAYS, DrawArrays)                           \
  X(CREATESHADER, CreateShader)                       \
  X(SHADERSOURCE, ShaderSource)                       \
  X(COMPILESHADER, CompileShader)                     \
  X(GETSHADERIV, GetShaderiv)                         \
  X(GETSHADERINFOLOG, GetShaderInfoLog)               \
  X(DELETESHADER, DeleteShader)                       \
  X(CREATEPROGRAM, CreateProgram)                     \
  X(ATTACHSHADER, AttachShader)                       \
  X(LINKPROGRAM, LinkProgram)                         \
  X(GETPROGRAMIV, GetProgramiv)                       \
  X(GETPROGRAMINFOLOG, GetProgramInfoLog)             \
  X(USEPROGRAM, UseProgram)                           \
  X(GETACTIVEUNIFORM, GetActiveUniform)               \
  X(GETUNIFORMLOCATION, GetUniformLocation)           \
  X(UNIFORM1I, Uniform1i)                             \
  X(UNIFORM1F, Uniform1f)                             \
  X(UNIFORM2F, Uniform2f)                             \
  X(UNIFORM2FV, Uniform2fv)                           \
  X(UNIFORM4FV, Uniform4fv)                           \
  X(UNIFORM3F, Uniform3f)                             \
  X(UNIFORMMATRIX4FV, UniformMatrix4fv)

struct Gl {
#define THEW_GL_POINTER(TYPE, NAME) PFNGL##TYPE##PROC NAME = nullptr;
  THEW_GL_FUNCTIONS(THEW_GL_POINTER)
#undef THEW_GL_POINTER
};

/// Error(kRetry) where the process may not have so many bytes more. To be asked before Mesa is,
/// which with LLVM crashes where memory ends.
void check_room(std::size_t bytes);

/// Makes "softpipe" or "llvmpipe" the driver of this process, whatever GALLIUM_DRIVER says. Mesa
/// asks once: only before the first context. Softpipe's pixels are the same on every processor.
void choose_driver(const std::string& name);

/// What Mesa reads from the environment, unless the user has set it. A context sees to it; to be
/// called before where the context is made beside other threads, which might read the environment
/// just then.
void set_driver_options();

/// A linked program and where its uniforms are, looked up once.
struct GlProgram {
  GLuint name = 0;
  std::map<std::string, GLint, std::less<>> uniforms;  ///< an array by its bare name

  /// -1, which GL ignores, for what the program does not use.
  GLint at(const char* uniform) const {
    const auto found = uniforms.find(uniform);
    return found == uniforms.end() ? -1 : found->second;
  }
};

/// An OSMesa context (GL 3.3 core) that draws into memory of its own. Objects of GL die with it.
/// The driver is Mesa's choice, GALLIUM_DRIVER's or choose_driver's. All that knows OSMesa is in
/// gl_context.cpp.
class GlContext {
 public:
  /// Error(kOutput) where there is no such context.
  GlContext(int width, int height);
  ~GlContext();
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;

  /// Before the first GL call of each drawing; the calling thread's context from then on.
  void make_current();
  /// Its own picture in another size; makes it current.
  void resize(int width, int height);
  /// Waits for all drawing: RGBA, rows from the bottom. Error(kOutput) if GL counted an error.
  const std::vector<std::uint8_t>& finish();
  /// Error(kOutput) with the compiler's words.
  GlProgram build_program(const char* vertex_source, const char* fragment_source);

  const Gl& gl() const { return gl_; }
  const std::string& driver() const { return driver_; }

 private:
  GLuint build_shader(GLenum type, const char* source);

  int width_, height_;
  osmesa_context* context_ = nullptr;
  std::vector<std::uint8_t> pixels_;
  Gl gl_;
  std::string driver_;
};

}  // namespace thew::tools
