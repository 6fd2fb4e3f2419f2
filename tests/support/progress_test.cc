#include "support/progress.h"

#include <signal.h>  // NOLINT(modernize-deprecated-headers): raise and kill
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <limits>
#include <stdexcept>
#include <thread>
#include <vector>

#include "kit/standard_error_capture.h"
#include "support/error.h"

using namespace granuscope;
using Catch::Matchers::Contains;
using granuscope::test::StandardErrorCapture;

TEST_CASE("plain progress prints one closing line for a short stage") {
  const StandardErrorCapture capture;
  {
    Progress progress("samples", 1000, ProgressStyle::plain);
    for (int i = 0; i < 1000; ++i) progress.advance();
  }
  const std::string text = capture.text();
  CHECK_THAT(text, Catch::StartsWith("samples: 1000 in ") && Catch::EndsWith("s\n"));
  CHECK(std::count(text.begin(), text.end(), '\n') == 1);
  CHECK(text.find('\r') == std::string::npos);
}

TEST_CASE("a stage that stops early says how far it came") {
  const StandardErrorCapture capture;
  {
    Progress progress("figures", 9, ProgressStyle::plain);
    progress.advance(4);
    progress.finish();
    progress.finish();  // once is enough
  }
  CHECK_THAT(capture.text(), Catch::StartsWith("figures: 4/9 in "));
  const std::string text = capture.text();
  CHECK(std::count(text.begin(), text.end(), '\n') == 1);
}

TEST_CASE("a terminal line is rewritten, shows share, rate and time left, and is erased") {
  const StandardErrorCapture capture;
  {
    Progress progress("samples", 100, ProgressStyle::terminal);
    progress.advance(30);  // too early to show
    CHECK(capture.text().empty());
    std::this_thread::sleep_for(std::chrono::milliseconds(250));
    progress.advance(20);
    CHECK_THAT(capture.text(), Contains("\rsamples: 50 % (50/100), ") && Contains("/s, ") && Contains(" s left"));
    CHECK(capture.text().find('\n') == std::string::npos);
    progress.advance(50);
  }
  const std::string text = capture.text();
  const std::size_t last_return = text.rfind('\r');
  REQUIRE(last_return != std::string::npos);
  CHECK_THAT(text.substr(last_return), Catch::StartsWith("\rsamples: 100 in ") && Catch::EndsWith("\n"));
  // What stood on the line is covered with spaces before the closing line is written.
  const std::size_t shown = text.find('\r', 1);
  CHECK(text.substr(shown, last_return - shown) == "\r" + std::string(shown - 1, ' '));
}

TEST_CASE("a line said meanwhile does not land behind the running one") {
  const StandardErrorCapture capture;
  Progress progress("samples", 2, ProgressStyle::terminal);
  std::this_thread::sleep_for(std::chrono::milliseconds(250));
  progress.advance();
  log_line(ProgressStyle::terminal, "note");
  CHECK_THAT(capture.text(), Catch::EndsWith(" \rnote\n"));
  progress.finish();
}

TEST_CASE("silence is silent") {
  const StandardErrorCapture capture;
  {
    Progress progress("samples", 10, ProgressStyle::silent);
    progress.advance(10);
    progress.finish();
  }
  log_line(ProgressStyle::silent, "nothing");
  CHECK(capture.text().empty());
}

TEST_CASE("without a terminal, automatic is plain") {
  const StandardErrorCapture capture;
  { Progress("stage", 0, ProgressStyle::automatic).advance(3); }
  log_line(ProgressStyle::automatic, "word");
  CHECK_THAT(capture.text(), Catch::StartsWith("stage: 3 in ") && Catch::EndsWith("\nword\n"));
}

TEST_CASE("a stage that ends in an exception does not claim to be finished") {
  const StandardErrorCapture capture;
  try {
    Progress progress("samples", 10, ProgressStyle::plain);
    progress.advance(5);
    throw std::runtime_error("stop");
  } catch (const std::runtime_error&) {
    CHECK(capture.text().empty());
  }
}

TEST_CASE("steps of several threads all count") {
  const StandardErrorCapture capture;
  {
    Progress progress("samples", 400'000, ProgressStyle::terminal);
    std::vector<std::thread> threads;
    threads.reserve(4);
    for (int t = 0; t < 4; ++t) {
      threads.emplace_back([&progress] {
        for (int i = 0; i < 100'000; ++i) progress.advance();
      });
    }
    for (std::thread& thread : threads) thread.join();
  }
  CHECK_THAT(capture.text(), Contains("samples: 400000 in "));
}

TEST_CASE("durations read as a person would say them") {
  CHECK(describe_duration(0) == "less than 0.1 s");
  CHECK(describe_duration(0.34) == "0.3 s");
  CHECK(describe_duration(0.97) == "1 s");
  CHECK(describe_duration(41.2) == "41 s");
  CHECK(describe_duration(59.4) == "59 s");
  CHECK(describe_duration(59.6) == "1 min 00 s");
  CHECK(describe_duration(192) == "3 min 12 s");
  CHECK(describe_duration(3599.7) == "1 h 00 min");
  CHECK(describe_duration(7500) == "2 h 05 min");
  CHECK(describe_duration(100 * 3600.0) == "100 h 00 min");
  CHECK(describe_duration(-1) == "an unknown time");
  CHECK(describe_duration(std::numeric_limits<double>::infinity()) == "an unknown time");
  CHECK(describe_duration(std::numeric_limits<double>::quiet_NaN()) == "an unknown time");
}

namespace {

/// Runs `action` in a process of its own and returns its exit status, or 128 + signal.
template <class Action>
int status_of(const Action& action) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::signal(SIGHUP, SIG_DFL);  // ignored where the tests themselves run under nohup
    ::_exit(action());
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
}

}  // namespace

TEST_CASE("the flag is set and cleared by hand, and thrown as Interrupted") {
  CHECK_FALSE(interruption_requested());
  CHECK_NOTHROW(throw_if_interrupted());
  request_interruption(true);
  CHECK(interruption_requested());
  try {
    throw_if_interrupted();
    FAIL("nothing was thrown");
  } catch (const Error& error) {
    CHECK(error.exit_code() == ExitCode::interrupted);
  }
  request_interruption(false);
  CHECK_NOTHROW(throw_if_interrupted());
}

TEST_CASE("the first signal asks, the second one ends with status 4") {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGUSR2, SIGXCPU}) {
    CHECK(status_of([signal] {
            install_interruption_handlers();
            ::raise(signal);
            return interruption_requested() ? 42 : 1;
          }) == 42);
    CHECK(status_of([signal] {
            install_interruption_handlers();
            ::raise(signal);
            ::raise(SIGINT);
            return 1;
          }) == 4);
  }
}

TEST_CASE("under nohup the end of the terminal asks for nothing, and a closed pipe ends nothing") {
  CHECK(status_of([] {
          ::signal(SIGHUP, SIG_IGN);
          install_interruption_handlers();
          ::raise(SIGHUP);
          ::raise(SIGHUP);
          return interruption_requested() ? 1 : 42;
        }) == 42);
  CHECK(status_of([] {
          install_interruption_handlers();
          int ends[2] = {};
          if (::pipe(ends) != 0) return 1;
          ::close(ends[0]);
          return ::write(ends[1], "x", 1) == -1 ? 42 : 1;
        }) == 42);
}

namespace granuscope {

TEST_CASE("processor time passes while this thread works, and neither while it sleeps nor while another one works") {
  const auto work = [] {
    const double start = processor_seconds();
    while (processor_seconds() < start + 0.05) {
    }
  };
  const double before = processor_seconds();
  work();
  const double worked = processor_seconds();
  CHECK(worked - before >= 0.05);
  std::this_thread::sleep_for(std::chrono::milliseconds(60));
  std::thread(work).join();
  CHECK(processor_seconds() - worked < 0.03);
}

}  // namespace granuscope
