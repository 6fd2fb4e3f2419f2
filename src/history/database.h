#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

struct sqlite3;
struct sqlite3_stmt;

namespace granuscope {

class Database;

/// A prepared SQL statement. Parameters are counted from 1, columns from 0.
class Statement {
 public:
  Statement(const Database& database, const std::string& sql);

  Statement& bind(int parameter, std::int64_t value);
  Statement& bind(int parameter, double value);  ///< not finite: NULL
  Statement& bind(int parameter, const std::string& value);

  /// Whether there is a row (another one).
  bool step();
  /// For a statement without rows: runs it, and makes it ready for the next binding.
  void run();

  std::int64_t integer(int column) const;
  double number(int column) const;  ///< NULL: NaN
  std::string text(int column) const;

 private:
  const Database* database_;
  std::unique_ptr<sqlite3_stmt, int (*)(sqlite3_stmt*)> statement_;
};

/// An SQLite file in WAL mode with foreign keys, which a kill or a full disk leaves as it was before the transaction.
/// Errors are EnvironmentError naming the file, for a file that is no database InputError.
class Database {
 public:
  /// Opens or makes it. `schema` makes the tables of a new one; its version stands in PRAGMA user_version, and a file
  /// of another version is refused.
  Database(std::filesystem::path file, const std::string& schema, int version);

  void run(const std::string& sql) const;
  /// All of `work` or nothing.
  void transaction(const std::function<void()>& work) const;
  std::int64_t last_row() const;

 private:
  friend class Statement;
  [[noreturn]] void fail(int code) const;

  std::filesystem::path file_;
  std::unique_ptr<sqlite3, int (*)(sqlite3*)> handle_;
};

}  // namespace granuscope
