#pragma once
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace granuscope {
namespace fs = std::filesystem;

/// Looks at a path, and its removal, that hinder nobody: what cannot be looked at is not there.
bool path_exists(const fs::path& path);
bool file_exists(const fs::path& path);  ///< an ordinary one, or a link to it
bool folder_exists(const fs::path& path);
bool remove_if_there(const fs::path& path);
/// What lies in a folder, in no order; nothing where it cannot be read.
std::vector<fs::path> entries_of(const fs::path& folder);

/// Owns a POSIX file descriptor; -1 is none.
class FileDescriptor {
 public:
  FileDescriptor() = default;
  explicit FileDescriptor(int number) : number_(number) {}
  FileDescriptor(FileDescriptor&& other) noexcept : number_(other.release()) {}
  FileDescriptor& operator=(FileDescriptor&& other) noexcept {
    if (this != &other) {
      reset();
      number_ = other.release();
    }
    return *this;
  }
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  ~FileDescriptor() { reset(); }

  int get() const { return number_; }
  bool valid() const { return number_ >= 0; }
  int release() { return std::exchange(number_, -1); }
  void reset() {
    if (number_ >= 0) ::close(release());
  }

 private:
  int number_ = -1;
};

/// Locks a file or folder for as long as it is open, for this process alone or with others that share it (flock). False
/// if another process has it; asks for a quarter of a second, since the lock of a process that was killed may outlive
/// it by a moment. Where locks are unknown it is as if nobody had one.
bool lock_file(const FileDescriptor& file, bool shared);

/// A file that appears whole or not at all: written beside its target, fsynced, then renamed onto it.
/// The temporary file is removed if commit() is never reached; where a kill prevents that, the next one of the same
/// target removes it. Errors are EnvironmentError naming the target.
class AtomicFile {
 public:
  explicit AtomicFile(fs::path target);
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  ~AtomicFile();

  /// Where to write (any library may open it by name). Same folder as the target, so that the rename is atomic.
  const fs::path& temporary_path() const { return temporary_; }
  /// Flushes the temporary file to disk and renames it onto the target (rename_whole).
  void commit(const fs::path& like = {});

 private:
  fs::path target_;
  fs::path temporary_;
  bool committed_ = false;
};

/// Flushes a file that is whole to disk and renames it onto the target, which is in the same file system, and whose
/// permissions it takes over, or else those of `like`.
void rename_whole(const fs::path& whole, const fs::path& target, const fs::path& like = {});

/// Such a file, filled piece by piece in any order, so that no file need fit in memory.
class StreamedFile {
 public:
  explicit StreamedFile(fs::path target);
  /// Behind what has been appended so far.
  void append(std::string_view bytes);
  /// At a place, which append() does not look at.
  void put(std::uint64_t at, std::string_view bytes);
  /// The last call.
  void commit(const fs::path& like = {});

 private:
  fs::path target_;
  AtomicFile output_;
  FileDescriptor file_;
  std::uint64_t end_ = 0;
};

/// RFC 4648, with padding.
std::string base64(std::string_view bytes);

/// Writes `bytes` to `target` atomically, with the permissions that it has or, where it is new, those of `like` if that
/// is a file. Throws EnvironmentError (disk full, no permission, no such folder).
void write_file(const fs::path& target, std::string_view bytes, const fs::path& like = {});

/// Throws as write_file does where a folder, whose files another program has failed to write, cannot hold one more of
/// 64 kB: its disk is full.
void require_room(const fs::path& folder);

/// Throws InputError, with the reason, if nobody lets this process look at what lies there; whether it is there at all
/// is not asked.
void require_visible(const fs::path& source);

/// Throws as write_file would, but writes nothing: to be asked before the work that fills the file, not after.
void require_writable(const fs::path& target);

/// Throws InputError if `target` is one of the files that the same call reads, or a file that is there already in one
/// of the folders of runs that it reads: writing it would lose what the run has left.
void require_not_input(const fs::path& target, const std::vector<fs::path>& inputs);

/// Throws InputError if something is at `target` that this program has not written: a text has to begin as the one does
/// that would take its place (`begins`), a picture, an archive or an HDF5 file has to hold the program's mark.
void require_replaceable(const fs::path& target, std::string_view begins = {});

/// The whole file. Throws InputError if it cannot be read, or has more than so many bytes: what comes from elsewhere
/// may have no end.
std::string read_file(const fs::path& source, std::uint64_t most = 1'000'000'000);

/// The same of a file of JSON, by shallow_json (plain_text.h).
std::string read_json(const fs::path& source);

/// Whether this names what a shell has opened already, a pipe say: /dev/stdin or /dev/fd/63, as of `<(command)`.
bool is_open_already(const fs::path& file);

/// Makes the folder and its parents. Throws EnvironmentError naming the folder and the system's reason.
void make_folder(const fs::path& folder);

/// Hands the bytes of a file to `take`, piece by piece, so that no file need fit in memory. Throws InputError naming
/// the file if it is missing, unreadable or no ordinary file, but a folder, say, or a pipe that is not open already.
void read_chunks(const fs::path& source, const std::function<void(std::string_view)>& take);

/// Name for work in progress beside a file called `name`: hidden, with its last letters (programs look at the suffix),
/// short enough for any file system, and telling which process on which machine made it. Different at each call.
std::string scratch_name(const std::string& name);

/// Removes from a folder what such processes left there when they were killed, files and folders, and returns how many
/// there were. What belongs to a process still running, or to another machine or container, stays. A folder that is not
/// there, or cannot be changed, is left alone.
int remove_leftovers(const fs::path& folder);

/// The same, but only what was to become `file`.
int remove_leftovers_of(const fs::path& file);

/// SHA-256 as 64 lower-case hexadecimal digits.
std::string sha256(std::string_view bytes);
std::string sha256_of_file(const fs::path& file);

/// The first 16 of these digits: a key for caches.
std::string cache_key(std::string_view bytes);

}  // namespace granuscope
