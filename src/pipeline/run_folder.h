#pragma once
#include <filesystem>
#include <string>

#include "support/file_descriptor.h"

namespace granuscope {

/// The folder of a run, for this run alone as long as this object lives.
class RunFolder {
 public:
  /// Makes the folder if it is missing and removes what killed runs left half done. Throws EnvironmentError if it
  /// cannot be made, or if another run is working in it: both would write the same files.
  explicit RunFolder(std::filesystem::path folder);

  const std::filesystem::path& path() const { return path_; }
  int leftovers_removed() const { return leftovers_removed_; }

 private:
  std::filesystem::path path_;
  FileDescriptor lock_;
  int leftovers_removed_ = 0;
};

}  // namespace granuscope
