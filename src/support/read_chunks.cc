#include "support/read_chunks.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <vector>

#include "support/error.h"
#include "support/file_descriptor.h"
#include "support/system_reason.h"

namespace granuscope {
namespace {

constexpr std::size_t chunk_bytes = std::size_t{1} << 18;

[[noreturn]] void fail(const std::filesystem::path& source, const std::string& reason) {
  throw InputError(fmt::format("cannot read '{}': {}", source.string(), reason));
}

[[noreturn]] void fail(const std::filesystem::path& source, int error_number) {
  fail(source, system_reason(error_number));
}

}  // namespace

void read_chunks(const std::filesystem::path& source, const std::function<void(std::string_view)>& take) {
  // Opening a pipe would wait for a writer, who may never come.
  const FileDescriptor file(::open(source.c_str(), O_RDONLY | O_CLOEXEC | O_NOCTTY | O_NONBLOCK));
  if (!file.valid()) fail(source, errno);
  struct stat status = {};
  if (::fstat(file.get(), &status) != 0) fail(source, errno);
  if (S_ISDIR(status.st_mode)) fail(source, EISDIR);
  if (!S_ISREG(status.st_mode)) fail(source, "It is not an ordinary file. Name another file.");

  std::vector<char> chunk(chunk_bytes);
  for (;;) {
    const ssize_t got = ::read(file.get(), chunk.data(), chunk.size());
    if (got > 0) {
      take(std::string_view(chunk.data(), static_cast<std::size_t>(got)));
    } else if (got == 0) {
      return;
    } else if (errno != EINTR) {
      fail(source, errno);
    }
  }
}

}  // namespace granuscope
