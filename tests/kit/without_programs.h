#pragma once
#include <stdlib.h>

#include <filesystem>
#include <string>

namespace granuscope::test {

/// PATH pointing at a folder without any program, until the end of the test.
class WithoutPrograms {
 public:
  explicit WithoutPrograms(const std::filesystem::path& empty_folder) {
    const char* before = getenv("PATH");  // NOLINT(concurrency-mt-unsafe): tests are single-threaded
    if (before != nullptr) path_ = before;
    setenv("PATH", empty_folder.c_str(), 1);  // NOLINT(concurrency-mt-unsafe)
  }
  WithoutPrograms(const WithoutPrograms&) = delete;
  WithoutPrograms& operator=(const WithoutPrograms&) = delete;
  ~WithoutPrograms() { setenv("PATH", path_.c_str(), 1); }  // NOLINT(concurrency-mt-unsafe)

 private:
  std::string path_;
};

}  // namespace granuscope::test
