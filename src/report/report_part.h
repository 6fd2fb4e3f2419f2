#pragma once
#include <nlohmann/json.hpp>
#include <string>

namespace granuscope {

/// A piece of the report about one measurement, written from its numbers in summary.json.
struct ReportPart {
  /// Where in the report: on page 1, where the experiment is about this study, among the numbers that matter, or under
  /// Numerics.
  enum class Place { page_1, numbers, numerics };

  /// Its template below templates/, as "studies/<id>.html" (report/page_scope.h) or "….table" (report/page_table.h).
  std::string page;
  std::string base;   ///< JSON pointer into summary.json: the place that the names of the page are relative to
  std::string needs;  ///< a name in that place: the part is left out if nothing is there
  Place place = Place::numbers;
  nlohmann::ordered_json overlay = nlohmann::ordered_json::object();  ///< what is not in summary.json, from base on
};

}  // namespace granuscope
