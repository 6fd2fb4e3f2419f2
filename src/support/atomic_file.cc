#include "support/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <system_error>
#include <utility>

#include "support/error.h"
#include "support/file_descriptor.h"
#include "support/read_chunks.h"
#include "support/scratch_name.h"
#include "support/system_reason.h"

namespace granuscope {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void fail(const fs::path& target, const std::string& reason) {
  throw EnvironmentError(fmt::format("cannot write '{}': {}", target.string(), reason));
}

[[noreturn]] void fail(const fs::path& target, int error_number) { fail(target, system_reason(error_number)); }

fs::path folder_of(const fs::path& file) { return file.has_parent_path() ? file.parent_path() : fs::path("."); }

/// Where the bytes really go: a link keeps pointing to the file it points to. Refuses what a rename would destroy.
fs::path resolve(fs::path target) {
  if (target.empty()) throw EnvironmentError("cannot write a file without a name: give a path");
  std::error_code ignored;
  if (fs::is_symlink(target, ignored) && fs::exists(target, ignored)) {
    // A link such as /dev/stdout may lead to what has no name.
    if (const fs::path real = fs::canonical(target, ignored); !real.empty()) target = real;
  }
  const fs::file_status status = fs::status(target, ignored);
  if (fs::is_directory(status) || !target.has_filename()) fail(target, EISDIR);
  // A device or pipe would be replaced by an ordinary file.
  if (fs::exists(status) && !fs::is_regular_file(status))
    fail(target, "It is not an ordinary file. Name another file.");
  return target;
}

/// Creates an empty file beside the target under a name nobody else uses.
fs::path create_beside(const fs::path& target) {
  remove_leftovers_of(target);
  for (;;) {
    fs::path candidate = folder_of(target) / scratch_name(target.filename().string());
    const FileDescriptor file(::open(candidate.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    if (file.valid()) return candidate;
    if (errno == EEXIST || errno == EINTR) continue;  // the remains of a killed process of the same number
    fail(target, errno);
  }
}

/// Closes with the status checked: some file systems tell of a full disk only now.
void close_checked(FileDescriptor& file, const fs::path& target) {
  // Linux frees the descriptor even when close is interrupted.
  if (::close(file.release()) != 0 && errno != EINTR) fail(target, errno);
}

void sync_checked(const FileDescriptor& file, const fs::path& target) {
  while (::fsync(file.get()) != 0) {
    if (errno != EINTR) fail(target, errno);
  }
}

}  // namespace

AtomicFile::AtomicFile(fs::path target) : target_(resolve(std::move(target))), temporary_(create_beside(target_)) {}

AtomicFile::~AtomicFile() {
  if (!committed_) ::unlink(temporary_.c_str());
}

void AtomicFile::commit() {
  rename_whole(temporary_, target_);
  committed_ = true;
}

void rename_whole(const fs::path& whole, const fs::path& target) {
  FileDescriptor file(::open(whole.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file.valid()) fail(target, errno);
  sync_checked(file, target);
  close_checked(file, target);

  if (::rename(whole.c_str(), target.c_str()) != 0) fail(target, errno);

  // The rename itself lives in the folder. Some file systems cannot sync a folder, and say EINVAL: then it is theirs.
  const FileDescriptor folder(::open(folder_of(target).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (folder.valid() && ::fsync(folder.get()) != 0 && errno != EINVAL && errno != EINTR) fail(target, errno);
}

void write_file(const fs::path& target, std::string_view bytes) {
  AtomicFile output(target);
  FileDescriptor file(::open(output.temporary_path().c_str(), O_WRONLY | O_CLOEXEC));
  if (!file.valid()) fail(target, errno);
  // A full disk shows as a short count first and as an error on the next attempt.
  while (!bytes.empty()) {
    const ssize_t written = ::write(file.get(), bytes.data(), bytes.size());
    if (written > 0) {
      bytes.remove_prefix(static_cast<std::size_t>(written));
    } else if (written == 0) {
      fail(target, EIO);
    } else if (errno != EINTR) {
      fail(target, errno);
    }
  }
  sync_checked(file, target);
  close_checked(file, target);
  output.commit();
}

void require_not_input(const fs::path& target, const std::vector<fs::path>& inputs) {
  std::error_code none;
  const fs::path real = fs::canonical(target, none);
  if (real.empty()) return;  // nothing is there that could be lost
  for (const fs::path& input : inputs) {
    if (input.empty()) continue;
    const fs::path read = fs::canonical(input, none);
    const bool lost =
        read == real || (fs::is_directory(read, none) && fs::exists(read / "manifest.json", none) &&
                         !real.lexically_relative(read).empty() && *real.lexically_relative(read).begin() != "..");
    if (!lost) continue;
    throw InputError(
        fmt::format("{} is read by this command or lies in the run that it reads, and would be lost; name "
                    "another file to write",
                    target.string()));
  }
}

void require_replaceable(const fs::path& target, std::string_view begins) {
  constexpr std::size_t told_apart = 30;  // bytes in which the beginnings of different texts differ
  constexpr std::array<std::string_view, 6> marks = {"granuscope pile",    "granuscope ensemble",
                                                     "granuscope 0.",      "granuscope figure ",
                                                     "granuscope render ", "ro-crate-metadata.json"};
  constexpr std::array<std::string_view, 7> formats = {"%PDF", "\x89PNG", "\x89HDF",   "<?xml",
                                                       "<svg", "%!PS",    "PK\x03\x04"};
  constexpr std::size_t longest_mark = 32;
  std::error_code none;
  if (!fs::is_regular_file(target, none) || fs::file_size(target, none) == 0) return;
  std::string head, tail;
  bool marked = false;
  read_chunks(target, [&](std::string_view chunk) {
    if (head.size() < told_apart) head.append(chunk.substr(0, told_apart));
    tail.append(chunk);
    marked = marked || std::any_of(marks.begin(), marks.end(),
                                   [&](std::string_view mark) { return tail.find(mark) != std::string::npos; });
    tail.erase(0, tail.size() - std::min(tail.size(), longest_mark));  // a mark may lie across two chunks
  });
  const bool has_format = std::any_of(formats.begin(), formats.end(), [&](auto one) { return head.starts_with(one); });
  if (has_format ? marked : !begins.empty() && head.starts_with(begins.substr(0, told_apart))) return;
  throw InputError(
      fmt::format("{} is there already, and granuscope has not written it, so that it would be lost; name "
                  "another file, or give --force to replace it",
                  target.string()));
}

std::string read_file(const fs::path& source) {
  std::string bytes;
  read_chunks(source, [&bytes](std::string_view chunk) { bytes.append(chunk); });
  return bytes;
}

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  // libstdc++ reports a file in the folder's place as ENOTDIR, and no error if the folder was there already.
  if (!error && !fs::is_directory(folder, error) && !error) error = std::make_error_code(std::errc::not_a_directory);
  if (!error) return;
  std::string reason = system_reason(error.value());
  if (error == std::errc::file_exists) {  // only a link that leads nowhere is there and yet no folder
    reason = "A link of that name, or one on its path, leads nowhere. Make what it leads to, or remove it.";
  }
  if (folder.empty()) reason = "It has no name. Name a folder.";
  throw EnvironmentError(fmt::format("cannot make the folder '{}': {}", folder.string(), reason));
}

void require_writable(const fs::path& target) { const AtomicFile probe(target); }

}  // namespace granuscope
