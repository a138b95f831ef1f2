// SPDX-License-Identifier: Apache-2.0
#include "tools/render/gl_context.h"

#include <GL/osmesa.h>
#include <dlfcn.h>
#include <sys/mman.h>

#include <cstdlib>

#include "rig/types.h"

#ifdef THEW_SANITIZED
// OSMesa 22.3 itself leaves 184 bytes behind with each context, destroyed or not.
extern "C" const char* __lsan_default_suppressions() { return "leak:libOSMesa.so"; }
extern "C" const char* __lsan_default_options() { return "print_suppressions=0"; }
// Nor can a sanitizer see by which atomics Mesa's own threads wait for each other.
extern "C" const char* __tsan_default_options() { return "ignore_noninstrumented_modules=1"; }
#endif

namespace thew::tools {
namespace {

[[noreturn]] void fail(const std::string& cause) {
  throw Error(ErrorCode::kOutput, "renderer: " + cause);
}

const char* kInstall = "; install libosmesa6 and link neither libGL nor libGLU beside it";

std::string chosen_driver;  // "": not chosen

// Bytes that a context takes with its shaders, and a picture of so many pixels, measured with
// llvmpipe, which takes more than softpipe: 390 MiB (threads and their heaps most of it), 133 a
// pixel, and 24 for the renderer's backdrops.
constexpr std::size_t kContext = std::size_t{448} << 20, kPixel = 168;
constexpr std::size_t kLibraries = std::size_t{192} << 20;  // OSMesa and LLVM

std::size_t bytes_of(int width, int height) { return kPixel * width * height; }

// Mesa brings LLVM, which takes longer to load than most commands take: with the first context. It
// stays loaded, with the threads that it may have.
struct Mesa {
  decltype(&OSMesaCreateContextAttribs) create;
  decltype(&OSMesaDestroyContext) destroy;
  decltype(&OSMesaMakeCurrent) make_current;
  decltype(&OSMesaGetProcAddress) address;
};

template <typename Function>
void find(void* library, const char* name, Function& function) {
  function = reinterpret_cast<Function>(::dlsym(library, name));
  if (!function) fail(std::string("libOSMesa has no ") + name + kInstall);
}

Mesa load_mesa() {
  check_room(kLibraries + kContext);
  void* library = ::dlopen("libOSMesa.so.8", RTLD_NOW | RTLD_LOCAL);
  if (!library) fail(std::string(::dlerror()) + kInstall);
  Mesa mesa;
  find(library, "OSMesaCreateContextAttribs", mesa.create);
  find(library, "OSMesaDestroyContext", mesa.destroy);
  find(library, "OSMesaMakeCurrent", mesa.make_current);
  find(library, "OSMesaGetProcAddress", mesa.address);
  return mesa;
}

const Mesa& mesa() {
  static const Mesa mesa = load_mesa();
  return mesa;
}

OSMesaContext create_context(int width, int height) {
  mesa();
  check_room(kContext + bytes_of(width, height));
  const char* driver = std::getenv("GALLIUM_DRIVER");
  if (driver && *driver && std::string(driver) != "llvmpipe" && std::string(driver) != "softpipe") {
    // OSMesa crashes on a name that it does not know.
    fail(std::string("GALLIUM_DRIVER is \"") + driver + "\"; choose llvmpipe or softpipe");
  }
  set_driver_options();
  const int attributes[] = {OSMESA_FORMAT,
                            OSMESA_RGBA,
                            OSMESA_DEPTH_BITS,
                            0,
                            OSMESA_PROFILE,
                            OSMESA_CORE_PROFILE,
                            OSMESA_CONTEXT_MAJOR_VERSION,
                            3,
                            OSMESA_CONTEXT_MINOR_VERSION,
                            3,
                            0};
  return mesa().create(attributes, nullptr);
}

}  // namespace

void check_room(std::size_t bytes) {
  if (bytes == 0) return;
  void* room = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE,
                      MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (room == MAP_FAILED) {
    throw Error(ErrorCode::kRetry,
                "renderer: drawing takes " + std::to_string(bytes >> 20) +
                    " MiB of memory, which the system does not give; free some, "
                    "raise the limit (ulimit -v) or choose a smaller render.size, "
                    "then run again");
  }
  ::munmap(room, bytes);
}

void set_driver_options() {
  const auto is = [](const char* name, const std::string& value) {
    const char* now = std::getenv(name);
    return now && now == value;
  };
  // No cache on disk that runs would share. The pixels do not depend on the number of threads.
  if (!is("MESA_SHADER_CACHE_DISABLE", "true")) setenv("MESA_SHADER_CACHE_DISABLE", "true", 1);
  if (!std::getenv("LP_NUM_THREADS")) setenv("LP_NUM_THREADS", "2", 0);
}

void choose_driver(const std::string& name) {
  chosen_driver = name;
  setenv("GALLIUM_DRIVER", name.c_str(), 1);
}

GlContext::GlContext(int width, int height)
    : width_(width), height_(height), context_(create_context(width, height)) {
  if (!context_) fail(std::string("OSMesa gives no context of GL 3.3") + kInstall);
  try {
    pixels_.resize(4ul * width * height);
    make_current();
#define THEW_GL_LOAD(TYPE, NAME)                                              \
  gl_.NAME = reinterpret_cast<PFNGL##TYPE##PROC>(mesa().address("gl" #NAME)); \
  if (!gl_.NAME) fail(std::string("OSMesa has no gl" #NAME) + kInstall);
    THEW_GL_FUNCTIONS(THEW_GL_LOAD)
#undef THEW_GL_LOAD
    const GLubyte* version = gl_.GetString(GL_VERSION);
    const GLubyte* renderer = gl_.GetString(GL_RENDERER);
    if (!version || !renderer) fail(std::string("OSMesa's GL does not answer") + kInstall);
    driver_ = std::string(reinterpret_cast<const char*>(renderer)) + ", " +
              reinterpret_cast<const char*>(version);
    if (!driver_.starts_with(chosen_driver)) {
      fail("asked for " + chosen_driver + ", Mesa gives " + driver_ +
           "; choose it before anything is drawn");
    }
  } catch (...) {
    mesa().destroy(context_);
    throw;
  }
}

GlContext::~GlContext() { mesa().destroy(context_); }

void GlContext::make_current() {
  if (!mesa().make_current(context_, pixels_.data(), GL_UNSIGNED_BYTE, width_, height_)) {
    fail("OSMesa refuses an image of " + std::to_string(width_) + " x " + std::to_string(height_) +
         "; choose a smaller size");
  }
}

void GlContext::resize(int width, int height) {
  check_room(bytes_of(width, height));
  width_ = width;
  height_ = height;
  pixels_.resize(4ul * width * height);
  make_current();
}

const std::vector<std::uint8_t>& GlContext::finish() {
  gl_.Finish();
  if (const GLenum error = gl_.GetError(); error != GL_NO_ERROR) {
    fail("GL error " + std::to_string(error) + " (" + driver_ + ")" +
         (error == GL_OUT_OF_MEMORY ? "; choose a smaller size" : "; report it as a bug"));
  }
  return pixels_;
}

GLuint GlContext::build_shader(GLenum type, const char* source) {
  const GLuint shader = gl_.CreateShader(type);
  gl_.ShaderSource(shader, 1, &source, nullptr);
  gl_.CompileShader(shader);
  GLint done = 0;
  gl_.GetShaderiv(shader, GL_COMPILE_STATUS, &done);
  if (done) return shader;
  char log[1024] = "";
  gl_.GetShaderInfoLog(shader, sizeof log, nullptr, log);
  fail("a shader does not compile (" + driver_ + "): " + log + "; report it as a bug");
}

GlProgram GlContext::build_program(const char* vertex_source, const char* fragment_source) {
  GlProgram program{gl_.CreateProgram(), {}};
  for (const GLuint shader : {build_shader(GL_VERTEX_SHADER, vertex_source),
                              build_shader(GL_FRAGMENT_SHADER, fragment_source)}) {
    gl_.AttachShader(program.name, shader);
    gl_.DeleteShader(shader);  // lives on in the program
  }
  gl_.LinkProgram(program.name);
  GLint done = 0;
  gl_.GetProgramiv(program.name, GL_LINK_STATUS, &done);
  if (!done) {
    char log[1024] = "";
    gl_.GetProgramInfoLog(program.name, sizeof log, nullptr, log);
    fail("a shader does not link (" + driver_ + "): " + log + "; report it as a bug");
  }
  GLint count = 0;
  gl_.GetProgramiv(program.name, GL_ACTIVE_UNIFORMS, &count);
  for (GLint i = 0; i < count; ++i) {
    char name[64] = "";
    GLint size = 0;
    GLenum type = 0;
    gl_.GetActiveUniform(program.name, i, sizeof name, nullptr, &size, &type, name);
    const std::string whole = name;
    program.uniforms[whole.substr(0, whole.find('['))] = gl_.GetUniformLocation(program.name, name);
  }
  return program;
}

}  // namespace thew::tools
