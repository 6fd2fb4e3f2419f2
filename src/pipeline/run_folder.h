#pragma once
#include <filesystem>
#include <string>

#include "support/file_descriptor.h"

namespace granuscope {

/// Whether a process has a folder for itself, or shares it with others that share it: the shards of a run. Or only
/// reads what must not change meanwhile.
enum class FolderUse { alone, shared, read };

/// The folder of a run, for this run alone, or for its shards, as long as this object lives.
class RunFolder {
 public:
  /// Makes the folder if it is missing and removes what killed runs left half done (unless others may be at work).
  /// Throws EnvironmentError if it cannot be made, BusyError if another run is working in it: both would write the same
  /// files.
  explicit RunFolder(std::filesystem::path folder, FolderUse use = FolderUse::alone);

  const std::filesystem::path& path() const { return path_; }
  int leftovers_removed() const { return leftovers_removed_; }

 private:
  std::filesystem::path path_;
  FileDescriptor lock_;
  int leftovers_removed_ = 0;
};

}  // namespace granuscope
