#pragma once
#include <fmt/core.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>
#include <utility>

namespace granuscope {
/// How progress is shown on stderr.
enum class ProgressStyle {
  automatic,  ///< terminal if stderr is one, plain otherwise
  terminal,   ///< one line, rewritten: stage, share, rate, ETA
  plain,      ///< a new line at most every ten seconds and at each stage's end
  silent,
};

/// Progress of one stage with a known number of steps. advance() may be called from any thread and is cheap.
class Progress {
 public:
  Progress(std::string stage, std::uint64_t total_steps, ProgressStyle style = ProgressStyle::automatic);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  ~Progress();
  void advance(std::uint64_t steps = 1);
  /// Prints the closing line with the stage's duration (also done by the destructor unless an exception is in flight).
  void finish();

 private:
  void show(bool closing);

  std::string stage_;
  std::uint64_t total_;
  ProgressStyle style_;
  std::atomic<std::uint64_t> done_{0};
  std::chrono::steady_clock::time_point started_;
  std::atomic<std::int64_t> next_show_milliseconds_{0};
  std::mutex mutex_;
  bool finished_ = false;
  int uncaught_at_start_ = 0;
};

/// One line on stderr, unless silent. The only way libraries speak is through objects they are handed.
void log_line(ProgressStyle style, const std::string& line);
template <class First, class... Rest>
void log_line(ProgressStyle style, fmt::format_string<First, Rest...> line, First&& first, Rest&&... rest) {
  log_line(style, fmt::format(line, std::forward<First>(first), std::forward<Rest>(rest)...));
}

/// "41 s", "3 min 12 s", "2 h 05 min".
std::string describe_duration(double seconds);

/// From now on SIGINT, SIGTERM and SIGHUP (unless it is ignored, as under nohup) only set a flag (a second one ends the
/// process at once, status 4), and a file-size limit or a closed pipe makes writes fail instead of ending the process.
void install_interruption_handlers();
bool interruption_requested();
/// Throws Interrupted if the flag is set. Called between stages and samples, and now and then in the midst of a pile.
void throw_if_interrupted();
/// Sets or clears the flag by hand (tests).
void request_interruption(bool requested);

/// Processor time of this thread so far, in seconds: what a piece of work took however busy the machine is.
double processor_seconds();

}  // namespace granuscope
