#include "history/database.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <cmath>
#include <limits>
#include <utility>

#include "support/error.h"
#include "support/single_line.h"

namespace granuscope {

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

void Statement::run() {
  step();
  sqlite3_reset(statement_.get());
}

std::int64_t Statement::integer(int column) const { return sqlite3_column_int64(statement_.get(), column); }

double Statement::number(int column) const {
  if (sqlite3_column_type(statement_.get(), column) == SQLITE_NULL) return std::numeric_limits<double>::quiet_NaN();
  return sqlite3_column_double(statement_.get(), column);
}

std::string Statement::text(int column) const {
  const auto* bytes = reinterpret_cast<const char*>(sqlite3_column_text(statement_.get(), column));
  return bytes == nullptr
             ? std::string()
             : std::string(bytes, static_cast<std::size_t>(sqlite3_column_bytes(statement_.get(), column)));
}

Database::Database(std::filesystem::path file, const std::string& schema, int version)
    : file_(std::move(file)), handle_(nullptr, sqlite3_close) {
  sqlite3* handle = nullptr;
  const int code = sqlite3_open_v2(file_.c_str(), &handle, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, nullptr);
  handle_.reset(handle);
  if (code != SQLITE_OK) fail(code);
  constexpr int patience_milliseconds = 10'000;
  sqlite3_busy_timeout(handle, patience_milliseconds);
  run("PRAGMA journal_mode = WAL");
  run("PRAGMA synchronous = FULL");
  run("PRAGMA foreign_keys = ON");
  transaction([&] {
    Statement ask(*this, "PRAGMA user_version");
    ask.step();
    const std::int64_t there = ask.integer(0);
    if (there == 0) {
      run(schema);
      run(fmt::format("PRAGMA user_version = {}", version));
    } else if (there != version) {
      throw InputError(fmt::format("{}: this history has version {} where {} is known; use the program that wrote it",
                                   file_.string(), there, version));
    }
  });
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

void Database::fail(int code) const {
  const std::string said = single_line(handle_ ? sqlite3_errmsg(handle_.get()) : sqlite3_errstr(code));
  if (code == SQLITE_NOTADB || code == SQLITE_CORRUPT) {
    throw InputError(
        fmt::format("{}: this is no history, or it is damaged ({}); take it from a backup, or move it away "
                    "to begin a new one",
                    file_.string(), said));
  }
  throw EnvironmentError(
      fmt::format("{}: the history cannot be read or written ({}), so that nothing of this night is "
                  "kept; free space or permission, and run again",
                  file_.string(), said));
}

}  // namespace granuscope
