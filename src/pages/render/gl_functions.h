#pragma once

// The OpenGL functions the painter uses, fetched from whatever library the context came from: the program links no GL
// library, so that it starts where none is installed and one backend can stand in for another.

#define GL_GLEXT_PROTOTYPES  // only the declarations are used, for the types of the pointers below
#include <GL/glcorearb.h>

namespace granuscope {

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

}  // namespace granuscope
