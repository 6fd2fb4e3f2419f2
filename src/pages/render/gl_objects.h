#pragma once
#include <string>

#include "render/gl_context.h"

namespace granuscope {

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
