#pragma once
#include <filesystem>
#include <string>

namespace granuscope {

/// A hidden folder for work in progress, removed with everything in it when it goes out of scope.
class ScratchFolder {
 public:
  /// Makes `parent`/.`name`-XXXXXX (and the parents). Throws EnvironmentError.
  ScratchFolder(const std::filesystem::path& parent, const std::string& name);
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ~ScratchFolder();

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace granuscope
