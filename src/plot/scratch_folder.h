#pragma once
#include <filesystem>
#include <string>

namespace granuscope {

/// A hidden folder for work in progress, removed with everything in it when it goes out of scope
/// (and by remove_leftovers, should the program be killed before).
class ScratchFolder {
 public:
  /// Makes a folder of its own in `parent` (and the parents), with `name` in its name. Throws EnvironmentError.
  ScratchFolder(const std::filesystem::path& parent, const std::string& name);
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  ~ScratchFolder();

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace granuscope
