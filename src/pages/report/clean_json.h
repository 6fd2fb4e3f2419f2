#pragma once
#include <nlohmann/json.hpp>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "analysis/jackknife.h"
#include "analysis/results.h"
#include "ensemble/ensemble_spec.h"
#include "model/audit.h"
#include "plot/figure_captions.h"
#include "render/render_pile.h"
#include "storage/ensemble_file.h"

namespace granuscope {
/// clean_text on every string value of the document, so that it can be written whatever bytes a user put in.
void clean_strings(Json& document);

/// The number, or null: NaN and infinity never appear in a file.
Json finite_or_null(double number);

/// The reason, or that none was recorded.
std::string stated(const std::string& reason);

/// {"value", "stderr"}, or nulls beside a "reason".
void to_json(Json& json, const Estimate& estimate);

/// {"layer", "z", "thrust_ratio", "weight_variance"}.
void to_json(Json& json, const ThrustAtDepth& depth);

/// {"chi2", "degrees_of_freedom", "points"}.
void to_json(Json& json, const LineTest& test);

/// The same with "probability" and the mean of each of flat_tests.
void to_json(nlohmann::ordered_json& json, const FlatTest& test);

/// {"at_low": {"value", "stderr", "at"}, "at_high", "about_law"}.
void to_json(Json& json, const RunningExponent& running);

/// {"estimator", "overload"}, or {"estimator": "multiplexed" or "fluctuation", and its options}.
void to_json(Json& json, const ResponseSpec& response);

inline constexpr int summary_schema = 5;  ///< of summary.json: goes up when a key of it changes

/// Throws InputError, which names `source`, where a summary is of another program's schema, whose keys may say
/// something else.
void require_known_schema(const Json& summary, const std::string& source);

/// What `granuscope sample --statistics` measures on one layer.
struct LayerStatistics {
  int layer = 0;
  Estimate alpha;            ///< thrust ratio of the contacts leaving the layer
  Estimate weight_variance;  ///< of the weights entering its beads, about the known mean 1
  /// Of the contacts leaving it, where they were asked for: by name.
  std::vector<std::pair<std::string, Estimate>> forces = {};
};

/// What `granuscope sample --statistics` prints.
struct SampleStatistics {
  std::string law;
  double mu = 0;
  int columns = 0, layers = 0;
  std::uint64_t samples = 0;  ///< piles that entered the averages
  SamplerCounts counts;
  Estimate effective_samples;               ///< as many independent piles would have given the same standard errors
  double lambda = 1;                        ///< polytope only
  std::uint64_t burn_in = 0, thinning = 0;  ///< polytope only, sweeps
  double seconds = 0;                       ///< wall time of the sampling
  std::vector<LayerStatistics> per_layer;
  AuditResult audit;  ///< worst over the audited piles; not a number if none of them was completed
};

/// What `granuscope doctor` looked at, what it found, and the Debian package that brings it if it is missing.
struct Finding {
  std::string subject;
  std::string text;
  bool good = true;
  std::string package = {};  ///< empty: no package would help
};

/// One JSON object with a final newline. Unknown numbers are null beside a "reason".
std::string findings_json(const std::vector<Finding>& findings);
std::string audit_json(const Pile& pile, const AuditResult& audit, double tolerance);
std::string sample_statistics_json(const SampleStatistics& statistics);
std::string render_statistics_json(const SceneStatistics& statistics);

}  // namespace granuscope
