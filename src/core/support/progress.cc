#include "support/progress.h"

#include <fmt/format.h>
#include <signal.h>  // NOLINT(modernize-deprecated-headers): sigaction is POSIX, not in <csignal>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <exception>

#include "support/error.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

constexpr std::int64_t terminal_interval = 200;  // milliseconds: smooth to the eye, nothing to the clock
constexpr std::int64_t plain_interval = 10'000;

ProgressStyle resolve(ProgressStyle style) {
  if (style != ProgressStyle::automatic) return style;
  const char* terminal = std::getenv("TERM");  // NOLINT(concurrency-mt-unsafe): nothing here calls setenv
  const bool can_rewrite = terminal == nullptr || std::strcmp(terminal, "dumb") != 0;
  return ::isatty(STDERR_FILENO) == 1 && can_rewrite ? ProgressStyle::terminal : ProgressStyle::plain;
}

/// Standard error with at most one line that is being rewritten. One for the process: lines of several threads neither
/// mix nor land behind a running line.
class Console {
 public:
  void rewrite(std::string line) {
    const std::lock_guard<std::mutex> lock(mutex_);
    winsize size = {};
    // A line that wraps could not be erased with a carriage return.
    if (::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1) {
      line.resize(std::min<std::size_t>(line.size(), size.ws_col - 1U));
    }
    const std::size_t width = line.size();
    if (width < live_width_) line.append(live_width_ - width, ' ');
    put("\r" + line);
    live_width_ = width;
  }
  void erase() {
    const std::lock_guard<std::mutex> lock(mutex_);
    put(erasing_text());
  }
  void print(const std::string& line) {
    const std::lock_guard<std::mutex> lock(mutex_);
    put(erasing_text() + line + "\n");
  }

 private:
  std::string erasing_text() {
    const std::size_t width = std::exchange(live_width_, 0);
    return width == 0 ? std::string() : "\r" + std::string(width, ' ') + "\r";
  }
  static void put(const std::string& text) {
    std::fwrite(text.data(), 1, text.size(), stderr);
    std::fflush(stderr);
  }

  std::mutex mutex_;
  std::size_t live_width_ = 0;
};

Console& console() {
  static Console instance;
  return instance;
}

std::int64_t milliseconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::steady_clock::now() - start).count();
}

std::int64_t interval_of(ProgressStyle style) {
  return style == ProgressStyle::terminal ? terminal_interval : plain_interval;
}

/// "samples: 43 % (1490/3461), 36.3/s, 54 s left".
std::string running_line(const std::string& stage, std::uint64_t done, std::uint64_t total, double seconds) {
  const double rate = seconds > 0 ? static_cast<double>(done) / seconds : 0;
  if (total == 0) return fmt::format("{}: {}, {:.3g}/s", stage, done, rate);
  const std::uint64_t shown = std::min(done, total);
  const double share = 100.0 * static_cast<double>(shown) / static_cast<double>(total);
  std::string line = fmt::format("{}: {:.0f} % ({}/{})", stage, std::floor(share), shown, total);
  if (done > 0 && rate > 0) {
    line += fmt::format(", {:.3g}/s, {} left", rate, describe_duration(static_cast<double>(total - shown) / rate));
  }
  return line;
}

}  // namespace

Progress::Progress(std::string stage, std::uint64_t total_steps, ProgressStyle style)
    : stage_(std::move(stage)),
      total_(total_steps),
      style_(resolve(style)),
      started_(std::chrono::steady_clock::now()),
      next_show_milliseconds_(interval_of(style_)),
      uncaught_at_start_(std::uncaught_exceptions()) {}

Progress::~Progress() {
  try {
    if (std::uncaught_exceptions() <= uncaught_at_start_) {
      finish();
    } else if (style_ == ProgressStyle::terminal && !finished_) {
      console().erase();
    }
  } catch (...) {  // NOLINT(bugprone-empty-catch): progress that cannot be shown is no reason to end the program
  }
}

void Progress::advance(std::uint64_t steps) {
  done_.fetch_add(steps, std::memory_order_relaxed);
  if (style_ == ProgressStyle::silent) return;
  const std::int64_t now = milliseconds_since(started_);
  std::int64_t due = next_show_milliseconds_.load(std::memory_order_relaxed);
  // Whoever moves the due time shows; the other threads go on.
  if (now >= due && next_show_milliseconds_.compare_exchange_strong(due, now + interval_of(style_))) show(false);
}

void Progress::finish() {
  if (style_ != ProgressStyle::silent) show(true);
}

void Progress::show(bool closing) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (finished_) return;
  finished_ = closing;
  const std::uint64_t done = done_.load(std::memory_order_relaxed);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - started_).count();
  if (closing) {
    const std::string count =
        total_ == 0 || done == total_ ? fmt::format("{}", done) : fmt::format("{}/{}", done, total_);
    console().print(fmt::format("{}: {} in {}", stage_, count, describe_duration(seconds)));
  } else if (style_ == ProgressStyle::terminal) {
    console().rewrite(running_line(stage_, done, total_, seconds));
  } else {
    console().print(running_line(stage_, done, total_, seconds));
  }
}

void log_line(ProgressStyle style, const std::string& line) {
  if (style != ProgressStyle::silent) console().print(single_line(line, line.size()));
}

std::string describe_duration(double seconds) {
  if (!(seconds >= 0) || seconds > 1e12) return "an unknown time";
  if (seconds < 0.05) return "less than 0.1 s";
  if (seconds < 0.95) return fmt::format("{:.1f} s", seconds);
  const auto whole = static_cast<std::int64_t>(std::llround(seconds));
  if (whole < 60) return fmt::format("{} s", whole);
  if (whole < 3600) return fmt::format("{} min {:02} s", whole / 60, whole % 60);
  const std::int64_t minutes = (whole + 30) / 60;
  return fmt::format("{} h {:02} min", minutes / 60, minutes % 60);
}

namespace {

std::atomic<bool> requested_flag{false};
static_assert(std::atomic<bool>::is_always_lock_free, "the flag is set inside a signal handler");

extern "C" void on_signal(int /*signal*/) {
  if (requested_flag.exchange(true)) ::_exit(static_cast<int>(ExitCode::interrupted));
}

}  // namespace

void install_interruption_handlers() {
  struct sigaction action = {};
  action.sa_handler = on_signal;
  sigemptyset(&action.sa_mask);
  // Reads and writes inside libraries carry on; they need not know about EINTR.
  action.sa_flags = SA_RESTART;
  // The last three: what batch systems send before the time is up, and at a limit on processor time.
  for (const int signal : {SIGINT, SIGTERM, SIGUSR1, SIGUSR2, SIGXCPU}) ::sigaction(signal, &action, nullptr);
  // The end of a terminal or of a connection. nohup asks to go on after it.
  struct sigaction before = {};
  if (::sigaction(SIGHUP, nullptr, &before) == 0 && before.sa_handler != SIG_IGN) ::sigaction(SIGHUP, &action, nullptr);
  // A file-size limit, or a reader that has gone, then makes the write fail with a message, instead of ending the
  // process without one; and a long run does not end because nobody listens to its progress any more.
  struct sigaction ignore = {};
  ignore.sa_handler = SIG_IGN;
  for (const int signal : {SIGXFSZ, SIGPIPE}) ::sigaction(signal, &ignore, nullptr);
}

bool interruption_requested() { return requested_flag.load(std::memory_order_relaxed); }

void throw_if_interrupted() {
  if (interruption_requested()) {
    throw Interrupted("stopped on request: what was drawn is kept, and the same command goes on there");
  }
}

void request_interruption(bool requested) { requested_flag.store(requested); }

double processor_seconds() {
  std::timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace granuscope
