#pragma once
#include <stdlib.h>  // NOLINT(modernize-deprecated-headers): setenv is POSIX

#include <filesystem>
#include <fstream>
#include <string>

namespace granuscope::test {

/// PATH of this process while it lives; a folder without any program hides them all.
class SearchPath {
 public:
  explicit SearchPath(const std::string& path) : before_(now()) {
    setenv("PATH", path.c_str(), 1);  // NOLINT(concurrency-mt-unsafe): tests are single-threaded
  }
  SearchPath(const SearchPath&) = delete;
  SearchPath& operator=(const SearchPath&) = delete;
  ~SearchPath() { setenv("PATH", before_.c_str(), 1); }  // NOLINT(concurrency-mt-unsafe)

  static std::string now() {
    const char* path = getenv("PATH");  // NOLINT(concurrency-mt-unsafe)
    return path == nullptr ? "" : path;
  }

 private:
  std::string before_;
};

/// A folder of programs that come before those of the system while it lives.
class FakePrograms {
 public:
  explicit FakePrograms(const std::filesystem::path& folder)
      : folder_(folder), path_(folder.string() + ":" + SearchPath::now()) {
    std::filesystem::create_directories(folder_);
  }

  /// From now on this is the only fake.
  void only(const std::string& name, const std::string& script) const {
    for (const auto& entry : std::filesystem::directory_iterator(folder_)) std::filesystem::remove(entry.path());
    std::ofstream(folder_ / name) << "#!/bin/sh\n" << script << '\n';
    std::filesystem::permissions(folder_ / name, std::filesystem::perms::owner_all);
  }

 private:
  std::filesystem::path folder_;
  SearchPath path_;
};

}  // namespace granuscope::test
