#include "render/gl_context.h"

#define EGL_NO_X11  // the types of a window system are not needed, nor their headers
#include <EGL/egl.h>
#include <EGL/eglext.h>
#if __has_include(<GL/osmesa.h>)
#include <GL/osmesa.h>
#endif
#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <initializer_list>
#include <string_view>

#include "support/error.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

std::string text_of(const GLubyte* text) {
  return text == nullptr ? "unknown" : reinterpret_cast<const char*>(text);  // GL's strings are unsigned char
}

std::string name_of(GLenum error) {
  switch (error) {
    case GL_INVALID_ENUM:
      return "GL_INVALID_ENUM";
    case GL_INVALID_VALUE:
      return "GL_INVALID_VALUE";
    case GL_INVALID_OPERATION:
      return "GL_INVALID_OPERATION";
    case GL_INVALID_FRAMEBUFFER_OPERATION:
      return "GL_INVALID_FRAMEBUFFER_OPERATION";
    case GL_OUT_OF_MEMORY:
      return "GL_OUT_OF_MEMORY";
    default:
      return fmt::format("error {:#x}", error);
  }
}

}  // namespace

void GlContext::load(Lookup lookup) {
  const auto fetch = [&]<typename Function>(Function& function, const char* gl_name) {
    function = reinterpret_cast<Function>(lookup(gl_name));
    if (function == nullptr) {
      throw EnvironmentError("the {} driver lacks {}, so it cannot render a picture; OpenGL 3.3 is needed", name(),
                             gl_name);
    }
  };
#define GRANUSCOPE_FETCH(function) fetch(gl_.function, "gl" #function);
  GRANUSCOPE_GL_FUNCTIONS(GRANUSCOPE_FETCH)
#undef GRANUSCOPE_FETCH

  GLint renderbuffer = 0, texture = 0;
  gl_.GetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &renderbuffer);
  gl_.GetIntegerv(GL_MAX_TEXTURE_SIZE, &texture);
  GLint viewport[2] = {0, 0};
  gl_.GetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport);
  max_size_ = std::min({renderbuffer, texture, viewport[0], viewport[1]});
  renderer_ = text_of(gl_.GetString(GL_RENDERER));
  version_ = text_of(gl_.GetString(GL_VERSION));
}

namespace {

std::unique_ptr<GlContext> with_reason(std::unique_ptr<GlContext> context, const std::string& reason) {
  context->set_reason(reason);
  return context;
}

}  // namespace

void require_known_backend(const std::string& backend) {
  for (const char* known : {"auto", "osmesa", "egl", "none"}) {
    if (backend == known) return;
  }
  throw InputError("there is no backend '{}' to render with; choose auto, osmesa, egl or none", backend);
}

std::unique_ptr<GlContext> make_gl_context(const std::string& backend) {
  require_known_backend(backend);
  if (backend == "osmesa") return with_reason(make_osmesa_context(), "OSMesa was asked for by name");
  if (backend == "egl") return with_reason(make_egl_context(), "EGL was asked for by name");
  if (backend != "auto") throw InputError("the backend '{}' has no OpenGL; choose auto, osmesa or egl", backend);
  std::string without_osmesa;
  try {
    return with_reason(make_osmesa_context(),
                       "OSMesa was found, and it is the first choice: it needs no display and no GPU");
  } catch (const EnvironmentError& error) {
    without_osmesa = error.what();
  }
  try {
    return with_reason(make_egl_context(), fmt::format("EGL stands in, without a display: {}", without_osmesa));
  } catch (const EnvironmentError& error) {
    throw EnvironmentError("{}; nor can EGL stand in: {}", without_osmesa, error.what());
  }
}

std::unique_ptr<GlContext> find_gl_context(const std::string& backend, std::string& why_none) {
  try {
    return make_gl_context(backend);
  } catch (const EnvironmentError& error) {
    if (backend != "auto") throw;
    why_none = error.what();
    return nullptr;
  }
}

void check_gl(const GlContext& context, const char* step) {
  const GLenum error = context.gl().GetError();
  if (error == GL_NO_ERROR) return;
  // One call may note several; the list is emptied so that the next check starts clean.
  for (int i = 0; i < 16 && context.gl().GetError() != GL_NO_ERROR; ++i) {
  }
  throw EnvironmentError("OpenGL reported {} while it was {}, so the picture would be wrong ({}, {})", name_of(error),
                         step, context.renderer(), context.version());
}

namespace {

[[noreturn]] void fail(const GlContext& context, const std::string& what, const std::string& log) {
  throw EnvironmentError("the driver {} ({}) cannot {}, so no picture can be rendered: {}", context.renderer(),
                         context.version(), what, log);
}

/// A compiled shader, needed only until its program is linked.
class Shader {
 public:
  Shader(const GlContext& context, GLenum kind, const std::string& source)
      : gl_(context.gl()), id_(gl_.CreateShader(kind)) {
    const char* text = source.c_str();
    gl_.ShaderSource(id_, 1, &text, nullptr);
    gl_.CompileShader(id_);
  }
  Shader(const Shader&) = delete;
  Shader& operator=(const Shader&) = delete;
  ~Shader() { gl_.DeleteShader(id_); }

  void require_compiled(const GlContext& context) const {
    GLint compiled = GL_FALSE;
    gl_.GetShaderiv(id_, GL_COMPILE_STATUS, &compiled);
    if (compiled == GL_TRUE) return;
    std::array<char, 2048> log{};
    gl_.GetShaderInfoLog(id_, static_cast<GLsizei>(log.size()), nullptr, log.data());
    fail(context, "compile a shader", log.data());
  }
  GLuint id() const { return id_; }

 private:
  const GlFunctions& gl_;
  GLuint id_;
};

}  // namespace

GlFramebuffer::GlFramebuffer(const GlContext& context, int width, int height) : gl_(context.gl()) {
  gl_.GenFramebuffers(1, &framebuffer_);
  gl_.GenRenderbuffers(1, &colour_);
  gl_.BindRenderbuffer(GL_RENDERBUFFER, colour_);
  gl_.RenderbufferStorage(GL_RENDERBUFFER, GL_R8, width, height);
  gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  gl_.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, colour_);
  gl_.ReadBuffer(GL_COLOR_ATTACHMENT0);
  const GLenum status = gl_.CheckFramebufferStatus(GL_FRAMEBUFFER);
  if (status != GL_FRAMEBUFFER_COMPLETE) {
    gl_.DeleteFramebuffers(1, &framebuffer_);
    gl_.DeleteRenderbuffers(1, &colour_);
    fail(context, fmt::format("make a framebuffer of {} x {}", width, height), fmt::format("status {:#x}", status));
  }
}

GlFramebuffer::~GlFramebuffer() {
  gl_.BindFramebuffer(GL_FRAMEBUFFER, 0);
  gl_.DeleteFramebuffers(1, &framebuffer_);
  gl_.DeleteRenderbuffers(1, &colour_);
}

GlProgram::GlProgram(const GlContext& context, const std::string& vertex_source, const std::string& fragment_source)
    : gl_(context.gl()) {
  const Shader vertex(context, GL_VERTEX_SHADER, vertex_source);
  const Shader fragment(context, GL_FRAGMENT_SHADER, fragment_source);
  vertex.require_compiled(context);
  fragment.require_compiled(context);
  id_ = gl_.CreateProgram();
  gl_.AttachShader(id_, vertex.id());
  gl_.AttachShader(id_, fragment.id());
  gl_.LinkProgram(id_);
  GLint linked = GL_FALSE;
  gl_.GetProgramiv(id_, GL_LINK_STATUS, &linked);
  if (linked == GL_TRUE) return;
  std::array<char, 2048> log{};
  gl_.GetProgramInfoLog(id_, static_cast<GLsizei>(log.size()), nullptr, log.data());
  gl_.DeleteProgram(id_);
  fail(context, "link a program", log.data());
}

namespace {

/// The first library that there is of these names. It stays loaded until the program ends: drivers and Mesa's worker
/// threads may outlive a context.
class LoadedLibrary {
 public:
  LoadedLibrary(const char* called, const char* package, const char* versions, std::initializer_list<const char*> files)
      : called_(called), package_(package), versions_(versions) {
    for (const char* file : files) {
      if (handle_ == nullptr) handle_ = ::dlopen(file, RTLD_NOW | RTLD_LOCAL);
    }
    if (handle_ != nullptr) return;
    const char* reason = ::dlerror();
    throw EnvironmentError("{} cannot be loaded ({}), and without it this backend cannot render; install {}", called,
                           reason == nullptr ? "no reason given" : reason, package);
  }

  template <typename Function>
  void fetch(Function& function, const char* name) const {
    function = reinterpret_cast<Function>(::dlsym(handle_, name));
    if (function != nullptr) return;
    throw EnvironmentError("the {} found here has no {}; install {} {}", called_, name, package_, versions_);
  }

 private:
  const char *called_, *package_, *versions_;
  void* handle_ = nullptr;
};

struct EglLibrary {
  decltype(&::eglBindAPI) bind_api = nullptr;
  decltype(&::eglChooseConfig) choose_config = nullptr;
  decltype(&::eglCreateContext) create_context = nullptr;
  decltype(&::eglDestroyContext) destroy_context = nullptr;
  decltype(&::eglGetError) get_error = nullptr;
  decltype(&::eglGetPlatformDisplay) get_platform_display = nullptr;
  decltype(&::eglGetProcAddress) lookup = nullptr;
  decltype(&::eglInitialize) initialize = nullptr;
  decltype(&::eglMakeCurrent) make_current = nullptr;
  decltype(&::eglQueryString) query_string = nullptr;
};

EglLibrary open_egl() {
  const LoadedLibrary opened("EGL", "libegl1", "of EGL 1.5", {"libEGL.so.1"});
  EglLibrary library;
  opened.fetch(library.bind_api, "eglBindAPI");
  opened.fetch(library.choose_config, "eglChooseConfig");
  opened.fetch(library.create_context, "eglCreateContext");
  opened.fetch(library.destroy_context, "eglDestroyContext");
  opened.fetch(library.get_error, "eglGetError");
  opened.fetch(library.get_platform_display, "eglGetPlatformDisplay");
  opened.fetch(library.lookup, "eglGetProcAddress");
  opened.fetch(library.initialize, "eglInitialize");
  opened.fetch(library.make_current, "eglMakeCurrent");
  opened.fetch(library.query_string, "eglQueryString");
  return library;
}

/// The library and its display, which are one for the whole program.
struct EglDisplay {
  EglLibrary egl = open_egl();
  EGLDisplay display = EGL_NO_DISPLAY;

  [[noreturn]] void fail(const char* step) const {
    throw EnvironmentError(
        "EGL cannot {} (error {:#x}), so this backend cannot render; install libegl-mesa0 and libgl1-mesa-dri, or use "
        "--backend osmesa",
        step, egl.get_error());
  }

  EglDisplay() {
    const char* const known = egl.query_string(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    if (known == nullptr || std::strstr(known, "EGL_MESA_platform_surfaceless") == nullptr) {
      throw EnvironmentError(
          "the EGL found here cannot do without a window system (EGL_MESA_platform_surfaceless); install libegl-mesa0, "
          "or use --backend osmesa");
    }
    display = egl.get_platform_display(EGL_PLATFORM_SURFACELESS_MESA, nullptr, nullptr);
    if (display == EGL_NO_DISPLAY) fail("open a display without a window system");
    if (egl.initialize(display, nullptr, nullptr) == EGL_FALSE) fail("start");
  }
};

class EglContext : public GlContext {
 public:
  EglContext() {
    static const EglDisplay opened;
    display_ = &opened;
    const EglLibrary& egl = opened.egl;
    if (egl.bind_api(EGL_OPENGL_API) == EGL_FALSE) opened.fail("do OpenGL");
    constexpr std::array<EGLint, 5> wanted = {EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_NONE};
    EGLConfig config = nullptr;
    EGLint found = 0;
    if (egl.choose_config(opened.display, wanted.data(), &config, 1, &found) == EGL_FALSE || found < 1) {
      opened.fail("find a configuration for OpenGL");
    }
    constexpr std::array<EGLint, 7> version = {
        EGL_CONTEXT_MAJOR_VERSION,           3,       EGL_CONTEXT_MINOR_VERSION, 3, EGL_CONTEXT_OPENGL_PROFILE_MASK,
        EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
    context_ = egl.create_context(opened.display, config, EGL_NO_CONTEXT, version.data());
    if (context_ == EGL_NO_CONTEXT) opened.fail("make a context of OpenGL 3.3");
    try {
      activate();
      load(egl.lookup);
    } catch (...) {
      release();
      throw;
    }
  }
  ~EglContext() override { release(); }

  void make_current() override { activate(); }
  std::string name() const override { return "egl"; }

 private:
  void activate() {
    const EglLibrary& egl = display_->egl;
    if (egl.bind_api(EGL_OPENGL_API) == EGL_FALSE ||
        egl.make_current(display_->display, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_FALSE) {
      display_->fail("make its context current");
    }
  }
  void release() {
    display_->egl.make_current(display_->display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    display_->egl.destroy_context(display_->display, context_);
  }

  const EglDisplay* display_ = nullptr;
  EGLContext context_ = EGL_NO_CONTEXT;
};

}  // namespace

std::unique_ptr<GlContext> make_egl_context() { return std::make_unique<EglContext>(); }

#if __has_include(<GL/osmesa.h>)
namespace {

struct OsMesaLibrary {
  decltype(&::OSMesaCreateContextAttribs) create = nullptr;
  decltype(&::OSMesaDestroyContext) destroy = nullptr;
  decltype(&::OSMesaMakeCurrent) make_current = nullptr;
  decltype(&::OSMesaGetProcAddress) lookup = nullptr;
};

OsMesaLibrary open_osmesa() {
  const LoadedLibrary opened("OSMesa", "libosmesa6", "of Mesa 12 to 25.0", {"libOSMesa.so.8", "libOSMesa.so"});
  OsMesaLibrary library;
  opened.fetch(library.create, "OSMesaCreateContextAttribs");
  opened.fetch(library.destroy, "OSMesaDestroyContext");
  opened.fetch(library.make_current, "OSMesaMakeCurrent");
  opened.fetch(library.lookup, "OSMesaGetProcAddress");
  return library;
}

/// Asked for a driver that it was not built with, as the desktop or the cluster may set it for other programs, OSMesa
/// does not refuse but crashes.
void require_known_driver() {
  const char* driver = std::getenv("GALLIUM_DRIVER");
  if (driver == nullptr) return;
  for (const std::string_view known : {"", "llvmpipe", "softpipe"}) {
    if (driver == known) return;
  }
  throw EnvironmentError(
      "GALLIUM_DRIVER={} names a driver that OSMesa does not have, so no picture can be rendered; unset it, or "
      "set it to llvmpipe",
      single_line(driver, 40));
}

class OsMesaContext : public GlContext {
 public:
  OsMesaContext() {
    require_known_driver();
    static const OsMesaLibrary opened = open_osmesa();
    library_ = &opened;
    constexpr std::array<std::array<int, 2>, 6> attributes = {{{OSMESA_FORMAT, OSMESA_RGBA},
                                                               {OSMESA_DEPTH_BITS, 0},
                                                               {OSMESA_PROFILE, OSMESA_CORE_PROFILE},
                                                               {OSMESA_CONTEXT_MAJOR_VERSION, 3},
                                                               {OSMESA_CONTEXT_MINOR_VERSION, 3}}};
    context_ = library_->create(attributes.front().data(), nullptr);
    if (context_ == nullptr) {
      throw EnvironmentError(
          "OSMesa gives no OpenGL 3.3 core context, so no picture can be rendered; install libosmesa6 of Debian 12 or "
          "later, "
          "and unset GALLIUM_DRIVER if it is set");
    }
    try {
      activate();
      load(library_->lookup);
    } catch (...) {
      library_->destroy(context_);
      throw;
    }
  }
  ~OsMesaContext() override { library_->destroy(context_); }

  void make_current() override { activate(); }
  std::string name() const override { return "osmesa"; }

 private:
  void activate() {
    if (library_->make_current(context_, default_buffer_.data(), GL_UNSIGNED_BYTE, edge, edge) == GL_FALSE) {
      throw EnvironmentError("OSMesa cannot make its context current, so no picture can be rendered");
    }
  }

  /// OSMesa insists on a buffer of the caller; nothing is painted to it.
  static constexpr int edge = 16;
  std::array<unsigned char, 4 * edge * edge> default_buffer_{};
  const OsMesaLibrary* library_ = nullptr;
  OSMesaContext context_ = nullptr;
};

}  // namespace

std::unique_ptr<GlContext> make_osmesa_context() { return std::make_unique<OsMesaContext>(); }
#else  // Mesa 25.1 has no OSMesa any more
std::unique_ptr<GlContext> make_osmesa_context() {
  throw EnvironmentError(
      "this program was built without OSMesa, which Mesa has dropped, so this backend cannot render; choose egl or "
      "none");
}
#endif

}  // namespace granuscope

#if defined(__SANITIZE_ADDRESS__)
/// OSMesa never frees the buffers it makes for a context (about 1 kB for a process); LeakSanitizer asks here what it
/// should keep quiet about. In this file, so that it is linked wherever OSMesa is used.
extern "C" const char* __lsan_default_suppressions() { return "leak:libOSMesa.so\n"; }
#endif
