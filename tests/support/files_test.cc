#include "support/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>  // NOLINT(modernize-deprecated-headers): kill is POSIX
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <chrono>
#include <fstream>
#include <string>
#include <thread>

#include "kit/file_size_limit.h"
#include "kit/temporary_folder.h"
#include "support/error.h"

using namespace granuscope;
using Catch::Matchers::Contains;
using Catch::Matchers::Message;
using granuscope::test::FileSizeLimit;
using granuscope::test::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

/// The message of the EnvironmentError that `action` throws.
template <class Action>
std::string failure_of(const Action& action) {
  try {
    action();
  } catch (const EnvironmentError& error) {
    CHECK(error.exit_code() == ExitCode::environment);
    return error.what();
  }
  FAIL("no EnvironmentError was thrown");
  return "";
}

}  // namespace

TEST_CASE("write_file writes all bytes and leaves nothing beside them") {
  const TemporaryFolder folder;
  const std::string bytes = std::string("zero \0 byte, ", 13) + std::string(3'000'000, 'x');
  write_file(folder / "result.txt", bytes);
  CHECK(read_file(folder / "result.txt") == bytes);
  CHECK(folder.contents() == std::vector<std::string>{"result.txt"});

  write_file(folder / "result.txt", "");
  CHECK(read_file(folder / "result.txt").empty());
  CHECK(folder.contents() == std::vector<std::string>{"result.txt"});
}

TEST_CASE("a file that is never committed does not appear and leaves the old one as it was") {
  const TemporaryFolder folder;
  write_file(folder / "old.txt", "old");
  {
    const AtomicFile file(folder / "old.txt");
    CHECK(file.temporary_path().parent_path() == folder.path());
    CHECK(file.temporary_path().filename().string().front() == '.');
    CHECK(file.temporary_path().extension() == ".txt");
    std::ofstream(file.temporary_path()) << "half of the new";
    CHECK(read_file(folder / "old.txt") == "old");
  }
  CHECK(read_file(folder / "old.txt") == "old");
  CHECK(folder.contents() == std::vector<std::string>{"old.txt"});
}

TEST_CASE("what a killed process left of a file goes when the file is written next") {
  const TemporaryFolder folder;
  int ready[2] = {};
  REQUIRE(::pipe(ready) == 0);
  const pid_t child = ::fork();
  if (child == 0) {
    const AtomicFile file(folder / "pile.png");
    [[maybe_unused]] const ssize_t told = ::write(ready[1], "x", 1);
    for (;;) ::pause();
  }
  char letter = 0;
  REQUIRE(::read(ready[0], &letter, 1) == 1);
  CHECK(folder.contents().size() == 1);
  write_file(folder / "pile.png", "while the other still writes");
  CHECK(folder.contents().size() == 2);

  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  write_file(folder / "other.png", "another file");
  CHECK(folder.contents().size() == 3);
  write_file(folder / "pile.png", "new");
  CHECK(folder.contents().size() == 2);
  CHECK(read_file(folder / "other.png") == "another file");
  CHECK(read_file(folder / "pile.png") == "new");
  ::close(ready[0]);
  ::close(ready[1]);
}

TEST_CASE("a library may write the temporary file by name") {
  const TemporaryFolder folder;
  AtomicFile file(folder / "new.txt");
  std::ofstream(file.temporary_path()) << "new";
  CHECK_FALSE(fs::exists(folder / "new.txt"));
  file.commit();
  CHECK(read_file(folder / "new.txt") == "new");
  CHECK(folder.contents() == std::vector<std::string>{"new.txt"});
}

TEST_CASE("a temporary file that vanished is an error, not a lost result") {
  const TemporaryFolder folder;
  write_file(folder / "old.txt", "old");
  AtomicFile file(folder / "old.txt");
  fs::remove(file.temporary_path());
  CHECK_THAT(failure_of([&] { file.commit(); }), Contains("old.txt") && Contains("No such file"));
  CHECK(read_file(folder / "old.txt") == "old");
}

TEST_CASE("a full disk keeps the old file and says so") {
  const TemporaryFolder folder;
  const std::string target = folder / "result.txt";
  write_file(target, "old");
  {
    const FileSizeLimit limit(100'000);  // the first write is short, the second fails
    CHECK_THAT(failure_of([&] { write_file(target, std::string(1'000'000, 'x')); }),
               Contains(target) && Contains("File too large") && Contains("limit on file sizes"));
  }
  CHECK(read_file(target) == "old");
  CHECK(folder.contents() == std::vector<std::string>{"result.txt"});
}

TEST_CASE("errors name the target, the reason and the way out") {
  const TemporaryFolder folder;
  SECTION("no such folder") {
    const std::string target = folder / "missing/result.txt";
    CHECK_THAT(failure_of([&] { write_file(target, "x"); }),
               Contains(target) && Contains("No such file or directory") && Contains("folder exists"));
    CHECK(folder.contents().empty());
  }
  SECTION("a file where a folder is needed") {
    write_file(folder / "file", "x");
    CHECK_THAT(failure_of([&] { write_file(folder / "file/result.txt", "x"); }), Contains("Not a directory"));
  }
  SECTION("the target is a folder") {
    make_folder(folder / "result");
    CHECK_THAT(failure_of([&] { write_file(folder / "result", "x"); }),
               Contains("Is a directory") && Contains("name a file"));
    CHECK_THAT(failure_of([&] { write_file(folder.path().string() + "/", "x"); }), Contains("Is a directory"));
    CHECK(folder.contents() == std::vector<std::string>{"result"});
  }
  SECTION("the target is a device") {
    CHECK_THAT(failure_of([] { write_file("/dev/full", "x"); }), Contains("/dev/full") && Contains("ordinary file"));
    CHECK(fs::is_character_file("/dev/full"));
  }
  SECTION("no name at all") {
    CHECK_THAT(failure_of([] { write_file("", "x"); }), Contains("without a name"));
  }
  SECTION("a name too long") {
    CHECK_THAT(failure_of([&] { write_file(folder / std::string(300, 'n'), "x"); }), Contains("too long"));
    CHECK(folder.contents().empty());
  }
  SECTION("no permission") {
    if (::geteuid() == 0) return;  // root may write anywhere
    fs::permissions(folder.path(), fs::perms::owner_read | fs::perms::owner_exec);
    CHECK_THAT(failure_of([&] { write_file(folder / "result.txt", "x"); }),
               Contains("Permission denied") && Contains("permissions"));
  }
}

TEST_CASE("the longest name the system allows still works") {
  const TemporaryFolder folder;
  const std::string name(255, 'n');
  write_file(folder / name, "x");
  CHECK(folder.contents() == std::vector<std::string>{name});
}

TEST_CASE("a link keeps pointing to the file it points to") {
  const TemporaryFolder folder;
  make_folder(folder / "real");
  write_file(folder / "real/result.txt", "old");
  fs::create_symlink("real/result.txt", folder / "latest.txt");
  write_file(folder / "latest.txt", "new");
  CHECK(fs::is_symlink(folder / "latest.txt"));
  CHECK(read_file(folder / "real/result.txt") == "new");
}

TEST_CASE("writers of the same file at the same time leave one whole version") {
  const TemporaryFolder folder;
  const auto write_often = [&folder](char letter) {
    for (int i = 0; i < 20; ++i) write_file(folder / "result.txt", std::string(10'000, letter));
  };
  std::thread first(write_often, 'a'), second(write_often, 'b');
  first.join();
  second.join();
  const std::string bytes = read_file(folder / "result.txt");
  CHECK(bytes == std::string(10'000, bytes.front()));
  CHECK(folder.contents() == std::vector<std::string>{"result.txt"});
}

TEST_CASE("new files get the permissions the user asked for, not those of a private temporary") {
  const TemporaryFolder folder;
  const mode_t before = ::umask(022);
  write_file(folder / "result.txt", "x");
  ::umask(before);
  CHECK((fs::status(folder / "result.txt").permissions() & fs::perms::all) ==
        (fs::perms::owner_read | fs::perms::owner_write | fs::perms::group_read | fs::perms::others_read));
}

TEST_CASE("read_file says why it cannot") {
  const TemporaryFolder folder;
  CHECK_THROWS_MATCHES(read_file(folder / "missing"), InputError,
                       Message("cannot read '" + (folder / "missing").string() + "': " + system_reason(ENOENT)));
  CHECK_THROWS_AS(read_file(folder.path()), InputError);
  REQUIRE(::mkfifo((folder / "pipe").c_str(), 0600) == 0);  // nobody will ever write into it
  CHECK_THROWS_WITH(read_file(folder / "pipe"), Contains("It is not an ordinary file"));
  write_file(folder / "four", "four");
  CHECK(read_file(folder / "four", 4) == "four");
  CHECK_THROWS_WITH(read_file(folder / "four", 3), Contains("4 bytes or more are too many"));
  int ends[2] = {};  // what is open already has a writer
  REQUIRE(::pipe(ends) == 0);
  REQUIRE(::write(ends[1], "piped", 5) == 5);
  ::close(ends[1]);
  const std::string pipe = "/dev/fd/" + std::to_string(ends[0]);
  CHECK_THROWS_WITH(read_file(pipe, 4), Contains("5 bytes or more are too many"));
  ::close(ends[0]);
}

TEST_CASE("whether a file can be written is asked without writing it") {
  const TemporaryFolder folder;
  require_writable(folder / "new");
  CHECK(fs::is_empty(folder.path()));
  write_file(folder / "old", "x");
  require_writable(folder / "old");
  CHECK(read_file(folder / "old") == "x");
  CHECK_THROWS_AS(require_writable(folder / "none/new"), EnvironmentError);
  CHECK_THROWS_AS(require_writable(folder.path()), EnvironmentError);
}

TEST_CASE("make_folder makes parents, accepts a folder that is there, and refuses a file in its place") {
  const TemporaryFolder folder;
  make_folder(folder / "a/b/c");
  make_folder(folder / "a/b/c");
  make_folder(folder / "a/b/c/");
  CHECK(fs::is_directory(folder / "a/b/c"));
  write_file(folder / "file", "x");
  CHECK_THAT(failure_of([&] { make_folder(folder / "file"); }),
             Contains((folder / "file").string()) && Contains("Not a directory"));
  CHECK_THAT(failure_of([&] { make_folder(folder / "file/below"); }), Contains("Not a directory"));
  fs::create_symlink(folder / "none/there", folder / "link");
  CHECK_THAT(failure_of([&] { make_folder(folder / "link"); }), Contains("leads nowhere. Make what it leads to"));
  CHECK_THAT(failure_of([&] { make_folder(""); }), Contains("It has no name. Name a folder."));
}

TEST_CASE("a file that is closed to others stays so when it is replaced") {
  const TemporaryFolder folder;
  write_file(folder / "private", "old");
  fs::permissions(folder / "private", fs::perms::owner_read | fs::perms::owner_write);
  write_file(folder / "private", "new");
  CHECK(fs::status(folder / "private").permissions() == (fs::perms::owner_read | fs::perms::owner_write));
}

TEST_CASE("A lock is waited for as long as a killed process may take to leave it, and no longer") {
  const TemporaryFolder folder;
  write_file(folder / "file", "");
  const auto opened = [&] { return FileDescriptor(::open((folder / "file").c_str(), O_RDWR | O_CLOEXEC)); };
  const FileDescriptor one = opened(), other = opened();
  CHECK(lock_file(one, true));
  CHECK(lock_file(other, true));
  CHECK_FALSE(lock_file(opened(), false));
  {
    FileDescriptor alone = opened();
    std::thread leaves([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      ::flock(one.get(), LOCK_UN);
      ::flock(other.get(), LOCK_UN);
    });
    CHECK(lock_file(alone, false));
    leaves.join();
    CHECK_FALSE(lock_file(one, true));
  }
  CHECK(lock_file(one, true));
  CHECK(lock_file(FileDescriptor(), false));  // what cannot be opened cannot be locked
}

TEST_CASE("what is forbidden is not called missing") {
  const TemporaryFolder folder;
  write_file(folder / "file", "x");
  require_visible(folder / "file");
  require_visible(folder / "none");  // is nothing to see
  fs::permissions(folder.path(), fs::perms::owner_all);
  const pid_t child = ::fork();
  if (child == 0) {  // as somebody else, where this is root
    int status = 1;
    if (::geteuid() == 0 ? ::setuid(65534) == 0 : ::chmod(folder.path().c_str(), 0) == 0) {
      try {
        require_visible(folder / "file");
      } catch (const InputError& error) {
        status = std::string(error.what()).find("Permission denied") != std::string::npos ? 0 : 2;
      }
    }
    ::_exit(status);
  }
  int status = -1;
  REQUIRE(::waitpid(child, &status, 0) == child);
  fs::permissions(folder.path(), fs::perms::owner_all);
  CHECK(status == 0);
}

TEST_CASE("SHA-256 agrees with the examples of FIPS 180-2") {
  CHECK(sha256("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  CHECK(sha256("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  CHECK(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq") ==
        "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  CHECK(sha256(std::string(1'000'000, 'a')) == "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST_CASE("a file's digest is that of its bytes, however many pieces it is read in") {
  const TemporaryFolder folder;
  write_file(folder / "a", std::string(1'000'000, 'a'));
  CHECK(sha256_of_file(folder / "a") == "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  write_file(folder / "empty", "");
  CHECK(sha256_of_file(folder / "empty") == sha256(""));
  CHECK_THROWS_AS(sha256_of_file(folder / "missing"), InputError);
  CHECK_THROWS_AS(sha256_of_file(folder.path()), InputError);
}

TEST_CASE("cache keys are XXH3 with 64 bits") {
  CHECK(cache_key("") == sha256("").substr(0, 16));
  CHECK(cache_key("a").size() == 16);
  CHECK(cache_key("a") != cache_key("b"));
  CHECK(cache_key(std::string("a\0b", 3)) != cache_key(std::string("a\0c", 3)));
}

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
