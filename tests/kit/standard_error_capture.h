#pragma once
#include <fcntl.h>
#include <unistd.h>

#include <cstdio>
#include <string>

#include "kit/temporary_folder.h"
#include "support/files.h"

namespace granuscope::test {

/// Takes what is written to standard error while it lives.
class StandardErrorCapture {
 public:
  StandardErrorCapture() : saved_(::dup(STDERR_FILENO)) {
    std::fflush(stderr);
    const int file = ::open((folder_ / "stderr").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    ::dup2(file, STDERR_FILENO);
    ::close(file);
  }
  StandardErrorCapture(const StandardErrorCapture&) = delete;
  StandardErrorCapture& operator=(const StandardErrorCapture&) = delete;
  ~StandardErrorCapture() {
    std::fflush(stderr);
    ::dup2(saved_, STDERR_FILENO);
    ::close(saved_);
  }
  std::string text() const {
    std::fflush(stderr);
    return read_file(folder_ / "stderr");
  }

 private:
  TemporaryFolder folder_;
  int saved_;
};

}  // namespace granuscope::test
