#include "history/night_book.h"

#include <fmt/format.h>
#include <sqlite3.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <system_error>
#include <utility>

#include "support/error.h"
#include "support/plain_text.h"
#include "support/progress.h"

namespace granuscope {
namespace {

constexpr int history_version = 1;
constexpr const char* history_schema = R"sql(
CREATE TABLE nights(
  night INTEGER PRIMARY KEY AUTOINCREMENT, date TEXT NOT NULL, report TEXT NOT NULL, status TEXT NOT NULL,
  samples INTEGER NOT NULL, experiment TEXT NOT NULL);
CREATE TABLE environment(
  night INTEGER NOT NULL REFERENCES nights ON DELETE CASCADE, name TEXT NOT NULL, value TEXT NOT NULL,
  PRIMARY KEY(night, name)) WITHOUT ROWID;
CREATE TABLE seconds(
  night INTEGER NOT NULL REFERENCES nights ON DELETE CASCADE, stage TEXT NOT NULL, seconds REAL,
  PRIMARY KEY(night, stage)) WITHOUT ROWID;
CREATE TABLE numbers(
  night INTEGER NOT NULL REFERENCES nights ON DELETE CASCADE, name TEXT NOT NULL, position INTEGER NOT NULL,
  value REAL NOT NULL, stderr REAL NOT NULL, piece REAL, piece_stderr REAL, z REAL, moved INTEGER NOT NULL,
  PRIMARY KEY(night, name)) WITHOUT ROWID;
CREATE TABLE verdicts(
  night INTEGER NOT NULL REFERENCES nights ON DELETE CASCADE, claim TEXT NOT NULL, position INTEGER NOT NULL,
  verdict TEXT NOT NULL, z REAL, PRIMARY KEY(night, claim)) WITHOUT ROWID;
CREATE TABLE alarms(
  night INTEGER NOT NULL REFERENCES nights ON DELETE CASCADE, position INTEGER NOT NULL, kind TEXT NOT NULL,
  what TEXT NOT NULL, state TEXT NOT NULL CHECK(state IN ('open', 'watched', 'accepted')),
  PRIMARY KEY(night, position)) WITHOUT ROWID;
CREATE TABLE state(name TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
)sql";

constexpr const char* columns = "SELECT night, date, report, status, samples, experiment FROM nights ";

}  // namespace

NightBook::NightBook(const std::filesystem::path& folder, DatabaseUse use)
    : database_(folder / "history.sqlite", history_schema, history_version,  // what nights have begun is not made anew
                use == DatabaseUse::create && std::filesystem::exists(folder / "canary") ? DatabaseUse::change : use) {}

void NightBook::keep_state(const std::map<std::string, std::string>& state) const {
  Statement put(database_, "INSERT INTO state VALUES(?, ?) ON CONFLICT(name) DO UPDATE SET value = excluded.value");
  for (const auto& [name, value] : state) put.run(name, value);
}

std::int64_t NightBook::add(const Night& night, const std::map<std::string, std::string>& state) {
  std::int64_t number = 0;
  database_.transaction([&] {
    Statement(database_, "INSERT INTO nights(date, report, status, samples, experiment) VALUES(?, ?, ?, ?, ?)")
        .run(night.date, night.report, night.status, static_cast<std::int64_t>(night.samples), night.experiment);
    number = database_.last_row();
    Statement environment(database_, "INSERT INTO environment VALUES(?, ?, ?)");
    for (const auto& [name, value] : night.environment) environment.run(number, name, value);
    Statement seconds(database_, "INSERT INTO seconds VALUES(?, ?, ?)");
    for (const auto& [stage, time] : night.seconds) seconds.run(number, stage, time);
    std::int64_t position = 0;
    Statement numbers(database_, "INSERT INTO numbers VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?)");
    for (const NightNumber& one : night.numbers) {
      numbers.run(number, one.name, position++, one.pool.value, one.pool.standard_error, one.piece, one.piece_error,
                  one.z, std::int64_t{one.moved});
    }
    Statement verdicts(database_, "INSERT INTO verdicts VALUES(?, ?, ?, ?, ?)");
    position = 0;
    for (const NightVerdict& one : night.verdicts) verdicts.run(number, one.claim, position++, one.verdict, one.z);
    Statement alarms(database_, "INSERT INTO alarms VALUES(?, ?, ?, ?, ?)");
    position = 0;
    for (const Alarm& one : night.alarms) alarms.run(number, position++, one.kind, one.what, one.state);
    keep_state(state);
  });
  return number;
}

Night NightBook::read(Statement& row) const {
  Statement fine(database_, "SELECT night FROM nights WHERE status = 'fine' ORDER BY night DESC LIMIT 1");
  const std::int64_t last_fine = fine.step() ? fine.integer(0) : 0;
  Night night;
  night.number = row.integer(0);
  night.date = row.line(1);
  night.report = row.line(2);
  night.status = row.line(3);
  night.samples = static_cast<std::uint64_t>(row.integer(4));
  night.experiment = row.text(5);
  const auto of_night = [&](const char* sql) {
    Statement rows(database_, sql);
    rows.bind(1, night.number);
    return rows;
  };
  for (Statement rows = of_night("SELECT name, value FROM environment WHERE night = ?"); rows.step();) {
    night.environment[rows.line(0)] = rows.line(1);
  }
  for (Statement rows = of_night("SELECT stage, seconds FROM seconds WHERE night = ?"); rows.step();) {
    night.seconds[rows.line(0)] = rows.number(1);
  }
  for (Statement rows = of_night(
           "SELECT name, value, stderr, piece, piece_stderr, z, moved FROM numbers WHERE night = ? ORDER BY position");
       rows.step();) {
    const std::string name = rows.line(0);
    night.numbers.push_back({name,
                             {name, rows.number(1), rows.number(2)},
                             rows.number(3),
                             rows.number(4),
                             rows.number(5),
                             rows.integer(6) != 0});
  }
  for (Statement rows = of_night("SELECT claim, verdict, z FROM verdicts WHERE night = ? ORDER BY position");
       rows.step();) {
    night.verdicts.push_back({rows.line(0), rows.line(1), rows.number(2)});
  }
  for (Statement rows = of_night("SELECT kind, what, state FROM alarms WHERE night = ? ORDER BY position");
       rows.step();) {
    const bool passed = rows.text(2) == "open" && night.number < last_fine;
    night.alarms.push_back({rows.line(0), rows.text(1), passed ? "passed" : rows.text(2)});
  }
  return night;
}

std::vector<Night> NightBook::last(std::size_t how_many) const {
  std::vector<Night> nights;
  const std::string limit = how_many == 0 ? "" : fmt::format(" LIMIT {}", how_many);
  for (Statement rows(database_, std::string(columns) + "ORDER BY night DESC" + limit); rows.step();) {
    nights.push_back(read(rows));
  }
  std::ranges::reverse(nights);
  return nights;
}

Night NightBook::night(std::int64_t number) const {
  Statement row(database_, std::string(columns) + "WHERE night = ?");
  row.bind(1, number);
  if (!row.step()) {
    throw InputError("there is no night {} in this history; `granuscope history DIR list` shows them", number);
  }
  return read(row);
}

std::int64_t NightBook::count() const {
  Statement row(database_, "SELECT count(*) FROM nights");
  row.step();
  return row.integer(0);
}

std::set<std::string> NightBook::last_reports(std::size_t how_many) const {
  std::set<std::string> names;
  Statement rows(database_, "SELECT report FROM nights WHERE report != '' ORDER BY night DESC LIMIT ?");
  for (rows.bind(1, static_cast<std::int64_t>(how_many)); rows.step();) names.insert(rows.text(0));
  return names;
}

void NightBook::forget(std::int64_t number) {
  (void)night(number);
  database_.transaction([&] { Statement(database_, "DELETE FROM nights WHERE night = ?").run(number); });
}

void NightBook::accept(std::int64_t number, const std::map<std::string, std::string>& state) {
  database_.transaction([&] {
    Statement(database_, "UPDATE alarms SET state = 'accepted' WHERE night = ?").run(number);
    keep_state(state);
  });
}

void NightBook::keep(const std::map<std::string, std::string>& state) {
  database_.transaction([&] { keep_state(state); });
}

std::string NightBook::state(const std::string& name) const {
  Statement row(database_, "SELECT value FROM state WHERE name = ?");
  row.bind(1, name);
  return row.step() ? row.text(0) : "";
}

Statement::Statement(const Database& database, const std::string& sql)
    : database_(&database), statement_(nullptr, sqlite3_finalize) {
  sqlite3_stmt* statement = nullptr;
  const int code = sqlite3_prepare_v2(database.handle_.get(), sql.c_str(), -1, &statement, nullptr);
  statement_.reset(statement);
  if (code != SQLITE_OK) database.fail(code);
}

Statement& Statement::bind(int parameter, std::int64_t value) {
  if (const int code = sqlite3_bind_int64(statement_.get(), parameter, value); code != SQLITE_OK) database_->fail(code);
  return *this;
}

Statement& Statement::bind(int parameter, double value) {
  const int code = std::isfinite(value) ? sqlite3_bind_double(statement_.get(), parameter, value)
                                        : sqlite3_bind_null(statement_.get(), parameter);
  if (code != SQLITE_OK) database_->fail(code);
  return *this;
}

Statement& Statement::bind(int parameter, const std::string& value) {
  const int code = sqlite3_bind_text64(statement_.get(), parameter, value.data(), value.size(),
                                       SQLITE_TRANSIENT,  // NOLINT: a cast of SQLite's own
                                       SQLITE_UTF8);
  if (code != SQLITE_OK) database_->fail(code);
  return *this;
}

bool Statement::step() {
  const int code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  if (code != SQLITE_DONE) database_->fail(code);
  return false;
}

void Statement::reset() { sqlite3_reset(statement_.get()); }

/// SQLite keeps any kind of value in any column: no history has another kind, a negative whole number or infinity.
void Statement::require(bool good, int column) const {
  if (good) return;
  database_->fail(SQLITE_CORRUPT, fmt::format("{} is {}", sqlite3_column_name(statement_.get(), column), line(column)));
}

std::int64_t Statement::integer(int column) const {
  const std::int64_t number = sqlite3_column_int64(statement_.get(), column);
  require(sqlite3_column_type(statement_.get(), column) == SQLITE_INTEGER && number >= 0, column);
  return number;
}

double Statement::number(int column) const {
  const int type = sqlite3_column_type(statement_.get(), column);
  if (type == SQLITE_NULL) return std::numeric_limits<double>::quiet_NaN();
  const double number = sqlite3_column_double(statement_.get(), column);
  require((type == SQLITE_FLOAT || type == SQLITE_INTEGER) && std::isfinite(number), column);
  return number;
}

std::string Statement::text(int column) const {
  const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(statement_.get(), column));
  return bytes == nullptr
             ? std::string()
             : std::string(bytes, static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column)));
}

namespace {

constexpr int open_to_change = SQLITE_OPEN_READWRITE;

int look_at_interruption(void* /*unused*/) { return interruption_requested() ? 1 : 0; }

}  // namespace

/// SQLite keeps two files beside a database in WAL mode, and makes them even to read. Who may not write there reads
/// those of whoever is at work, or the database by itself, which nobody then changes.
int Database::open_to_read(sqlite3** handle) const {
  std::error_code none;
  const std::string log = file_.string() + "-wal", index = file_.string() + "-shm";
  if (::access(file_.c_str(), W_OK) == 0 && ::access(file_.parent_path().c_str(), W_OK) == 0) {
    return sqlite3_open_v2(file_.c_str(), handle, open_to_change, nullptr);
  }
  const bool at_work = std::filesystem::exists(index, none) && std::filesystem::file_size(log, none) > 0 && !none;
  if (at_work) return sqlite3_open_v2(file_.c_str(), handle, SQLITE_OPEN_READONLY, nullptr);
  if (std::filesystem::file_size(log, none) > 0 && !none) {
    throw EnvironmentError(
        "{}: its last nights stand in {} beside it, which cannot be read where nothing may be written; copy both to a "
        "folder of yours",
        file_.string(), std::filesystem::path(log).filename().string());
  }
  const std::string uri = "file://" + percent_encoded(std::filesystem::absolute(file_).string(), "?#%");
  return sqlite3_open_v2((uri + "?immutable=1").c_str(), handle, SQLITE_OPEN_READONLY | SQLITE_OPEN_URI, nullptr);
}

Database::Database(std::filesystem::path file, const std::string& schema, int version, DatabaseUse use)
    : file_(std::move(file)), use_(use), handle_(nullptr, sqlite3_close) {
  sqlite3* handle = nullptr;
  const int code =
      use == DatabaseUse::read
          ? open_to_read(&handle)
          : sqlite3_open_v2(file_.c_str(), &handle,
                            open_to_change | (use == DatabaseUse::create ? SQLITE_OPEN_CREATE : 0), nullptr);
  handle_.reset(handle);
  if (code != SQLITE_OK) fail(code);
  constexpr int patience_milliseconds = 10'000, steps_between_looks = 10'000;
  sqlite3_busy_timeout(handle, patience_milliseconds);
  sqlite3_progress_handler(handle, steps_between_looks, look_at_interruption, nullptr);
  // A file may come from elsewhere: nothing in it is run, and nothing writes past its tables.
  sqlite3_db_config(handle, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(handle, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  if (use == DatabaseUse::read) {
    run("PRAGMA query_only = ON");
    require_schema(schema, version);
    return;
  }
  run("PRAGMA journal_mode = WAL");
  run("PRAGMA synchronous = FULL");
  run("PRAGMA foreign_keys = ON");
  transaction([&] {
    Statement empty(*this, "SELECT count(*) FROM sqlite_master");
    empty.step();
    if (use == DatabaseUse::create && empty.integer(0) == 0) {
      run(schema);
      run(fmt::format("PRAGMA user_version = {}", version));
    }
    require_schema(schema, version);
  });
}

void Database::require_schema(const std::string& schema, int version) const {
  Statement ask(*this, "PRAGMA user_version");
  ask.step();
  if (const std::int64_t there = ask.integer(0); there == 0) {
    throw InputError("{}: this is no history, or an empty one; take it from a backup", file_.string());
  } else if (there != version) {
    throw InputError("{}: this history has version {} where {} is known; use the program that wrote it", file_.string(),
                     there, version);
  }
  if (schema.empty()) return;
  for (Statement rows(*this, "SELECT type, name, sql FROM sqlite_master"); rows.step();) {
    const bool own = rows.text(0) == "table" && schema.find(rows.text(2)) != std::string::npos;
    if (own || (rows.text(0) == "table" && rows.text(1).starts_with("sqlite_")) || rows.text(2).empty()) continue;
    throw InputError(
        "{}: this history holds the {} '{}', which no history has, so that what it tells may be made up; take it from "
        "a backup",
        file_.string(), single_line(rows.text(0)), single_line(rows.text(1)));
  }
}

void Database::run(const std::string& sql) const {
  const int code = sqlite3_exec(handle_.get(), sql.c_str(), nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) fail(code);
}

void Database::transaction(const std::function<void()>& work) const {
  run("BEGIN IMMEDIATE");
  try {
    work();
    run("COMMIT");
  } catch (...) {
    // What cannot be rolled back now is so by the next one who opens the file.
    sqlite3_exec(handle_.get(), "ROLLBACK", nullptr, nullptr, nullptr);
    throw;
  }
}

std::int64_t Database::last_row() const { return sqlite3_last_insert_rowid(handle_.get()); }

void Database::fail(int code, std::string said) const {
  if (said.empty()) said = single_line(handle_ ? sqlite3_errmsg(handle_.get()) : sqlite3_errstr(code));
  const int kind = code & 0xff;  // without what an extended code adds
  if (kind == SQLITE_INTERRUPT) throw_if_interrupted();
  if (kind == SQLITE_NOTADB || kind == SQLITE_CORRUPT || kind == SQLITE_ERROR) {
    throw InputError("{}: this is no history, or it is damaged ({}); take it from a backup, or begin another --history",
                     file_.string(), said);
  }
  if (kind == SQLITE_BUSY || kind == SQLITE_LOCKED) {
    throw BusyError("{}: another program has the history locked{}; wait for its end, and run again", file_.string(),
                    use_ == DatabaseUse::read ? "" : ", so that nothing can be kept");
  }
  if (use_ == DatabaseUse::read) {
    throw EnvironmentError(
        "{}: the history cannot be read ({}); give yourself the permission to read it and what lies beside it",
        file_.string(), said);
  }
  throw EnvironmentError(
      "{}: the history cannot be read or written ({}), so that nothing of this night is kept; free space or "
      "permission, and run again",
      file_.string(), said);
}

}  // namespace granuscope
