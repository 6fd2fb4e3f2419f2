#pragma once
#include <stdlib.h>

#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>

namespace granuscope::synthetic {

/// A fresh folder that goes away with the test.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "granuscope-test-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("no temporary folder");
    path_ = pattern;
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

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

}  // namespace granuscope::synthetic
