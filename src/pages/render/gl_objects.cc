#include "render/gl_objects.h"

#include <fmt/format.h>

#include <array>

#include "support/error.h"

namespace granuscope {
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

}  // namespace granuscope
