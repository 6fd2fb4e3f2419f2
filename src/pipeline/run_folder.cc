#include "pipeline/run_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>

#include <cerrno>
#include <utility>

#include "support/atomic_file.h"
#include "support/error.h"
#include "support/scratch_name.h"

namespace granuscope {

RunFolder::RunFolder(std::filesystem::path folder, FolderUse use) : path_(std::move(folder)) {
  make_folder(path_);
  // The folder itself is locked, so that no file is left behind; the system drops the lock with the process, however it
  // ends. Some network folders know no locks: there nothing holds two runs apart.
  lock_ = FileDescriptor(::open(path_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (lock_.valid() && ::flock(lock_.get(), (use == FolderUse::shared ? LOCK_SH : LOCK_EX) | LOCK_NB) != 0 &&
      errno == EWOULDBLOCK) {
    throw BusyError(
        fmt::format("another run{} is working in '{}', and both would write the same files; wait for its end or choose "
                    "another folder",
                    use == FolderUse::shared ? "" : " or shard", path_.string()));
  }
  if (use != FolderUse::alone) return;
  for (const char* part : {"", "ensembles", "piles", "figures"}) leftovers_removed_ += remove_leftovers(path_ / part);
}

}  // namespace granuscope
