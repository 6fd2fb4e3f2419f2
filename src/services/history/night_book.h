#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "history/comparison.h"
#include "support/plain_text.h"

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
  /// For a statement without rows: runs it with these parameters, and makes it ready for the next ones.
  template <class... Values>
  void run(const Values&... values) {
    int parameter = 0;
    (bind(++parameter, values), ...);
    step();
    reset();
  }

  std::int64_t integer(int column) const;
  double number(int column) const;  ///< NULL: NaN
  std::string text(int column) const;
  std::string line(int column) const { return single_line(text(column)); }  ///< a file may come from elsewhere

 private:
  void reset();
  void require(bool good, int column) const;

  const Database* database_;
  std::unique_ptr<sqlite3_stmt, int (*)(sqlite3_stmt*)> statement_;
};

/// What a database is opened for. To be read it may lie where nothing can be written, or belong to somebody else.
enum class DatabaseUse { create, change, read };

/// An SQLite file in WAL mode with foreign keys, which a kill or a full disk leaves as it was before the transaction.
/// Errors are EnvironmentError naming the file, for a file that is no such database InputError, BusyError while
/// somebody else has it locked, Interrupted.
class Database {
 public:
  /// Opens it, or makes it where that is asked for. `schema` makes the tables of a new one; its version stands in
  /// PRAGMA user_version, and a file of another version, or with anything that the schema does not make, is refused.
  Database(std::filesystem::path file, const std::string& schema, int version, DatabaseUse use = DatabaseUse::create);

  void run(const std::string& sql) const;
  /// All of `work` or nothing.
  void transaction(const std::function<void()>& work) const;
  std::int64_t last_row() const;

 private:
  friend class Statement;
  [[noreturn]] void fail(int code, std::string said = "") const;
  int open_to_read(sqlite3** handle) const;
  void require_schema(const std::string& schema, int version) const;

  std::filesystem::path file_;
  DatabaseUse use_;
  std::unique_ptr<sqlite3, int (*)(sqlite3*)> handle_;
};

/// A primary number of one night: of the pool with the night's piece in it, and of the piece against the pool before.
struct NightNumber {
  std::string name;
  KnownNumber pool;
  double piece = 0, piece_error = 0, z = 0;  ///< NaN where the piece has none, or there was no pool
  bool moved = false;
};

struct NightVerdict {
  std::string claim, verdict;
  double z = 0;  ///< NaN where no number decides
};

/// What is wrong in a night, and what became of it.
struct Alarm {
  std::string kind;   ///< "canary", "experiment", "failed pile", "identity", "broken", "damaged", "report", "number",
                      ///< "verdict"
  std::string what;   ///< a sentence
  std::string state;  ///< "open", "watched" (of one night only so far, and told to nobody), "accepted", or "passed":
                      ///< it was open, and a later night was fine
};

/// The kind of an alarm that says nothing against the numbers: the machine did not let a part of the report be made.
inline constexpr const char* lacking = "report";

struct Night {
  std::int64_t number = 0;    ///< from 1
  std::string date;           ///< when it began, UTC
  std::string report;         ///< its folder in reports/
  std::string status;         ///< "fine" or "alarm"
  std::uint64_t samples = 0;  ///< piles in the pool after it, at each friction coefficient
  std::string experiment;     ///< resolved
  std::map<std::string, std::string> environment;
  std::map<std::string, double> seconds;  ///< by stage
  std::vector<NightNumber> numbers;
  std::vector<NightVerdict> verdicts;
  std::vector<Alarm> alarms;
};

/// The history of nights: DIR/history.sqlite.
class NightBook {
 public:
  explicit NightBook(const std::filesystem::path& folder, DatabaseUse use = DatabaseUse::create);

  /// In one transaction with what the next night goes on from. Returns its number.
  std::int64_t add(const Night& night, const std::map<std::string, std::string>& state);
  /// The last nights, oldest first; 0: all.
  std::vector<Night> last(std::size_t how_many) const;
  /// Throws InputError if there is none.
  Night night(std::int64_t number) const;
  std::int64_t count() const;
  /// Names of the last reports.
  std::set<std::string> last_reports(std::size_t how_many) const;
  void forget(std::int64_t number);
  /// Its alarms are accepted, and the next night goes on from this state.
  void accept(std::int64_t number, const std::map<std::string, std::string>& state);

  /// What the next night goes on from, by name; "" if it is not there.
  std::string state(const std::string& name) const;
  void keep(const std::map<std::string, std::string>& state);

 private:
  void keep_state(const std::map<std::string, std::string>& state) const;
  Night read(Statement& row) const;

  Database database_;
};

/// DIR/index.html (the trend of each primary number, run times, nights with links to their reports), badge.json (an
/// endpoint of shields.io), alert.md (there only while the last night alarms) and latest, a link to the last report.
/// Where no night is left, none of the first three.
void write_pages(const std::filesystem::path& folder, const NightBook& book);

/// The badge of a history that could not be used tonight is not green. Nothing where there is none of its own.
void tell_not_run(const std::filesystem::path& folder);

/// Removes reports older than the last `keep` ones, and what a killed night left.
void prune_reports(const std::filesystem::path& folder, const NightBook& book, std::size_t keep);

/// "3 2026-01-31 fine, 8192 samples" and its alarms, for a list.
std::string describe(const Night& night);

/// One night as tables for a terminal: its numbers and verdicts.
std::string table_text(const Night& night);

/// One night or all of them as JSON, or a table of primary numbers as CSV (night, date, status, samples, name, ...).
std::string json_text(const std::vector<Night>& nights);
std::string csv_text(const std::vector<Night>& nights);

}  // namespace granuscope
