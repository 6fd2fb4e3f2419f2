// Whatever a damaged file makes the library do: here each of it is done on purpose.
#include "storage/hdf5_file.h"

#include <signal.h>  // NOLINT(modernize-deprecated-headers): raise and kill
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <chrono>
#include <fstream>
#include <functional>
#include <new>
#include <string>
#include <vector>

#include "kit/temporary_folder.h"
#include "storage/record_comparison.h"
#include "support/error.h"
#include "support/progress.h"

using namespace granuscope;
using namespace granuscope::test;
using Catch::Matchers::Contains;

namespace {

std::size_t open_files() {
  std::size_t count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) ++count;
  return count;
}

bool has_children() { return !(::waitpid(-1, nullptr, WNOHANG) == -1 && errno == ECHILD); }

std::string refusal_of(const std::function<std::string()>& read, ReadPatience patience = {}) {
  return input_error_of([&] { (void)read_in_child("file.h5", "a pile file", read, patience); });
}

}  // namespace

TEST_CASE("what the child returns arrives whole") {
  const std::size_t before = open_files();
  CHECK(read_in_child("file.h5", "a pile file", [] { return std::string(); }).empty());
  CHECK(read_in_child("file.h5", "a pile file", [] { return std::string("a\0b", 3); }) == std::string("a\0b", 3));
  std::string much(30'000'000, 'x');
  much.back() = 'y';
  CHECK(read_in_child("file.h5", "a pile file", [&much] { return much; }) == much);
  CHECK(open_files() == before);
  CHECK_FALSE(has_children());
}

TEST_CASE("what the child does to its memory stays there") {
  int value = 1;
  CHECK(read_in_child("file.h5", "a pile file", [&value] { return std::to_string(++value); }) == "2");
  CHECK(value == 1);
}

TEST_CASE("errors of the child keep their kind and words") {
  CHECK(refusal_of([]() -> std::string { throw InputError("not this one"); }) == "not this one");
  CHECK_THROWS_AS(read_in_child("f", "k", []() -> std::string { throw EnvironmentError("no"); }), EnvironmentError);
  CHECK_THROWS_AS(read_in_child("f", "k", []() -> std::string { throw std::bad_alloc(); }), std::bad_alloc);
  CHECK_THROWS_WITH(read_in_child("f", "k", []() -> std::string { throw std::logic_error("a fault"); }), "a fault");
  CHECK_FALSE(has_children());
}

TEST_CASE("a crash ends the child only") {
  const std::size_t before = open_files();
  for (const int signal : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE}) {
    const std::string message = refusal_of([signal]() -> std::string {
      ::signal(signal, SIG_DFL);  // a sanitizer would tell a tale first
      ::raise(signal);
      return "never";
    });
    CHECK_THAT(message, Contains("cannot read 'file.h5' as a pile file") && Contains("crashed") &&
                            Contains("damaged") && Contains("Make the file again"));
  }
  // A library that ends the process by itself, with the status of success.
  CHECK_THAT(refusal_of([]() -> std::string { ::_exit(0); }), Contains("crashed"));
  CHECK(open_files() == before);
  CHECK_FALSE(has_children());
}

TEST_CASE("an endless loop and an endless wait are ended") {
  const auto started = std::chrono::steady_clock::now();
  CHECK_THAT(refusal_of(
                 []() -> std::string {
                   for (volatile unsigned i = 0;;) i = i + 1;
                 },
                 {.processor_seconds = 1, .wall_seconds = 60}),
             Contains("did not come to an end"));
  CHECK_THAT(refusal_of(
                 []() -> std::string {
                   for (;;) ::pause();
                 },
                 {.processor_seconds = 10, .wall_seconds = 0.3}),
             Contains("did not come to an end within 0 s"));
  CHECK(std::chrono::steady_clock::now() - started < std::chrono::seconds(50));
  CHECK_FALSE(has_children());
}

TEST_CASE("a request to stop ends the reading") {
  request_interruption(true);
  CHECK_THROWS_AS(read_in_child("f", "k",
                                []() -> std::string {
                                  for (;;) ::pause();
                                }),
                  Interrupted);
  request_interruption(false);
  CHECK_FALSE(has_children());
}

TEST_CASE("the child does not hold the caller's files open") {
  const TemporaryFolder folder;
  std::ofstream other(folder / "other");
  const std::string open = read_in_child("f", "k", [] { return std::to_string(open_files()); });
  CHECK(open == "5");  // nothing three times, the answer, and the folder that is looked at
}
