#include "support/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <openssl/evp.h>
#include <signal.h>  // NOLINT(modernize-deprecated-headers): kill is POSIX
#include <sys/file.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <fstream>
#include <limits>
#include <memory>
#include <stdexcept>
#include <system_error>
#include <thread>

#include "support/error.h"
#include "support/plain_text.h"
#include "support/progress.h"

namespace granuscope {
bool path_exists(const fs::path& path) {
  std::error_code none;
  return fs::exists(path, none);
}

bool file_exists(const fs::path& path) {
  std::error_code none;
  return fs::is_regular_file(path, none);
}

bool folder_exists(const fs::path& path) {
  std::error_code none;
  return fs::is_directory(path, none);
}

bool remove_if_there(const fs::path& path) {
  std::error_code none;
  return fs::remove(path, none);
}

std::vector<fs::path> entries_of(const fs::path& folder) {
  std::vector<fs::path> found;
  std::error_code none;
  for (auto at = fs::directory_iterator(folder, none); !none && at != fs::directory_iterator(); at.increment(none)) {
    found.push_back(at->path());
  }
  return found;
}

namespace {

[[noreturn]] void fail(const fs::path& target, const std::string& reason) {
  throw EnvironmentError("cannot write '{}': {}", target.string(), reason);
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
    if (errno == EINVAL || errno == EROFS) return;  // a file system that cannot, as some in user space: it is theirs
    if (errno != EINTR) fail(target, errno);
  }
}

}  // namespace

bool lock_file(const FileDescriptor& file, bool shared) {
  constexpr int times = 25;
  for (int attempt = 0; file.valid() && ::flock(file.get(), (shared ? LOCK_SH : LOCK_EX) | LOCK_NB) != 0; ++attempt) {
    if (errno != EWOULDBLOCK) return true;
    if (attempt == times) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return true;
}

AtomicFile::AtomicFile(fs::path target) : target_(resolve(std::move(target))), temporary_(create_beside(target_)) {}

AtomicFile::~AtomicFile() {
  if (!committed_) ::unlink(temporary_.c_str());
}

void AtomicFile::commit(const fs::path& like) {
  rename_whole(temporary_, target_, like);
  committed_ = true;
}

void rename_whole(const fs::path& whole, const fs::path& target, const fs::path& like) {
  FileDescriptor file(::open(whole.c_str(), O_RDONLY | O_CLOEXEC));
  if (!file.valid()) fail(target, errno);
  sync_checked(file, target);
  close_checked(file, target);
  // Who has closed a file to others keeps it so.
  constexpr mode_t permissions = 0777;
  for (const fs::path& before : {target, like}) {
    struct stat status = {};
    if (::lstat(before.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) continue;
    (void)::chmod(whole.c_str(), status.st_mode & permissions);
    break;
  }

  if (::rename(whole.c_str(), target.c_str()) != 0) fail(target, errno);

  // The rename itself lives in the folder. Some file systems cannot sync a folder, and say EINVAL: then it is theirs.
  const FileDescriptor folder(::open(folder_of(target).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (folder.valid() && ::fsync(folder.get()) != 0 && errno != EINVAL && errno != EINTR) fail(target, errno);
}

StreamedFile::StreamedFile(fs::path target)
    : target_(std::move(target)),
      output_(target_),
      file_(::open(output_.temporary_path().c_str(), O_WRONLY | O_CLOEXEC)) {
  if (!file_.valid()) fail(target_, errno);
}

void StreamedFile::append(std::string_view bytes) {
  put(end_, bytes);
  end_ += bytes.size();
}

void StreamedFile::put(std::uint64_t at, std::string_view bytes) {
  // A full disk shows as a short count first and as an error on the next attempt.
  while (!bytes.empty()) {
    const ssize_t written = ::pwrite(file_.get(), bytes.data(), bytes.size(), static_cast<off_t>(at));
    if (written > 0) {
      bytes.remove_prefix(static_cast<std::size_t>(written));
      at += static_cast<std::uint64_t>(written);
    } else if (written == 0) {
      fail(target_, EIO);
    } else if (errno != EINTR) {
      fail(target_, errno);
    }
  }
}

void StreamedFile::commit(const fs::path& like) {
  sync_checked(file_, target_);
  close_checked(file_, target_);
  output_.commit(like);
}

void write_file(const fs::path& target, std::string_view bytes, const fs::path& like) {
  StreamedFile output(target);
  output.append(bytes);
  output.commit(like);
}

void require_room(const fs::path& folder) {
  constexpr std::size_t bytes = 1 << 16;
  const fs::path probe = folder / scratch_name("room");
  write_file(probe, std::string(bytes, 'x'));
  remove_if_there(probe);
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
        "{} is read by this command or lies in the run that it reads, and would be lost; name another file to write",
        target.string());
  }
}

void require_replaceable(const fs::path& target, std::string_view begins) {
  constexpr std::size_t told_apart = 30;  // bytes in which the beginnings of different texts differ
  // A dump has no room for a name: the last columns of those that this program writes stand for it.
  // An ensemble, hours of work, is not among them.
  const std::vector<std::string> marks = parts_between(
      "granuscope pile|granuscope 0.|granuscope figure|granuscope render|ro-crate-metadata.json|"
      "id1 id2 periodic fx fy fz|mesh triangle id1 fx fy fz|radius weight residual",
      "|");
  constexpr std::array<std::string_view, 8> formats = {"%PDF", "\x89PNG", "\x89HDF",    "<?xml",
                                                       "<svg", "%!PS",    "PK\x03\x04", "ITEM: TIMESTEP"};
  constexpr std::size_t longest_mark = 32;
  std::error_code none;
  if (!fs::is_regular_file(target, none) || fs::file_size(target, none) == 0) return;
  std::string head, tail;
  bool marked = false;
  read_chunks(target, [&](std::string_view chunk) {
    if (head.size() < told_apart) head.append(chunk.substr(0, told_apart));
    tail.append(chunk);
    marked = marked ||
             std::ranges::any_of(marks, [&](std::string_view mark) { return tail.find(mark) != std::string::npos; });
    tail.erase(0, tail.size() - std::min(tail.size(), longest_mark));  // a mark may lie across two chunks
  });
  const bool has_format = std::ranges::any_of(formats, [&](auto one) { return head.starts_with(one); });
  const fs::path real = fs::canonical(target, none);
  for (fs::path run = real.parent_path(); run.has_relative_path(); run = run.parent_path()) {
    if (!fs::is_regular_file(run / "manifest.json", none)) continue;
    const std::string entry = fmt::format("\"path\": \"{}\"", real.lexically_relative(run).generic_string());
    if (read_file(run / "manifest.json").find(entry) == std::string::npos) break;
    throw InputError("{} is there already, and belongs to the run in {}, which would lose it; name another file",
                     target.string(), run.string());
  }
  if (has_format ? marked : !begins.empty() && head.starts_with(begins.substr(0, told_apart))) return;
  throw InputError(
      "{} is there already, and {}, so that it would be lost; name another file, or give --force to replace it",
      target.string(), head.starts_with("\x89HDF") ? "is no pile of this program" : "granuscope has not written it");
}

std::string read_file(const fs::path& source, std::uint64_t most) {
  const auto require_size = [&](std::uint64_t size) {
    if (size <= most) return;
    throw InputError(
        "{}: {} bytes or more are too many for a file of its kind (the limit is {}); is this the right file?",
        source.string(), size, most);
  };
  std::string bytes;
  std::error_code unknown;
  if (const auto size = fs::file_size(source, unknown); !unknown) {
    require_size(size);
    bytes.reserve(size);
  }
  read_chunks(source, [&](std::string_view chunk) { require_size(bytes.append(chunk).size()); });
  return bytes;
}

std::string read_json(const fs::path& source) { return shallow_json(read_file(source), source.string()); }

bool is_open_already(const fs::path& file) {
  const std::string name = file.string();
  return (name == "/dev/stdin" || name.starts_with("/dev/fd/") || name.starts_with("/proc/self/fd/")) &&
         !file_exists(file) && !folder_exists(file);
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
  throw EnvironmentError("cannot make the folder '{}': {}", folder.string(), reason);
}

void require_writable(const fs::path& target) { const AtomicFile probe(target); }

namespace {

constexpr std::size_t chunk_bytes = std::size_t{1} << 18;

[[noreturn]] void cannot_read(const fs::path& source, const std::string& reason) {
  throw InputError("cannot read '{}': {}", source.string(), reason);
}

[[noreturn]] void cannot_read(const fs::path& source, int error_number) {
  cannot_read(source, system_reason(error_number));
}

}  // namespace

void require_visible(const fs::path& source) {
  struct stat status = {};
  if (::stat(source.c_str(), &status) != 0 && (errno == EACCES || errno == EPERM)) cannot_read(source, errno);
}

void read_chunks(const fs::path& source, const std::function<void(std::string_view)>& take) {
  // Opening a pipe would wait for a writer, who may never come.
  const bool waits = is_open_already(source);
  const FileDescriptor file(::open(source.c_str(), O_RDONLY | O_CLOEXEC | O_NOCTTY | (waits ? 0 : O_NONBLOCK)));
  if (!file.valid()) cannot_read(source, errno);
  struct stat status = {};
  if (::fstat(file.get(), &status) != 0) cannot_read(source, errno);
  if (S_ISDIR(status.st_mode)) cannot_read(source, EISDIR);
  if (!S_ISREG(status.st_mode) && !waits) cannot_read(source, "It is not an ordinary file. Name another file.");

  std::vector<char> chunk(chunk_bytes);
  for (;;) {
    const ssize_t got = ::read(file.get(), chunk.data(), chunk.size());
    if (got > 0) {
      take(std::string_view(chunk.data(), static_cast<std::size_t>(got)));
    } else if (got == 0) {
      return;
    } else if (errno != EINTR) {
      cannot_read(source, errno);
    } else {
      throw_if_interrupted();
    }
  }
}

namespace {

constexpr std::size_t kept_letters = 100;
constexpr unsigned long largest_process = std::numeric_limits<pid_t>::max();

/// Numbers of processes mean something within one namespace only: a container may share folder and machine name with
/// others, and would take their running processes for ended ones. 0 where the system does not tell.
unsigned long process_namespace() {
  struct stat status = {};
  return ::stat("/proc/self/ns/pid", &status) == 0 ? static_cast<unsigned long>(status.st_ino) : 0;
}

/// ".granuscope-<machine>-<namespace>-": what all such names begin with where numbers of processes mean the same.
const std::string& prefix() {
  static const std::string text = [] {
    std::array<char, 256> name = {};
    if (::gethostname(name.data(), name.size() - 1) != 0) name.front() = '\0';
    std::string machine = std::string(name.data()).substr(0, 64);
    for (char& c : machine) {
      if (c == '/') c = '_';
    }
    return fmt::format(".granuscope-{}-{:x}-", machine, process_namespace());
  }();
  return text;
}

/// A process that has ended keeps its number until its parent takes note, which may be never.
bool has_ended(pid_t process) {
  std::ifstream file(fmt::format("/proc/{}/stat", process));
  std::string line;
  std::getline(file, line);
  const std::size_t name_end = line.rfind(')');  // "17 (name) Z 1 ...": the name may hold anything
  return name_end != std::string::npos && name_end + 2 < line.size() &&
         (line[name_end + 2] == 'Z' || line[name_end + 2] == 'X');
}

bool is_running(pid_t process) { return (::kill(process, 0) == 0 || errno == EPERM) && !has_ended(process); }

/// Takes "17-" off the front of `text`; 0 if it does not begin so.
unsigned long take_number(std::string_view& text) {
  unsigned long number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end == text.data() + text.size() || *end != '-') return 0;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()) + 1);
  return number;
}

/// Whether this is the name of something that nobody works on any more.
bool is_leftover(std::string_view name) {
  if (!name.starts_with(prefix())) return false;
  name.remove_prefix(prefix().size());
  const unsigned long process = take_number(name);
  return process > 0 && process <= largest_process && !is_running(static_cast<pid_t>(process));
}

std::string last_letters(const std::string& name) {
  return name.size() > kept_letters ? name.substr(name.size() - kept_letters) : name;
}

/// Removes from the folder what has a name that `wanted` accepts; how many there were.
template <class Wanted>
int remove_named(const fs::path& folder, const Wanted& wanted) {
  int removed = 0;
  for (const fs::path& path : entries_of(folder)) {
    if (!wanted(path.filename().string())) continue;
    std::error_code failed;
    fs::remove_all(path, failed);
    if (!failed) ++removed;
  }
  return removed;
}

}  // namespace

std::string scratch_name(const std::string& name) {
  static std::atomic<unsigned long> counter{1};
  return fmt::format("{}{}-{}-{}", prefix(), ::getpid(), counter.fetch_add(1), last_letters(name));
}

int remove_leftovers(const fs::path& folder) {
  return remove_named(folder, [](std::string_view name) { return is_leftover(name); });
}

int remove_leftovers_of(const fs::path& file) {
  const std::string tail = last_letters(file.filename().string());
  return remove_named(file.has_parent_path() ? file.parent_path() : fs::path("."), [&tail](std::string_view name) {
    if (!name.ends_with(tail) || !is_leftover(name)) return false;
    name.remove_prefix(prefix().size());
    return take_number(name) > 0 && take_number(name) > 0 && name == tail;  // behind process and count
  });
}

namespace {

class Sha256 {
 public:
  Sha256() : context_(EVP_MD_CTX_new(), EVP_MD_CTX_free) {
    check(context_ != nullptr && EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) == 1);
  }
  void add(std::string_view bytes) { check(EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()) == 1); }
  std::string hexadecimal() {
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest = {};
    unsigned size = 0;
    check(EVP_DigestFinal_ex(context_.get(), digest.data(), &size) == 1);
    std::string text;
    for (unsigned i = 0; i < size; ++i) text += fmt::format("{:02x}", digest[i]);
    return text;
  }

 private:
  static void check(bool good) {
    if (!good)
      throw EnvironmentError(
          "OpenSSL cannot compute SHA-256 here: check OPENSSL_CONF and openssl.cnf, whose provider may not be "
          "installed, then the installation of libssl");
  }

  std::unique_ptr<EVP_MD_CTX, void (*)(EVP_MD_CTX*)> context_;
};

}  // namespace

std::string sha256(std::string_view bytes) {
  Sha256 hash;
  hash.add(bytes);
  return hash.hexadecimal();
}

std::string sha256_of_file(const fs::path& file) {
  Sha256 hash;
  read_chunks(file, [&hash](std::string_view chunk) { hash.add(chunk); });
  return hash.hexadecimal();
}

std::string base64(std::string_view bytes) {
  if (bytes.size() > std::numeric_limits<int>::max() / 2) throw std::length_error("too long for OpenSSL's base64");
  std::string text((bytes.size() + 2) / 3 * 4 + 1, '\0');  // OpenSSL writes a final zero
  EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()), reinterpret_cast<const unsigned char*>(bytes.data()),
                  static_cast<int>(bytes.size()));
  text.pop_back();
  return text;
}

std::string cache_key(std::string_view bytes) { return sha256(bytes).substr(0, 16); }

}  // namespace granuscope
