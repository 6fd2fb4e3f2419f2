#pragma once
#include <memory>

#include "render/gl_context.h"

namespace granuscope {

/// A context of Mesa's off-screen library, whose library is loaded by this call. Throws EnvironmentError if it is
/// missing or has no OpenGL 3.3 core profile.
std::unique_ptr<GlContext> make_osmesa_context();

}  // namespace granuscope
