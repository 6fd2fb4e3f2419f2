#pragma once
#include <memory>

#include "render/gl_context.h"

namespace granuscope {

/// A context of EGL's surfaceless platform: no display server, no window, no default buffer. The library is loaded now
/// and not earlier. Throws EnvironmentError if it is missing or cannot give OpenGL 3.3.
std::unique_ptr<GlContext> make_egl_context();

}  // namespace granuscope
