#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "history/night_book.h"

namespace granuscope {
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
