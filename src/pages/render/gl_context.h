#pragma once
#include <memory>
#include <string>

#include "render/gl_functions.h"

namespace granuscope {
/// An OpenGL 3.3 core context without a window. Nothing is ever painted to its default buffer: the painter brings its
/// own framebuffer, and then every backend on the same driver gives the same pixels.
class GlContext {
 public:
  GlContext() = default;
  GlContext(const GlContext&) = delete;
  GlContext& operator=(const GlContext&) = delete;
  virtual ~GlContext() = default;

  /// Makes it the context of this thread. Throws EnvironmentError.
  virtual void make_current() = 0;
  /// "osmesa" or "egl".
  virtual std::string name() const = 0;
  /// Why this backend was chosen, as a sentence for people.
  const std::string& reason() const { return reason_; }
  void set_reason(const std::string& reason) { reason_ = reason; }

  const GlFunctions& gl() const { return gl_; }
  /// Largest edge of a framebuffer in pixels. Drivers do not refuse more, they leave it blank: callers must check.
  int max_size() const { return max_size_; }
  const std::string& renderer() const { return renderer_; }  ///< GL_RENDERER, e.g. "llvmpipe (LLVM 15.0.6, 256 bits)"
  const std::string& version() const { return version_; }    ///< GL_VERSION

 protected:
  using Lookup = void (*(*)(const char*))();
  /// Fetches every function and asks for limits and names; the context must be current. Throws EnvironmentError.
  void load(Lookup lookup);

 private:
  GlFunctions gl_;
  int max_size_ = 0;
  std::string renderer_, version_, reason_;
};

/// Throws InputError unless `backend` is auto, osmesa, egl, or none: no OpenGL, all is painted by the processor.
void require_known_backend(const std::string& backend);

/// Makes the context for `backend`: "osmesa" (Mesa's off-screen library), "egl" (EGL without a window system), or
/// "auto": OSMesa, or EGL where that is absent. Libraries are loaded now and not earlier. Throws EnvironmentError if
/// the backend cannot start, InputError if there is no such backend.
std::unique_ptr<GlContext> make_gl_context(const std::string& backend);

/// The same, except that "auto" on a machine without OpenGL gives none, and `why_none` says why: the processor then
/// paints the same pixels.
std::unique_ptr<GlContext> find_gl_context(const std::string& backend, std::string& why_none);

/// Throws EnvironmentError naming the error and `step` if GL has noted one.
void check_gl(const GlContext& context, const char* step);

/// A context of EGL's surfaceless platform: no display server, no window, no default buffer. The library is loaded now
/// and not earlier. Throws EnvironmentError if it is missing or cannot give OpenGL 3.3.
std::unique_ptr<GlContext> make_egl_context();

/// A context of Mesa's off-screen library, whose library is loaded by this call. Throws EnvironmentError if it is
/// missing or has no OpenGL 3.3 core profile.
std::unique_ptr<GlContext> make_osmesa_context();

}  // namespace granuscope
