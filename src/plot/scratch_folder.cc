#include "plot/scratch_folder.h"

#include <fmt/format.h>
#include <stdlib.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "support/atomic_file.h"
#include "support/error.h"
#include "support/scratch_name.h"

namespace granuscope {

ScratchFolder::ScratchFolder(const std::filesystem::path& parent, const std::string& name) {
  make_folder(parent);
  std::string pattern = (parent / (scratch_name(name) + "-XXXXXX")).string();
  if (mkdtemp(pattern.data()) == nullptr) {
    throw EnvironmentError(fmt::format("cannot make a working folder in {}: {}; free space or choose another --out",
                                       parent.string(), std::strerror(errno)));
  }
  path_ = pattern;
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;  // a leftover hidden folder is harmless, a throwing destructor is not
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace granuscope
