#include "history/nightly.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "history/night_book.h"
#include "kit/file_size_limit.h"
#include "kit/small_experiment.h"
#include "kit/temporary_folder.h"
#include "pipeline/quiet_run.h"
#include "storage/ensemble_file.h"
#include "support/error.h"
#include "support/files.h"
#include "support/progress.h"

using namespace granuscope;
using Catch::Matchers::Contains;
using test::TemporaryFolder;
namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

constexpr std::uint64_t round_of_samples = 256;

/// Small piles, and nothing plotted.
Experiment experiment() { return unplotted(parse_experiment(smallest_experiment_text, "small.toml")); }

NightlyOptions nights_in(const fs::path& folder) {
  NightlyOptions options;
  options.folder = folder;
  options.grow = round_of_samples;
  options.threads = 2;
  options.keep = 5;
  return options;
}

using Run = std::function<RunResult(const Experiment&, const RunOptions&)>;

void edit(const fs::path& file, const std::function<void(Json&)>& change) {
  Json json = Json::parse(read_file(file));
  change(json);
  write_file(file, json.dump(2));
}

/// As if the run had left its files so.
void sign(const fs::path& folder) {
  edit(folder / "manifest.json", [&](Json& manifest) {
    manifest.erase("digest");
    for (Json& file : manifest["files"]) file["sha256"] = sha256_of_file(folder / file["path"].get<std::string>());
  });
}

/// A program whose sampling draws other piles under the same name.
RunResult other_law(const Experiment& experiment, const RunOptions& options) {
  Experiment changed = experiment;
  changed.sampling.seed += 1000;
  RunResult result = run_experiment(changed, options);
  write_file(options.folder / "experiment.toml", print_experiment(experiment));
  edit(options.folder / "summary.json", [&](Json& summary) { summary["seed"] = experiment.sampling.seed; });
  sign(options.folder);
  return result;
}

RunResult other_library(const Experiment& experiment, const RunOptions& options) {
  RunResult result = run_experiment(experiment, options);
  edit(options.folder / "manifest.json", [](Json& manifest) { manifest["provenance"]["libraries"]["GSL"] = "9.9"; });
  sign(options.folder);
  return result;
}

RunResult failing_pile(const Experiment& experiment, const RunOptions& options) {
  RunResult result = run_experiment(experiment, options);
  if (options.folder.filename() != "pool") return result;
  const fs::path file = options.folder / "ensembles/mu-0.3.h5";
  EnsembleRecord record = read_ensemble(file);
  record.failed.push_back({experiment.response.samples - 1, 7, "granuscope sample --sample 1"});
  write_ensemble(file, record);
  return result;
}

RunResult broken_identity(const Experiment&, const RunOptions&) {
  throw std::logic_error("the weights of a layer do not add up");
}

RunResult killed_after_growing(const Experiment& experiment, const RunOptions& options) {
  RunResult result = run_experiment(experiment, options);
  if (options.folder.filename() == "pool") throw Interrupted("killed");
  return result;
}

std::set<std::string> told(const Night& night) {
  std::set<std::string> kinds;
  for (const Alarm& alarm : night.alarms) {
    if (alarm.state == "open") kinds.insert(alarm.kind);
  }
  return kinds;
}

void damage(const fs::path& file) {
  std::string bytes = read_file(file);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  write_file(file, bytes);
}

}  // namespace

TEST_CASE("The pool of several nights is, byte for byte, one run of as many samples") {
  const TemporaryFolder history, at_once;
  Experiment once = experiment();
  NightlyOptions options = nights_in(history.path());
  for (const std::uint64_t samples : {1, 2, 4}) {
    options.grow = samples == 4 ? 2 * round_of_samples : 1;  // filled up to a whole round
    const Night night = run_night(experiment(), options);
    CHECK(night.samples == samples * round_of_samples);
    CHECK(told(night).empty());
  }
  once.response.samples = 4 * round_of_samples;
  run_experiment(once, quiet(at_once.path()));
  for (const char* file : {"summary.json", "ensembles/mu-0.3.h5", "ensembles/mu-0.h5", "claims.xml", "summary.md"}) {
    INFO(file);
    CHECK((read_file(history / "pool" / file) == read_file(at_once / file)));
  }
  CHECK((read_file(history / "latest/summary.json") == read_file(at_once / "summary.json")));
  const NightBook book(history.path());
  const Night last = book.night(3);
  REQUIRE(last.numbers.size() >= 6);
  int judged = 0;
  for (const NightNumber& number : last.numbers) judged += std::isfinite(number.z) ? 1 : 0;
  CHECK(judged == 3);  // c, D and c_thrust at mu = 0.3; without friction every pile is the same
  CHECK_FALSE(last.environment.at("git_commit").empty());
  CHECK(last.seconds.contains("pool: analyse"));
}

TEST_CASE("Thirty nights: each kind of change gives its alarm, and all other nights are quiet", "[long]") {
  const TemporaryFolder history;
  struct Injected {
    Run run;
    std::set<std::string> alarms;
  };
  std::map<int, Injected> injected;
  injected[5] = {run_experiment, {"experiment"}};  // another seed, below
  injected[9] = {other_law, {"canary"}};
  injected[13] = {other_library, {}};  // the same numbers: marked, not told
  injected[17] = {failing_pile, {"failed pile"}};
  injected[19] = {broken_identity, {"broken"}};
  injected[21] = {run_experiment, {"damaged"}};  // a file of the pool, below
  std::uint64_t samples = 0;
  for (int n = 1; n <= 30; ++n) {
    CAPTURE(n);
    Experiment tonight = experiment();
    NightlyOptions options = nights_in(history.path());
    if (const auto found = injected.find(n); found != injected.end()) options.run = found->second.run;
    if (n == 5) tonight.sampling.seed = 99;
    if (n == 21) damage(history / "pool/ensembles/mu-0.3.h5");
    if (n == 24) {
      options.run = killed_after_growing;
      CHECK_THROWS_AS(run_night(tonight, options), Interrupted);
      options.run = run_experiment;
    }
    if (n == 27) {
      const int folder = ::open(history.path().c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
      REQUIRE(::flock(folder, LOCK_EX | LOCK_NB) == 0);
      CHECK_THROWS_AS(run_night(tonight, options), BusyError);
      ::close(folder);
    }
    const Night night = run_night(tonight, options);
    const std::set<std::string> expected = injected.contains(n) ? injected[n].alarms : std::set<std::string>{};
    for (const Alarm& alarm : night.alarms) UNSCOPED_INFO(alarm.kind << " (" << alarm.state << "): " << alarm.what);
    CHECK(told(night) == expected);
    CHECK((night.status == "alarm") == !expected.empty());
    CHECK(fs::exists(history / "alert.md") == !expected.empty());
    const bool grows = n != 5 && n != 9 && n != 19;
    samples += grows ? round_of_samples : 0;
    CHECK(night.samples == samples);
    CHECK(night.number == n);
  }
  const std::string page = read_file(history / "index.html");
  CHECK_THAT(page, Contains("library GSL") && Contains("9.9"));
  CHECK_THAT(page, Contains("latest/report.html"));
  CHECK(page.find("http") == std::string::npos);  // self-contained
  int reports = 0;
  for (const auto& entry : fs::directory_iterator(history / "reports")) reports += entry.is_directory() ? 1 : 0;
  CHECK(reports == 5);
  CHECK(read_file(history / "latest/summary.json") == read_file(history / "pool/summary.json"));
  CHECK_THAT(read_file(history / "badge.json"), Contains("\"success\""));
}

TEST_CASE("An accepted change of law is the new normal, its pool begins anew, and the night stays", "[long]") {
  const TemporaryFolder history;
  NightlyOptions options = nights_in(history.path());
  run_night(experiment(), options);
  options.run = other_law;
  CHECK(told(run_night(experiment(), options)) == std::set<std::string>{"canary"});
  CHECK_THROWS_WITH(accept_night(history.path(), 1), Contains("nothing to accept"));
  CHECK_THROWS_WITH(accept_night(history.path(), 7), Contains("there is no night 7"));
  accept_night(history.path(), 2);
  CHECK_FALSE(fs::exists(history / "alert.md"));
  const Night next = run_night(experiment(), options);
  CHECK(told(next).empty());
  CHECK(next.samples == round_of_samples);
  const NightBook book(history.path());
  CHECK(book.night(2).alarms.at(0).state == "accepted");
  // The law as it was is the change now.
  options.run = run_experiment;
  CHECK(told(run_night(experiment(), options)) == std::set<std::string>{"canary"});
}

TEST_CASE("What an accepted night does to the folders is done by the next one where it was killed", "[long]") {
  const TemporaryFolder history;
  NightlyOptions options = nights_in(history.path());
  run_night(experiment(), options);
  options.run = other_law;
  run_night(experiment(), options);
  // As accept_night leaves the book, with the folders as they were.
  NightBook(history.path()).accept(2, {{"samples", "0"}, {"new_reference", "alarm-2"}, {"pool_ends", "yes"}});
  REQUIRE(fs::exists(history / "canary/alarm-2"));
  const Night next = run_night(experiment(), options);
  CHECK(told(next).empty());
  CHECK(next.samples == round_of_samples);
  CHECK_FALSE(fs::exists(history / "canary/alarm-2"));
  CHECK(NightBook(history.path()).state("new_reference").empty());
}

TEST_CASE("An alarm has passed once a night is fine, and a number that is gone says since when") {
  const TemporaryFolder history;
  NightBook book(history.path());
  Night night;
  night.status = "alarm";
  night.date = "2026-01-01T02:00:00Z";
  night.numbers = {{"c", {"c", 0.55, 0.01}}, {"D", {"D", 0.07, 0.01}}};
  night.alarms = {{"damaged", "a file", "open"}};
  night.verdicts = {{"settled", "reproduced", 1}, {"young", "not decided", 2}};
  book.add(night, {});
  CHECK(book.night(1).alarms[0].state == "open");
  night = {};
  night.status = "fine";
  night.date = "2026-01-02T02:00:00Z";
  night.numbers = {{"D", {"D", 0.07, 0.01}}, {"beta at mu = 0.1", {"beta at mu = 0.1", 0.5749, 2e-5}}};
  night.verdicts = {{"settled", "reproduced", 1}, {"young", "reproduced", 2}};
  book.add(night, {});
  CHECK(book.night(1).alarms[0].state == "passed");
  CHECK_THAT(describe(book.night(1)), Contains("alarm") && Contains("damaged (passed)"));
  write_pages(history.path(), book);
  const std::string page = read_file(history / "index.html");
  CHECK_THAT(page, Contains("c: 0.550(10) on 2026-01-01, none since"));
  CHECK(page.find("<h3>D: 0.070(10)</h3>") < page.find("<h3>c: "));
  CHECK_THAT(page, Contains("<title>night 1, 2026-01-01, 0 samples: 0.550(10)</title>") &&
                       Contains("<span>night 1, 2026-01-01</span>") && Contains(", 2026-01-02</span>"));
  // As many digits as tell the ends of a scale apart.
  CHECK_THAT(page, Contains("<h3>β at μ = 0.1: 0.574900(20)</h3>") && Contains("<span>0.574880 to 0.574920</span>") &&
                       Contains("<span>0.060 to 0.080</span>"));
  CHECK_THAT(page, Contains("<td>young: not decided → reproduced</td>") && !Contains("settled:"));
}

TEST_CASE("An accepted experiment is the one that is run from then on", "[long]") {
  const TemporaryFolder history;
  const NightlyOptions options = nights_in(history.path());
  run_night(experiment(), options);
  Experiment other = experiment();
  other.sampling.seed = 99;
  other.name = "with another name, too";
  const Night of_other = run_night(other, options);
  CHECK(told(of_other) == std::set<std::string>{"experiment"});
  CHECK_THAT(of_other.alarms.at(0).what, Contains("take the old file again, begin another --history, or accept"));
  accept_night(history.path(), 2);
  CHECK(told(run_night(other, options)).empty());
  Experiment renamed = other;
  renamed.name = "what is only told changes nothing";
  CHECK(told(run_night(renamed, options)).empty());
  CHECK(told(run_night(experiment(), options)) == std::set<std::string>{"experiment"});
}

TEST_CASE("A full disk leaves the history as it was, whatever it cuts off") {
  const TemporaryFolder history;
  Night night;
  night.date = "2026-01-01T02:00:00Z";
  night.status = "fine";
  for (int k = 0; k < 400; ++k) night.numbers.push_back({std::to_string(k), {std::to_string(k), 1, 1}});
  NightBook(history.path()).add(night, {{"samples", "256"}});
  int failed = 0;
  for (std::uint64_t limit = 4096; limit < 200'000 && failed < 40; limit += 12288) {
    const std::int64_t before = NightBook(history.path()).count();
    try {
      const test::FileSizeLimit cut(limit);
      NightBook(history.path()).add(night, {{"samples", "512"}});
    } catch (const EnvironmentError&) {
      ++failed;
      const NightBook book(history.path());
      CHECK(book.count() == before);
      CHECK(book.state("samples") == (before == 1 ? "256" : "512"));
      continue;
    }
    CHECK(NightBook(history.path()).count() == before + 1);
  }
  CHECK(failed > 0);
}

TEST_CASE("A night that a full disk stops is gone on with by the next one, to the same pool", "[long]") {
  const TemporaryFolder full, whole;
  const NightlyOptions on_full = nights_in(full.path()), on_whole = nights_in(whole.path());
  for (int n = 0; n < 2; ++n) run_night(experiment(), on_whole);
  int stopped = 0;
  // From the first file that is written to the largest one, on the first night and on the second.
  for (const std::uint64_t limit : {1'000, 12'000, 40'000, 100'000, 200'000, 0, 2'000, 30'000, 60'000, 150'000, 0}) {
    CAPTURE(limit);
    if (limit == 0) {
      CHECK(told(run_night(experiment(), on_full)).empty());
      continue;
    }
    const test::FileSizeLimit cut(limit);
    try {
      run_night(experiment(), on_full);
      break;  // it had room
    } catch (const EnvironmentError&) {
      ++stopped;
    }
  }
  CHECK(stopped >= 4);
  const NightBook one(full.path()), other(whole.path());
  REQUIRE(one.count() == other.count());
  CHECK(one.night(2).samples == other.night(2).samples);
  for (const char* file : {"pool/summary.json", "pool/ensembles/mu-0.3.h5", "latest/summary.json"}) {
    INFO(file);
    CHECK((read_file(full / file) == read_file(whole / file)));
  }
}

TEST_CASE("Ten thousand nights are told within a second", "[long]") {
  const TemporaryFolder history;
  { const NightBook book(history.path()); }
  {
    const Database database(history / "history.sqlite", "", 1);
    const std::string count =
        "WITH RECURSIVE n(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM n WHERE i < 10000), "
        "k(j) AS (SELECT 1 UNION ALL SELECT j + 1 FROM k WHERE j < 24) ";
    database.transaction([&] {
      database.run(count + "INSERT INTO nights SELECT i, '2026-01-01T02:00:00Z', '', 'fine', 256 * i, '' FROM n");
      database.run(
          count + "INSERT INTO numbers SELECT i, 'number ' || j, j, j + i * 1e-6, 0.01, NULL, NULL, NULL, 0 FROM n, k");
      database.run(count + "INSERT INTO environment SELECT i, 'git_commit', i / 1000 FROM n");
      database.run(count + "INSERT INTO seconds SELECT i, 'pool', 10 + i % 7 FROM n");
    });
  }
  const NightBook book(history.path());
  const double start = processor_seconds();  // others share the cores
  const NightBook tonight(history.path());   // as a night begins: what it is held against
  CHECK(tonight.last(30).size() == 30);
  write_pages(history.path(), book);
  prune_reports(history.path(), book, 30);
  const double seconds = processor_seconds() - start;
  CHECK(seconds < 1);
  WARN("10 000 nights: pages in " << seconds << " s, index.html of " << fs::file_size(history / "index.html")
                                  << " bytes");
  CHECK_THAT(read_file(history / "index.html"), Contains("10000 nights"));
}

TEST_CASE("A history is refused with its reason where it is none") {
  const TemporaryFolder history;
  write_file(history / "history.sqlite", std::string(5000, 'x'));
  CHECK_THROWS_WITH(NightBook(history.path()), Contains("this is no history"));
  fs::remove(history / "history.sqlite");
  { const Database other(history / "history.sqlite", "CREATE TABLE t(x)", 77); }
  CHECK_THROWS_WITH(NightBook(history.path()), Contains("version 77 where 1 is known"));
}

TEST_CASE("A history begins in an empty folder, and what it has lost is not begun anew") {
  const TemporaryFolder history;
  const NightlyOptions options = nights_in(history.path());
  for (const char* name : {"notes.md", "badge.json"}) write_file(history / name, "mine");
  CHECK_THROWS_WITH(run_night(experiment(), options), Contains("neither empty nor a history"));
  for (const char* name : {"notes.md", "badge.json"}) CHECK(read_file(history / name) == "mine");
  fs::remove(history / "badge.json");
  CHECK_FALSE(fs::exists(history / "history.sqlite"));
  fs::remove(history / "notes.md");

  run_night(experiment(), options);
  const std::string pool = read_file(history / "pool/summary.json");
  fs::rename(history / "history.sqlite", history / "database");
  for (const char* more : {"history.sqlite-wal", "history.sqlite-shm"}) fs::remove(history / more);
  CHECK_THROWS_WITH(run_night(experiment(), options), Contains("history.sqlite is missing or empty"));
  CHECK_THAT(read_file(history / "badge.json"), Contains("not run on") && Contains("critical"));
  CHECK_THROWS_WITH(require_no_lost_history(history.path()), Contains("history.sqlite is missing or empty"));
  write_file(history / "history.sqlite", "");
  CHECK_THROWS_WITH(run_night(experiment(), options), Contains("history.sqlite is missing or empty"));
  fs::remove(history / "history.sqlite");
  // A database without anything in it is not made to one that has no nights.
  CHECK_THROWS(Database(history / "history.sqlite", "", 0));
  for (int time = 0; time < 2; ++time)
    CHECK_THROWS_WITH(run_night(experiment(), options), Contains("no history, or an empty one"));
  for (const char* one : {"history.sqlite", "history.sqlite-wal", "history.sqlite-shm"}) fs::remove(history / one);
  {  // the database of another history
    const TemporaryFolder other;
    { const NightBook book(other.path()); }
    fs::copy_file(other / "history.sqlite", history / "history.sqlite");
  }
  CHECK_THROWS_WITH(run_night(experiment(), options), Contains("knows of no pool"));
  for (const char* one : {"history.sqlite", "history.sqlite-wal", "history.sqlite-shm"}) fs::remove(history / one);
  fs::rename(history / "database", history / "history.sqlite");
  CHECK(read_file(history / "pool/summary.json") == pool);

  fs::rename(history / "canary/reference", history / "canary/kept");
  CHECK(told(run_night(experiment(), options)) == std::set<std::string>{"lost"});
  CHECK(read_file(history / "pool/summary.json") == pool);
  accept_night(history.path(), 2);
  CHECK(told(run_night(experiment(), options)).empty());
  CHECK(fs::exists(history / "canary/reference"));

  // However long ago the nights are, or if they are forgotten.
  fs::remove_all(history / "canary/reference");
  for (std::int64_t night = 1; night <= 3; ++night) forget_night(history.path(), night);
  for (const char* page : {"index.html", "badge.json", "alert.md"}) CHECK_FALSE(fs::exists(history / page));
  CHECK(told(run_night(experiment(), options)) == std::set<std::string>{"lost"});
  accept_night(history.path(), 4);
  write_file(history / "badge.json", "of before");  // of one who was stopped in between
  CHECK_THROWS_WITH(accept_night(history.path(), 4), Contains("nothing to accept"));
  CHECK_THAT(read_file(history / "badge.json"), Contains("granuscope nightly"));
  CHECK(told(run_night(experiment(), options)).empty());
  // What a database does not say, or says against itself, begins no pool anew, be it of night 5 or forgotten.
  const std::string drawn = read_file(history / "pool/summary.json");
  const auto check_refused = [&](const std::string& name, const std::string& value, const char* why) {
    INFO(name << " = " << value);
    const std::string good = NightBook(history.path()).state(name);
    NightBook(history.path()).keep({{name, value}});
    CHECK_THROWS_WITH(run_night(experiment(), options), Contains(why));
    NightBook(history.path()).keep({{name, good}});
    CHECK(read_file(history / "pool/summary.json") == drawn);
  };
  for (const bool forgotten : {false, true}) {
    for (const char* value : {"abc", "0", "00", "-8", "1e3", ""}) {
      check_refused("samples", value, "does not say how many samples the pool has");
    }
    check_refused("experiment", "", "or of which experiment");
    check_refused("pool_ends", "yes", "says that a pool of piles ends");
    check_refused("begun", "", "knows of no pool");
    if (forgotten) break;
    for (const std::int64_t night : {4, 5}) forget_night(history.path(), night);
  }
}

TEST_CASE("A database from elsewhere moves no folder but a canary that the history has kept") {
  const TemporaryFolder folder;
  const fs::path history = folder / "history";
  run_night(experiment(), nights_in(history));
  fs::create_directories(folder / "mine");
  const auto name = GENERATE(as<std::string>(), "../../mine", "alarm-1/../../../mine", "/etc", "alarm-", "reference");
  INFO(name);
  NightBook(history).keep({{"new_reference", name}});
  CHECK_THROWS_WITH(run_night(experiment(), nights_in(history)), Contains("take the history from a backup"));
  CHECK(fs::is_directory(folder / "mine"));
  CHECK(fs::exists(history / "canary/reference/summary.json"));
}

TEST_CASE("A history is read where nothing can be written, and by who may not write it") {
  const TemporaryFolder folder;
  const fs::path history = "/" + (folder / "nights?of#100%").string();  // "//…" is a path, too
  fs::create_directories(history);
  Night night;
  night.date = "2026-01-01T02:00:00Z";
  night.status = "fine";
  NightBook(history).add(night, {});
  fs::permissions(history / "history.sqlite", fs::perms::owner_read);
  fs::permissions(history, fs::perms::owner_read | fs::perms::owner_exec);
  CHECK(NightBook(history, DatabaseUse::read).count() == 1);
  fs::permissions(history, fs::perms::owner_all);
  CHECK(std::distance(fs::directory_iterator(history), {}) == 1);  // nothing is left beside it

  fs::remove(history / "history.sqlite");
  write_file(history / "history.sqlite", "");
  for (const DatabaseUse use : {DatabaseUse::read, DatabaseUse::change}) {
    CHECK_THROWS_WITH(NightBook(history, use), Contains("this is no history"));
  }
  CHECK_FALSE(NightBook(history).count());
}

TEST_CASE("A history that somebody has locked is called locked, and one that is made to hang ends") {
  const TemporaryFolder history;
  { const NightBook book(history.path()); }
  const Database other(history / "history.sqlite", "", 1);
  other.run("PRAGMA journal_mode = DELETE");
  other.run("BEGIN EXCLUSIVE");
  CHECK_THROWS_AS(NightBook(history.path(), DatabaseUse::read), BusyError);  // waits for ten seconds
  other.run("ROLLBACK");
  CHECK_THROWS_AS(([&] {
                    request_interruption(true);
                    other.run("WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c) SELECT max(x) FROM c");
                  }()),
                  Interrupted);
  request_interruption(false);
}

TEST_CASE("A history that holds what no history has is not read") {
  const TemporaryFolder history;
  { const NightBook book(history.path()); }
  {
    const Database other(history / "history.sqlite", "", 1);
    other.run("PRAGMA journal_mode = DELETE");
    other.run(GENERATE("CREATE VIEW v AS SELECT 1", "CREATE INDEX i ON nights(date)", "CREATE TABLE more(x)",
                       "CREATE TRIGGER t AFTER INSERT ON nights BEGIN DELETE FROM alarms; END"));
  }
  CHECK_THROWS_WITH(NightBook(history.path(), DatabaseUse::read), Contains("which no history has"));
  CHECK_THROWS_WITH(NightBook(history.path()), Contains("which no history has"));
}

TEST_CASE("A history in which a number is of another kind, negative or infinite is called damaged") {
  const TemporaryFolder history;
  { const NightBook book(history.path()); }
  const auto [samples, value, told] =
      GENERATE(table<std::string, std::string, std::string>({{"-1", "0.5", "samples is -1"},
                                                             {"2.5", "0.5", "samples is 2.5"},
                                                             {"9e999", "0.5", "samples is Inf"},
                                                             {"'many'", "0.5", "samples is many"},
                                                             {"64", "'half'", "value is half"},
                                                             {"64", "-9e999", "value is -Inf"},
                                                             {"64", "0.5", ""}}));
  INFO(samples << ", " << value);
  {
    const Database other(history / "history.sqlite", "", 1);
    other.run("INSERT INTO nights VALUES(1, '2026-01-01T02:00:00Z', '', 'fine', " + samples + ", '')");
    other.run("INSERT INTO numbers VALUES(1, 'c', 0, " + value + ", 0.1, NULL, NULL, NULL, 0)");
  }
  const NightBook book(history.path(), DatabaseUse::read);
  if (told.empty()) CHECK(book.last(0).at(0).samples == 64);
  if (!told.empty()) CHECK_THROWS_WITH(book.last(0), Contains("damaged (" + told + ")"));
}

TEST_CASE("What somebody keeps in a history is neither removed with what nights leave nor written through a link") {
  const TemporaryFolder history, other;
  const NightlyOptions options = nights_in(history.path());
  run_night(experiment(), options);
  run_night(experiment(), options);
  for (const char* mine : {".latest/thesis.tex", "pool/figures/last-year.csv"}) {
    make_folder((history / mine).parent_path());
    write_file(history / mine, "mine");
    CHECK(told(run_night(experiment(), options)).empty());
    CHECK(read_file(history / mine) == "mine");
  }
  fs::remove(history / "pool/ensembles/mu-0.3.h5");
  CHECK(told(run_night(experiment(), options)) == std::set<std::string>{"pool"});
  CHECK_THROWS_WITH(accept_night(history.path(), 5), Contains("last-year.csv") && Contains("nothing was"));
  CHECK(fs::exists(history / "pool/summary.json"));
  fs::remove(history / "pool/figures/last-year.csv");
  CHECK(told(run_night(experiment(), options)).empty());
  CHECK(NightBook(history.path()).night(6).samples == round_of_samples);

  fs::rename(history / "badge.json", other / "badge.json");
  fs::create_symlink(other / "badge.json", history / "badge.json");
  const std::string badge = read_file(other / "badge.json");
  CHECK_THROWS_AS(run_night(experiment(), options), InputError);
  CHECK(read_file(other / "badge.json") == badge);
}

TEST_CASE("A pool that was cut short alarms until the night is accepted, and its page links to what is there") {
  const TemporaryFolder history, copy;
  NightlyOptions options = nights_in(history.path());
  options.keep = 1;
  run_night(experiment(), options);
  const fs::path file = history / "pool/ensembles/mu-0.3.h5";
  const std::string whole = read_file(file);
  fs::resize_file(file, 2000);
  CHECK(told(run_night(experiment(), options)) == std::set<std::string>{"pool"});
  CHECK_THAT(read_file(history / "badge.json"), Contains("critical"));
  CHECK(fs::file_size(file) == 2000);
  write_file(file, whole);
  CHECK(told(run_night(experiment(), options)).empty());
  const std::string page = read_file(history / "index.html");
  CHECK(page.find("reports/" + NightBook(history.path()).night(1).report + "/") == std::string::npos);
  CHECK(NightBook(history.path()).night(1).report != NightBook(history.path()).night(3).report);

  write_file(history / "canary/reference/summary.json", "{");
  CHECK(told(run_night(experiment(), options)) == std::set<std::string>{"lost"});
  fs::remove(file);
  accept_night(history.path(), 4);
  CHECK(told(run_night(experiment(), options)) == std::set<std::string>{"pool"});
  accept_night(history.path(), 5);
  fs::remove(history / "latest");
  fs::copy(history / "canary/reference", history / "latest",
           fs::copy_options::recursive);  // as a copy without links has it
  const Night anew = run_night(experiment(), options);
  CHECK(told(anew).empty());
  CHECK(anew.samples == round_of_samples);
  CHECK(fs::is_symlink(history / "latest"));
}

TEST_CASE("What stands where the link to the last report belongs is replaced, or costs no alarm") {
  const TemporaryFolder history;
  const NightlyOptions options = nights_in(history.path());
  run_night(experiment(), options);
  const fs::path link = history / "latest";
  const std::string named = fs::read_symlink(link).string();
  fs::remove(link);
  write_file(link, named);  // as zip and git leave a link where there are none
  run_night(experiment(), options);
  CHECK(fs::is_symlink(link));
  fs::remove(link);
  write_file(link, "notes");
  write_file(history / "canary/reference/summary.json", "{");
  CHECK_THROWS_WITH(run_night(experiment(), options), Contains("move it away"));
  CHECK(read_file(link) == "notes");
  CHECK(fs::exists(history / "alert.md"));
}

TEST_CASE("A canary of which anything is damaged or missing alarms, and so does at once what else is") {
  const TemporaryFolder history;
  const NightlyOptions options = nights_in(history.path());
  run_night(experiment(), options);
  for (const char* name : {"ensembles/mu-0.3.h5", "experiment.toml", "manifest.json"}) {
    INFO(name);
    const fs::path file = history / "canary/reference" / name;
    const std::string whole = read_file(file);
    fs::resize_file(file, whole.size() / 2);
    CHECK(told(run_night(experiment(), options)) == std::set<std::string>{"lost"});
    fs::remove(file);
    const Night night = run_night(experiment(), options);
    CHECK(told(night) == std::set<std::string>{"lost"});
    CHECK_THAT(night.alarms.at(0).what, Contains("canary/reference/" + std::string(name)));
    write_file(file, whole);
    CHECK(told(run_night(experiment(), options)).empty());
  }
  fs::remove_all(history / "canary");
  fs::remove_all(history / "pool");
  const Night lost = run_night(experiment(), options);
  CHECK(told(lost) == std::set<std::string>{"lost", "pool"});
  accept_night(history.path(), lost.number);
  const Night anew = run_night(experiment(), options);
  CHECK(told(anew).empty());
  CHECK(anew.samples == round_of_samples);
}

TEST_CASE("What a database says moves no cursor") {
  const TemporaryFolder history;
  const std::string odd = "a\x1b[2J";
  Night night;
  night.date = night.report = odd;
  night.numbers = {{odd, {odd, 1, 1}}};
  night.verdicts = {{odd, odd}};
  night.alarms = {{odd, odd, "open"}};
  NightBook(history.path()).add(night, {});
  const std::vector<Night> all = NightBook(history.path(), DatabaseUse::read).last(0);
  for (const std::string& text : {table_text(all.at(0)), csv_text(all), describe(all[0])}) {
    CHECK_THAT(text, Contains("a [2J") && !Contains("\x1b"));
  }
}

TEST_CASE("A first night that was killed leaves nothing that alarms") {
  const TemporaryFolder history;
  Experiment large = experiment();
  large.response.samples *= 8;
  NightlyOptions options = nights_in(history.path());
  options.run = killed_after_growing;
  CHECK_THROWS_AS(run_night(large, options), Interrupted);
  REQUIRE(fs::exists(history / "canary/reference"));
  const Night night = run_night(experiment(), nights_in(history.path()));
  CHECK(night.number == 1);
  CHECK(told(night).empty());
}

TEST_CASE("A pool does not grow beyond what one seed has") {
  const TemporaryFolder history;
  NightlyOptions options = nights_in(history.path());
  for (const std::uint64_t grow : {std::numeric_limits<std::uint64_t>::max(), most_samples + 1}) {
    options.grow = grow;
    CHECK_THROWS_WITH(run_night(experiment(), options), Contains("would grow beyond"));
  }
}
