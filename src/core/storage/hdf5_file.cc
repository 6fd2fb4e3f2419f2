#include "storage/hdf5_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <hdf5.h>
#include <poll.h>
#include <signal.h>  // NOLINT(modernize-deprecated-headers): kill is POSIX, not in <csignal>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <new>
#include <stdexcept>
#include <type_traits>

#include "support/error.h"
#include "support/progress.h"

namespace granuscope {
namespace {

static_assert(std::is_same_v<hid_t, Hdf5Id>, "Hdf5Id must be what the library uses");
static_assert(std::is_same_v<herr_t, int>, "Hdf5Handle::Close must have the type of the library's close functions");

std::mutex library_mutex;

/// A file may ask for a filter that the library does not have, and HDF5_PLUGIN_PATH or a folder that others can write
/// to would give it: code that runs because a file was read. Ours need none.
void load_no_plugins() {
  if (H5PLset_loading_state(0) < 0) throw std::runtime_error("HDF5 would load plugins, and cannot be told not to");
}

}  // namespace

Hdf5Session::Hdf5Session() : lock_(library_mutex) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  static const bool once = (load_no_plugins(), true);
  (void)once;
}

std::string hdf5_reason() {
  std::string reason;
  const auto take_first = [](unsigned /*number*/, const H5E_error2_t* error, void* text) -> herr_t {
    if (error->desc != nullptr) *static_cast<std::string*>(text) = error->desc;
    return 1;  // the walk begins at the place that failed: one is enough
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take_first, &reason);
  return reason;
}

namespace {

/// Subscripts of a number in row-major order: "[12, 3]".
std::string position(std::size_t index, const std::vector<std::uint64_t>& shape) {
  std::vector<std::uint64_t> subscripts(shape.size());
  for (std::size_t axis = shape.size(); axis-- > 0;) {
    subscripts[axis] = index % shape[axis];
    index /= shape[axis];
  }
  return fmt::format("[{}]", fmt::join(subscripts, ", "));
}

}  // namespace

std::optional<std::string> find_not_finite(const std::string& dataset, const std::vector<std::uint64_t>& shape,
                                           std::size_t first, std::span<const double> values) {
  // No branch for each value, so that the compiler takes several at once.
  constexpr std::uint64_t exponent = 0x7ff0000000000000;
  constexpr auto too_large = std::bit_cast<std::uint64_t>(beyond_sums);
  bool found = false;
  for (const double value : values) found |= (std::bit_cast<std::uint64_t>(value) & exponent) >= too_large;
  if (!found) return std::nullopt;
  const auto wrong = std::ranges::find_if_not(values, [](double value) { return std::abs(value) < beyond_sums; });
  return fmt::format("'{}' at {} is {}, of which no sum is a number", dataset,
                     position(first + static_cast<std::size_t>(wrong - values.begin()), shape),
                     std::isnan(*wrong)   ? "nan"
                     : std::isinf(*wrong) ? "infinite"
                                          : fmt::format("{}", *wrong));
}

RawDataFile::RawDataFile(std::filesystem::path source, std::string kind)
    : source_(std::move(source)), kind_(std::move(kind)), file_(::open(source_.c_str(), O_RDONLY | O_CLOEXEC)) {
  if (!file_.valid()) fail(system_reason(errno));
}

void RawDataFile::fail(const std::string& reason) const {
  throw InputError("cannot read '{}' as {}: {}", source_.string(), kind_, reason);
}

void RawDataFile::read(const RawData& numbers, std::size_t first, std::span<double> target) const {
  if (!numbers.offset) {
    const auto from = numbers.values.begin() + static_cast<std::ptrdiff_t>(first);
    std::copy(from, from + static_cast<std::ptrdiff_t>(target.size()), target.begin());
  } else {
    auto* bytes = reinterpret_cast<char*>(target.data());
    std::size_t left = target.size_bytes();
    auto at = static_cast<off_t>(*numbers.offset + first * sizeof(double));
    while (left > 0) {
      const ssize_t got = ::pread(file_.get(), bytes, left, at);
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) fail(system_reason(errno));
      if (got == 0) {
        fail(
            fmt::format("its dataset '{}' is cut short, or the file changed while it was read. Make the file again or "
                        "name another one.",
                        numbers.dataset));
      }
      bytes += got;
      at += got;
      left -= static_cast<std::size_t>(got);
    }
  }
  if (const auto wrong = find_not_finite(numbers.dataset, numbers.shape, first, target)) {
    fail(fmt::format("{}. Make the file again or name another one.", *wrong));
  }
}

namespace {

constexpr std::size_t page_bytes = std::size_t{1} << 16;

/// An open file as the library sees it: its own part first.
struct OpenImage {
  H5FD_t base = {};
  SparseImage* image = nullptr;
  haddr_t end_of_allocation = 0;
};

OpenImage* from(H5FD_t* file) { return reinterpret_cast<OpenImage*>(file); }
const OpenImage* from(const H5FD_t* file) { return reinterpret_cast<const OpenImage*>(file); }

H5FD_t* open_image(const char* /*name*/, unsigned /*flags*/, hid_t access_list, haddr_t /*limit*/) {
  const auto* image = static_cast<SparseImage* const*>(H5Pget_driver_info(access_list));
  if (image == nullptr) return nullptr;
  auto opened = std::make_unique<OpenImage>();
  opened->image = *image;
  return reinterpret_cast<H5FD_t*>(opened.release());
}

herr_t close_image(H5FD_t* file) {
  delete from(file);
  return 0;
}

herr_t tell_features(const H5FD_t* /*file*/, unsigned long* features) {
  *features = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_AGGREGATE_SMALLDATA;
  return 0;
}

haddr_t end_of_allocation(const H5FD_t* file, H5FD_mem_t /*type*/) { return from(file)->end_of_allocation; }

herr_t set_end_of_allocation(H5FD_t* file, H5FD_mem_t /*type*/, haddr_t end) {
  from(file)->end_of_allocation = end;
  return 0;
}

haddr_t end_of_image(const H5FD_t* file, H5FD_mem_t /*type*/) { return from(file)->image->size(); }

// Exceptions must not pass through a library in C.
herr_t read_image(H5FD_t* file, H5FD_mem_t /*type*/, hid_t /*list*/, haddr_t at, size_t size, void* bytes) {
  from(file)->image->read(at, bytes, size);
  return 0;
}

herr_t write_image(H5FD_t* file, H5FD_mem_t /*type*/, hid_t /*list*/, haddr_t at, size_t size, const void* bytes) {
  try {
    from(file)->image->write(at, bytes, size);
  } catch (const std::exception&) {
    return -1;
  }
  return 0;
}

herr_t end_at_allocation(H5FD_t* file, hid_t /*list*/, hbool_t /*closing*/) {
  from(file)->image->resize(from(file)->end_of_allocation);
  return 0;
}

hid_t driver() {
  static const hid_t registered = [] {
    H5FD_class_t methods = {};
#if H5_VERSION_GE(1, 14, 0)
    // From 1.14 on the library refuses a driver that does not say which version of this interface it is made for. The
    // number is the first that is not for drivers of its own; no file holds it.
    methods.version = H5FD_CLASS_VERSION;
    methods.value = H5_VFD_RESERVED;
#endif
    methods.name = "granuscope sparse image";
    methods.maxaddr = HADDR_MAX;
    methods.fc_degree = H5F_CLOSE_WEAK;
    methods.fapl_size = sizeof(void*);  // the access list holds the address of an image
    methods.open = open_image;
    methods.close = close_image;
    methods.query = tell_features;
    methods.get_eoa = end_of_allocation;
    methods.set_eoa = set_end_of_allocation;
    methods.get_eof = end_of_image;
    methods.read = read_image;
    methods.write = write_image;
    methods.truncate = end_at_allocation;
    // The library keeps a pointer to this.
    static const H5FD_class_t kept = methods;
    return H5FDregister(&kept);
  }();
  return registered;
}

}  // namespace

void SparseImage::write(std::uint64_t at, const void* bytes, std::size_t size) {
  const auto* from_bytes = static_cast<const char*>(bytes);
  size_ = std::max(size_, at + size);
  while (size > 0) {
    std::vector<char>& page = pages_[at / page_bytes];
    if (page.empty()) page.resize(page_bytes);
    const std::size_t within = at % page_bytes, piece = std::min(size, page_bytes - within);
    std::copy_n(from_bytes, piece, page.begin() + static_cast<std::ptrdiff_t>(within));
    from_bytes += piece;
    at += piece;
    size -= piece;
  }
}

void SparseImage::read(std::uint64_t at, void* bytes, std::size_t size) const {
  auto* to = static_cast<char*>(bytes);
  while (size > 0) {
    const std::size_t within = at % page_bytes, piece = std::min(size, page_bytes - within);
    const auto page = pages_.find(at / page_bytes);
    if (page == pages_.end()) {
      std::fill_n(to, piece, '\0');
    } else {
      std::copy_n(page->second.begin() + static_cast<std::ptrdiff_t>(within), piece, to);
    }
    to += piece;
    at += piece;
    size -= piece;
  }
}

void SparseImage::for_each_page(const std::function<void(std::uint64_t at, std::span<const char> bytes)>& visit) const {
  for (const auto& [number, page] : pages_) {
    const std::uint64_t at = number * page_bytes;
    if (at >= size_) break;
    visit(at, std::span(page).first(std::min<std::uint64_t>(page.size(), size_ - at)));
  }
}

int set_sparse_driver(Hdf5Id access_list, SparseImage* image) {
  return H5Pset_driver(access_list, driver(), static_cast<const void*>(&image));
}

namespace {

using Clock = std::chrono::steady_clock;

/// The slowest reading worth waiting for: a compressed file on a slow disk.
constexpr double slowest_bytes_per_second = 5e6;
/// How often the wait looks for a request to stop.
constexpr int poll_milliseconds = 50;
/// The answer's first letter says what follows it.
enum class Answer : char { bytes = 'b', input_error = 'i', environment_error = 'e', out_of_memory = 'm', fault = 'f' };

void send(int pipe, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = ::write(pipe, bytes.data(), bytes.size());
    if (sent > 0) bytes.remove_prefix(static_cast<std::size_t>(sent));
    if (sent < 0 && errno != EINTR) ::_exit(1);
  }
}

void answer(int pipe, Answer kind, std::string_view text) {
  const char letter = static_cast<char>(kind);
  send(pipe, {&letter, 1});
  send(pipe, text);
}

/// What the child does instead of the caller's work: it keeps nothing of the caller open, prints nothing, and ends with
/// it at the latest.
[[noreturn]] void serve(int pipe, pid_t parent, const std::function<std::string()>& read, double processor_seconds) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(1);  // it ended before the line above
  // A request to stop is for the parent, which then ends this process.
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) ::signal(signal, SIG_IGN);
  // The library's last words, and a sanitizer's, are about the file.
  const int nowhere = ::open("/dev/null", O_RDWR);
  for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (standard != pipe) ::dup2(nowhere, standard);
  }
  if (pipe > STDERR_FILENO + 1) ::close_range(STDERR_FILENO + 1, static_cast<unsigned>(pipe - 1), 0);
  ::close_range(static_cast<unsigned>(pipe + 1), ~0U, 0);
  const auto seconds = static_cast<rlim_t>(std::ceil(processor_seconds));
  const rlimit time = {seconds, seconds + 1};
  ::setrlimit(RLIMIT_CPU, &time);
  const rlimit no_core = {0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
  try {
    answer(pipe, Answer::bytes, read());
  } catch (const InputError& error) {
    answer(pipe, Answer::input_error, error.what());
  } catch (const EnvironmentError& error) {
    answer(pipe, Answer::environment_error, error.what());
  } catch (const std::bad_alloc&) {
    answer(pipe, Answer::out_of_memory, "");
  } catch (const std::exception& error) {
    answer(pipe, Answer::fault, error.what());
  }
  ::_exit(0);  // without any cleaning up: all of it belongs to the parent
}

/// A child that never outlives this object.
class Reader {
 public:
  explicit Reader(pid_t pid) : pid_(pid) {}
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
  ~Reader() {
    if (pid_ < 0) return;
    ::kill(pid_, SIGKILL);
    wait();
  }
  /// Its exit status as waitpid gives it.
  int wait() {
    int status = 0;
    while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
    }
    pid_ = -1;
    return status;
  }

 private:
  pid_t pid_;
};

[[noreturn]] void give_up(const std::filesystem::path& source, const std::string& kind, const std::string& what) {
  throw InputError(
      "cannot read '{}' as {}: the HDF5 library {}, so the file is damaged, or made to do so. Make the file again or "
      "name another one.",
      source.string(), kind, what);
}

}  // namespace

std::string read_in_child(const std::filesystem::path& source, const std::string& kind,
                          const std::function<std::string()>& read, ReadPatience patience) {
  if (is_open_already(source))
    throw InputError("cannot read '{}' as {}: HDF5 cannot move about in a pipe. Name a file.", source.string(), kind);
  std::error_code unknown;
  const std::uintmax_t size = std::filesystem::file_size(source, unknown);
  if (!unknown) {
    patience.processor_seconds += static_cast<double>(size) / slowest_bytes_per_second;
    patience.wall_seconds += static_cast<double>(size) / slowest_bytes_per_second;
  }

  const auto no_child = [&](int error_number) {
    throw EnvironmentError("cannot read '{}': a process for it cannot be started: {}", source.string(),
                           system_reason(error_number));
  };
  std::array<int, 2> ends = {};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) no_child(errno);
  FileDescriptor from_child(ends[0]);
  FileDescriptor to_parent(ends[1]);
  const pid_t parent = ::getpid();
  pid_t pid = -1;
  int error_number = 0;
  {
    // The child inherits the library as it is at this moment: no other thread may be inside it.
    const Hdf5Session session;
    pid = ::fork();
    error_number = errno;
  }
  if (pid < 0) no_child(error_number);
  if (pid == 0) serve(to_parent.get(), parent, read, patience.processor_seconds);
  Reader child(pid);
  to_parent.reset();

  const Clock::time_point start = Clock::now();
  std::string received;
  std::array<char, 1 << 16> chunk;  // NOLINT(cppcoreguidelines-pro-type-member-init): filled by read
  for (;;) {
    if (interruption_requested()) throw_if_interrupted();
    if (std::chrono::duration<double>(Clock::now() - start).count() > patience.wall_seconds) {
      give_up(source, kind, fmt::format("did not come to an end within {:.0f} s", patience.wall_seconds));
    }
    pollfd wait = {from_child.get(), POLLIN, 0};
    if (::poll(&wait, 1, poll_milliseconds) <= 0) continue;
    const ssize_t got = ::read(from_child.get(), chunk.data(), chunk.size());
    if (got > 0) received.append(chunk.data(), static_cast<std::size_t>(got));
    if (got == 0) break;
  }
  const int status = child.wait();
  if (WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL)) {
    give_up(source, kind, "did not come to an end, or took all memory");
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0 || received.empty()) give_up(source, kind, "crashed on it");

  const auto letter = static_cast<Answer>(received.front());
  received.erase(0, 1);
  switch (letter) {
    case Answer::bytes:
      return received;
    case Answer::input_error:
      throw InputError(received);
    case Answer::environment_error:
      throw EnvironmentError(received);
    case Answer::out_of_memory:
      throw std::bad_alloc();
    case Answer::fault:
      break;
  }
  throw std::runtime_error(received);
}

}  // namespace granuscope
