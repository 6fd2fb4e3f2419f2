#pragma once
#include <stdlib.h>

#include <filesystem>
#include <string>
#include <system_error>

namespace granuscope::synthetic {

/// A fresh folder that goes away with the test.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "granuscope-test-XXXXXX").string();
    path_ = mkdtemp(pattern.data());
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
  explicit WithoutPrograms(const std::filesystem::path& empty_folder)
      : path_(getenv("PATH")) {               // NOLINT(concurrency-mt-unsafe)
    setenv("PATH", empty_folder.c_str(), 1);  // NOLINT(concurrency-mt-unsafe)
  }
  WithoutPrograms(const WithoutPrograms&) = delete;
  WithoutPrograms& operator=(const WithoutPrograms&) = delete;
  ~WithoutPrograms() { setenv("PATH", path_.c_str(), 1); }  // NOLINT(concurrency-mt-unsafe)

 private:
  std::string path_;
};

}  // namespace granuscope::synthetic
