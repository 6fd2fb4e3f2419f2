#include "render/gl_context.h"

#include <fmt/format.h>

#include <algorithm>

#include "support/error.h"

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
  if (backend != "auto") {
    throw InputError("the backend '{}' has no OpenGL; choose auto, osmesa or egl", backend);
  }
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

}  // namespace granuscope
