#include "render/gl_context.h"

#define EGL_NO_X11  // the types of a window system are not needed, nor their headers
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <dlfcn.h>

#include <array>
#include <cstring>

#include "support/error.h"

namespace granuscope {
namespace {

/// The functions of the library, which stays loaded until the program ends: drivers may leave threads behind.
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

EglLibrary open_library() {
  void* const handle = ::dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) {
    const char* reason = ::dlerror();
    throw EnvironmentError("EGL cannot be loaded ({}), and without it this backend cannot render; install libegl1",
                           reason == nullptr ? "no reason given" : reason);
  }
  EglLibrary library;
  const auto fetch = [&]<typename Function>(Function& function, const char* name) {
    function = reinterpret_cast<Function>(::dlsym(handle, name));
    if (function == nullptr) {
      throw EnvironmentError("the EGL found here has no {}; install libegl1 of EGL 1.5", name);
    }
  };
  fetch(library.bind_api, "eglBindAPI");
  fetch(library.choose_config, "eglChooseConfig");
  fetch(library.create_context, "eglCreateContext");
  fetch(library.destroy_context, "eglDestroyContext");
  fetch(library.get_error, "eglGetError");
  fetch(library.get_platform_display, "eglGetPlatformDisplay");
  fetch(library.lookup, "eglGetProcAddress");
  fetch(library.initialize, "eglInitialize");
  fetch(library.make_current, "eglMakeCurrent");
  fetch(library.query_string, "eglQueryString");
  return library;
}

/// The library and its display, which are one for the whole program.
struct EglDisplay {
  EglLibrary egl = open_library();
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

}  // namespace granuscope
