#include "render/gl_context.h"

#include "support/error.h"

#if __has_include(<GL/osmesa.h>)
#include <GL/osmesa.h>
#include <dlfcn.h>

#include <array>
#include <cstdlib>
#include <string_view>

#include "support/plain_text.h"

namespace granuscope {
namespace {

/// The functions of the library, which stays loaded until the program ends: Mesa's worker threads may outlive a
/// context.
struct OsMesaLibrary {
  decltype(&::OSMesaCreateContextAttribs) create = nullptr;
  decltype(&::OSMesaDestroyContext) destroy = nullptr;
  decltype(&::OSMesaMakeCurrent) make_current = nullptr;
  decltype(&::OSMesaGetProcAddress) lookup = nullptr;
};

OsMesaLibrary open_library() {
  void* handle = nullptr;
  for (const char* name : {"libOSMesa.so.8", "libOSMesa.so"}) {
    handle = ::dlopen(name, RTLD_NOW | RTLD_LOCAL);
    if (handle != nullptr) break;
  }
  if (handle == nullptr) {
    const char* reason = ::dlerror();
    throw EnvironmentError(
        "OSMesa cannot be loaded ({}), and without it this backend cannot render; install libosmesa6",
        reason == nullptr ? "no reason given" : reason);
  }
  OsMesaLibrary library;
  const auto fetch = [&]<typename Function>(Function& function, const char* name) {
    function = reinterpret_cast<Function>(::dlsym(handle, name));
    if (function == nullptr) {
      throw EnvironmentError("the OSMesa found here has no {}; install libosmesa6 of Mesa 12 to 25.0", name);
    }
  };
  fetch(library.create, "OSMesaCreateContextAttribs");
  fetch(library.destroy, "OSMesaDestroyContext");
  fetch(library.make_current, "OSMesaMakeCurrent");
  fetch(library.lookup, "OSMesaGetProcAddress");
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
    static const OsMesaLibrary opened = open_library();
    library_ = &opened;
    constexpr std::array<int, 13> attributes = {OSMESA_FORMAT,
                                                OSMESA_RGBA,
                                                OSMESA_DEPTH_BITS,
                                                0,
                                                OSMESA_PROFILE,
                                                OSMESA_CORE_PROFILE,
                                                OSMESA_CONTEXT_MAJOR_VERSION,
                                                3,
                                                OSMESA_CONTEXT_MINOR_VERSION,
                                                3,
                                                0,
                                                0,
                                                0};
    context_ = library_->create(attributes.data(), nullptr);
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

}  // namespace granuscope

#else  // Mesa 25.1 has no OSMesa any more

namespace granuscope {

std::unique_ptr<GlContext> make_osmesa_context() {
  throw EnvironmentError(
      "this program was built without OSMesa, which Mesa has dropped, so this backend cannot render; choose egl or "
      "none");
}

}  // namespace granuscope
#endif

#if defined(__SANITIZE_ADDRESS__)
/// OSMesa never frees the buffers it makes for a context (about 1 kB for a process); LeakSanitizer asks here what it
/// should keep quiet about. In this file, so that it is linked wherever OSMesa is used.
extern "C" const char* __lsan_default_suppressions() { return "leak:libOSMesa.so\n"; }
#endif
