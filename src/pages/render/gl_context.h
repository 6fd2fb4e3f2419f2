#pragma once
#include <memory>
#include <string>

#define GL_GLEXT_PROTOTYPES  // only the declarations are used, for the types of the pointers below
#include <GL/glcorearb.h>

namespace granuscope {

// The OpenGL functions the painter uses, fetched from whatever library the context came from: the program links no GL
// library, so that it starts where none is installed and one backend can stand in for another.
// clang-format off
#define GRANUSCOPE_GL_FUNCTIONS(X)                                                                                \
  X(ActiveTexture) X(AttachShader) X(BindBuffer) X(BindFramebuffer) X(BindRenderbuffer) X(BindTexture)            \
  X(BindVertexArray) X(BlendEquation) X(BufferData) X(CheckFramebufferStatus) X(Clear) X(ClearColor) X(CompileShader)              \
  X(CreateProgram) X(CreateShader) X(DeleteBuffers) X(DeleteFramebuffers) X(DeleteProgram)                        \
  X(DeleteRenderbuffers) X(DeleteShader) X(DeleteTextures) X(DeleteVertexArrays) X(Disable) X(DrawArrays) X(Enable)         \
  X(FramebufferRenderbuffer) X(GenBuffers) X(GenFramebuffers) X(GenRenderbuffers) X(GenTextures)                  \
  X(GenVertexArrays) X(GetError) X(GetIntegerv) X(GetProgramInfoLog) X(GetProgramiv) X(GetShaderInfoLog)          \
  X(GetShaderiv) X(GetString) X(GetUniformLocation) X(LinkProgram) X(PixelStorei) X(ReadBuffer) X(ReadPixels)     \
  X(RenderbufferStorage) X(ShaderSource) X(TexBuffer) X(Uniform1i) X(Uniform2i) X(UseProgram) X(Viewport)
// clang-format on

struct GlFunctions {
// A declared name cannot stand in parentheses.
#define GRANUSCOPE_DECLARE(name) decltype(&::gl##name) name = nullptr;  // NOLINT(bugprone-macro-parentheses)
  GRANUSCOPE_GL_FUNCTIONS(GRANUSCOPE_DECLARE)
#undef GRANUSCOPE_DECLARE
};

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

/// Owners of GL objects: each frees its object when it goes. Their context must outlive them and be current.

class GlBuffer {
 public:
  explicit GlBuffer(const GlContext& context) : gl_(context.gl()) { gl_.GenBuffers(1, &id_); }
  GlBuffer(const GlBuffer&) = delete;
  GlBuffer& operator=(const GlBuffer&) = delete;
  ~GlBuffer() { gl_.DeleteBuffers(1, &id_); }
  GLuint id() const { return id_; }

 private:
  const GlFunctions& gl_;
  GLuint id_ = 0;
};

class GlTexture {
 public:
  explicit GlTexture(const GlContext& context) : gl_(context.gl()) { gl_.GenTextures(1, &id_); }
  GlTexture(const GlTexture&) = delete;
  GlTexture& operator=(const GlTexture&) = delete;
  ~GlTexture() { gl_.DeleteTextures(1, &id_); }
  GLuint id() const { return id_; }

 private:
  const GlFunctions& gl_;
  GLuint id_ = 0;
};

class GlVertexArray {
 public:
  explicit GlVertexArray(const GlContext& context) : gl_(context.gl()) { gl_.GenVertexArrays(1, &id_); }
  GlVertexArray(const GlVertexArray&) = delete;
  GlVertexArray& operator=(const GlVertexArray&) = delete;
  ~GlVertexArray() { gl_.DeleteVertexArrays(1, &id_); }
  GLuint id() const { return id_; }

 private:
  const GlFunctions& gl_;
  GLuint id_ = 0;
};

/// A framebuffer of one byte a pixel (R8), bound and complete once constructed. Throws EnvironmentError if the driver
/// cannot.
class GlFramebuffer {
 public:
  GlFramebuffer(const GlContext& context, int width, int height);
  GlFramebuffer(const GlFramebuffer&) = delete;
  GlFramebuffer& operator=(const GlFramebuffer&) = delete;
  ~GlFramebuffer();

 private:
  const GlFunctions& gl_;
  GLuint framebuffer_ = 0;
  GLuint colour_ = 0;
};

/// A linked program. Throws EnvironmentError with the driver's log if it does not compile or link.
class GlProgram {
 public:
  GlProgram(const GlContext& context, const std::string& vertex_source, const std::string& fragment_source);
  GlProgram(const GlProgram&) = delete;
  GlProgram& operator=(const GlProgram&) = delete;
  ~GlProgram() { gl_.DeleteProgram(id_); }
  GLuint id() const { return id_; }
  GLint uniform(const char* name) const { return gl_.GetUniformLocation(id_, name); }

 private:
  const GlFunctions& gl_;
  GLuint id_ = 0;
};

}  // namespace granuscope
