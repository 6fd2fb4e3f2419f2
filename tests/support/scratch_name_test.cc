#include "support/files.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <fstream>
#include <string>

#include "kit/temporary_folder.h"

using namespace granuscope;
using namespace granuscope::test;

namespace {

/// The name that a process of this machine with that number would have taken.
std::string name_by(pid_t process, const std::string& file) {
  std::string name = scratch_name(file);
  const std::string own = fmt::format("-{}-", ::getpid());
  return name.replace(name.find(own), own.size(), fmt::format("-{}-", process));
}

void touch(const std::filesystem::path& file) { std::ofstream(file) << "half"; }

/// A process that has ended; reaped or not.
pid_t ended_process(bool reaped) {
  const pid_t process = ::fork();
  if (process == 0) ::_exit(0);
  siginfo_t info = {};
  ::waitid(P_PID, static_cast<id_t>(process), &info, WEXITED | (reaped ? 0 : WNOWAIT));
  return process;
}

}  // namespace

TEST_CASE("names of work in progress are hidden, short and never the same") {
  CHECK(scratch_name("a.png") != scratch_name("a.png"));
  CHECK(scratch_name("a.png").starts_with(".granuscope-"));
  CHECK(scratch_name("a.png").ends_with("-a.png"));
  CHECK(scratch_name(std::string(250, 'x') + ".png").size() < 250);
  CHECK(scratch_name(std::string(250, 'x') + ".png").ends_with("x.png"));
}

TEST_CASE("what killed processes left is removed, and nothing else") {
  const TemporaryFolder folder;
  const pid_t dead = ended_process(true);
  touch(folder / name_by(dead, "mu-0.3.h5"));
  std::filesystem::create_directories(folder / name_by(dead, "report-pdf") / "below");
  touch(folder / name_by(dead, "report-pdf") / "below" / "report.html");

  const std::string mine = scratch_name("mu-0.3.h5");
  const std::string init = name_by(1, "mu-0.3.h5");
  const std::string elsewhere = fmt::format(".granuscope-another-machine-1f-{}-1-mu-0.3.h5", dead);
  const std::vector<std::string> kept{mine, init, elsewhere, "mu-0.3.h5", ".hidden", ".granuscope-", ".granuscope-x"};
  for (const std::string& name : kept) touch(folder / name);

  CHECK(remove_leftovers(folder.path()) == 2);
  CHECK(folder.contents().size() == kept.size());
  for (const std::string& name : kept) CHECK(std::filesystem::exists(folder / name));
  CHECK(remove_leftovers(folder.path()) == 0);
  CHECK(remove_leftovers(folder / "none") == 0);
}

TEST_CASE("a process that nobody has taken note of has ended all the same") {
  const TemporaryFolder folder;
  const pid_t zombie = ended_process(false);
  touch(folder / name_by(zombie, "a"));
  CHECK(remove_leftovers(folder.path()) == 1);
  ::waitpid(zombie, nullptr, 0);
}

TEST_CASE("processes of another container are not judged by their number here") {
  const TemporaryFolder folder;
  const pid_t dead = ended_process(true);
  struct stat status = {};
  REQUIRE(::stat("/proc/self/ns/pid", &status) == 0);
  std::string foreign = name_by(dead, "a");
  const std::string here = fmt::format("-{:x}-", status.st_ino);
  REQUIRE(foreign.find(here) != std::string::npos);
  foreign.replace(foreign.find(here), here.size(), fmt::format("-{:x}-", status.st_ino + 1));
  touch(folder / foreign);
  CHECK(remove_leftovers(folder.path()) == 0);
}

TEST_CASE("a file's leftovers are those that were to become it") {
  const TemporaryFolder folder;
  const pid_t dead = ended_process(true);
  const std::string mine = scratch_name("pile.png");
  const std::string longer = name_by(dead, "a-3-pile.png"), other = name_by(dead, "pile.h5");
  for (const std::string& name : {name_by(dead, "pile.png"), name_by(dead, "pile.png"), mine, longer, other}) {
    touch(folder / name);
  }
  CHECK(remove_leftovers_of(folder / "pile.png") == 2);
  for (const std::string& name : {mine, longer, other}) CHECK(std::filesystem::exists(folder / name));
  CHECK(folder.contents().size() == 3);
  CHECK(remove_leftovers_of(folder / "none" / "pile.png") == 0);
}
