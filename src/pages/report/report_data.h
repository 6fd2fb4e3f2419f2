#pragma once
#include <nlohmann/json.hpp>

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "analysis/results.h"
#include "plot/figure_captions.h"
#include "support/provenance.h"

namespace granuscope {
/// A piece of the report about one measurement, written from its numbers in summary.json.
struct ReportPart {
  /// Where in the report: on page 1, where the experiment is about this study, among the numbers that matter, or under
  /// Numerics.
  enum class Place { page_1, numbers, numerics };

  /// Its template below templates/, as "studies/<id>.html" or "….table" (report/page_scope.h).
  std::string page;
  std::string base;   ///< JSON pointer into summary.json: the place that the names of the page are relative to
  std::string needs;  ///< a name in that place: the part is left out if nothing is there
  Place place = Place::numbers;
  Json overlay = Json::object();  ///< what is not in summary.json, from base on
};

/// A stage's wall time, for timings.json, manifest.json and the report's section of timings.
struct StageTiming {
  std::string stage;
  double seconds = 0;       ///< what computing it took, in an earlier run if it is reused; NaN if that is not known
  bool reused = false;      ///< the result was already there
  std::uint64_t beads = 0;  ///< drawn in that time, of a stage that draws an ensemble
};

/// Everything the report says. Nothing here is computed by the report itself.
struct ReportData {
  std::string experiment_name;     ///< as given by the user; untrusted text
  std::string description;         ///< one paragraph from the experiment file, may be empty; untrusted text
  std::string headline;            ///< of page 1, in place of the generated sentences; may be empty; untrusted text
  std::string key_figure;          ///< id of the figure of page 1; empty: none
  std::string changed_experiment;  ///< what of the TOML text differs from the defaults
  int columns = 0, layers = 0;
  std::uint64_t seed = 0;
  double overload = 1;
  std::string resolved_experiment;           ///< the TOML text with every default resolved
  std::string resolved_experiment_key;       ///< its cache_key
  std::vector<std::string> law_description;  ///< the choices that shape the law, one sentence each
  /// The same for the other laws that the run compares with it, each with its name.
  std::vector<std::pair<std::string, std::vector<std::string>>> other_law_descriptions;
  Analysis analysis;
  Json studies = Json::object();  ///< their results: "studies" of summary.json, by id
  std::vector<Figure> figures;    ///< in reading order
  std::vector<ReportPart> parts;  ///< in reading order of each place
  Provenance provenance;
  std::string started;                                           ///< when this run began, as current_time() tells it
  std::vector<std::pair<std::string, std::string>> environment;  ///< GL renderer, gnuplot, WeasyPrint versions
  std::vector<StageTiming> timings;
  std::vector<std::string> checks;   ///< sentences: what was checked on the way, and how it came out
  std::vector<std::string> skipped;  ///< sentences: what was not done and why
  std::string reuse = {};            ///< one sentence, of this run alone: what was there already; may be empty
};

/// The name of the experiment, or that it has none.
inline std::string title_of(const ReportData& data) {
  return data.experiment_name.empty() ? "untitled experiment" : data.experiment_name;
}

}  // namespace granuscope
