#include "studies/study.h"

#include "studies/dilution.h"
#include "studies/law_comparison.h"
#include "studies/mode_coupling/fields.h"
#include "studies/model_classes/results.h"
#include "studies/nonlinearity.h"
#include "studies/numerical_stability.h"
#include "studies/small_friction.h"
#include "studies/spreading.h"
#include "studies/thrust_studies.h"
#include "studies/work_studies.h"

namespace granuscope {

// A study of one file has no header.
// NOLINTBEGIN(readability-redundant-declaration): where pieces are joined
std::unique_ptr<Study> literal_reading_study();
std::unique_ptr<Study> open_choices_study();
std::unique_ptr<Study> force_statistics_study();
std::unique_ptr<Study> tensor_response_study();
std::unique_ptr<Study> contact_angle_study();
// NOLINTEND(readability-redundant-declaration)

Studies::Studies() {
  all_.push_back(literal_reading_study());
  all_.push_back(open_choices_study());
  all_.push_back(redrawn_beads_study());
  all_.push_back(counted_work_study());
  all_.push_back(small_friction_study());
  all_.push_back(deep_response_study());
  all_.push_back(mode_coupling_study());
  all_.push_back(chain_share_study());
  all_.push_back(force_statistics_study());
  all_.push_back(tensor_response_study());
  all_.push_back(contact_angle_study());
  all_.push_back(numerical_stability_study());
  all_.push_back(error_against_time_study());
  all_.push_back(nonlinearity_study());
  all_.push_back(law_comparison_study());
  all_.push_back(rejection_thrust_study());
  all_.push_back(models_study());
  all_.push_back(dilution_study());
}

Studies::Studies(const Studies& other) {
  for (const auto& study : other.all_) all_.push_back(study->clone());
}

Studies& Studies::operator=(const Studies& other) {
  if (this != &other) *this = Studies(other);
  return *this;
}

void Study::derive(MainLine& main, const IsOpen& open) {
  const auto least = static_cast<std::int64_t>(group_size) * main.response.blocks;
  for (const Key& key : keys()) {
    if (!key.name.ends_with("samples")) continue;
    if (const auto found = find_problem(main); !found || found->key != key.path()) continue;
    const KeyValue value = key.get();
    const auto* const written = std::get_if<std::int64_t>(&value);
    int& blocks = main.response.blocks;
    if (open(key.path())) {
      key.set(least);
    } else if (written != nullptr && open("response.blocks")) {
      blocks = std::clamp(static_cast<int>(std::min<std::int64_t>(*written / std::int64_t{group_size}, blocks)),
                          min_blocks, blocks);
    }
  }
}

Json enumerated(const std::vector<std::string>& pointers) {
  Json places = Json::array();
  for (std::size_t i = 0; i < pointers.size(); ++i) {
    const std::size_t left = pointers.size() - 1 - i;
    places.push_back({{"key", pointers[i]}, {"joint", left > 1 ? ", " : left == 1 ? " and " : ""}});
  }
  return places;
}

std::vector<StudyEnsemble> Studies::ensembles(const MainLine& main) const {
  std::vector<StudyEnsemble> ensembles;
  for (const auto& study : all_) {
    if (!study->asked()) continue;
    for (StudyEnsemble& one : study->ensembles(main)) ensembles.push_back(std::move(one));
  }
  return ensembles;
}

const ScanParameter& MainLine::scanned() const {
  return scan.parameter.empty() ? usual_parameter(sampling) : scan_parameter_named(scan.parameter, sampling);
}

std::vector<double> MainLine::scan_values() const {
  if (!scan.values.empty()) return scan.values;
  if (&scanned() == &friction_parameter()) return mu;
  return {scanned().value(sampling)};
}

double MainLine::shown_value(double wanted) const {
  const std::vector<double> values = scan_values();
  const bool has_it = std::ranges::find(values, wanted) != values.end();
  return has_it || &scanned() == &friction_parameter() ? wanted : values.back();
}

SamplerSpec MainLine::sampler_at(double value) const {
  SamplerSpec spec = sampling;
  if (spec.model.has_contacts()) spec.mu = mu.front();
  scanned().in(spec) = value;
  return spec;
}

EnsembleSpec MainLine::ensemble_at(double friction, LatticeSpec size, std::uint64_t samples) const {
  EnsembleSpec spec;
  spec.sampler = sampler_for(friction);
  spec.lattice = size;
  spec.response.overload = response.overload;
  spec.response.blocks = response.blocks;
  spec.response.samples = samples;
  return spec;
}

EnsembleSpec MainLine::uniform_piles(Law law, double friction, LatticeSpec size, std::uint64_t samples) const {
  EnsembleSpec spec = ensemble_at(friction, size, samples);
  spec.sampler = {};
  spec.sampler.mu = friction;
  spec.sampler.seed = sampling.seed;
  spec.sampler.law = law;
  spec.load = Load::uniform;
  spec.record_profiles = false;
  return spec;
}

KeyRange friction_range() {
  return KeyRange{.ascending = true,
                  .why =
                      "below 0 friction means nothing, at sqrt(3) = 1.7320 the cone reaches the horizontal, and 0.3 "
                      "has a point, no comma"}
      .within(0, mu_limit)
      .below(mu_limit);
}

KeyRange friction_range_above_zero() {
  KeyRange range = friction_range();
  range.why =
      "at 0 nothing is random, so that there is nothing to measure here, and at sqrt(3) = 1.7320 the cone reaches the "
      "horizontal";
  return std::move(range).above(0);
}

double pile_memory(double columns, double layers) {
  const double numbers_per_bead = 4 + 8;  // a pile's forces, and what a solver keeps beside them
  return 8 * numbers_per_bead * columns * layers;
}

Problem find_lattice_problem(const std::string& columns_key, int columns, const std::string& layers_key, int layers,
                             int least_layers, double memory) {
  if (columns < fewest_columns) {
    return problem(columns_key,
                   "{} too few: on a ring of fewer than 4 a bead meets its neighbour twice; give at least 4",
                   how_many(columns, "column is", "columns are"));
  }
  if (layers < least_layers) {
    return problem(layers_key, "{} too few; give at least {}", how_many(layers, "layer is", "layers are"),
                   least_layers);
  }
  const bool wide = columns > layers;
  if (memory > most_memory) {
    return problem(wide ? columns_key : layers_key,
                   "{} x {} beads would need about {} of memory, more than {}; make the pile smaller", columns, layers,
                   describe_bytes(memory), describe_bytes(most_memory));
  }
  if (columns > most_columns || layers > most_layers) {
    return problem(wide ? columns_key : layers_key,
                   "{} x {} beads are more than {} {}, of which a slip of the keyboard is the likelier cause (they "
                   "would need about {} of memory); make the pile smaller",
                   columns, layers, wide ? most_columns : most_layers, wide ? "columns" : "layers",
                   describe_bytes(memory));
  }
  return {};
}

Problem find_samples_problem(const std::string& key, std::uint64_t samples, int blocks) {
  const auto least = group_size * static_cast<std::uint64_t>(blocks);
  if (samples >= least && samples <= most_samples) return {};
  return problem(key, "{} in {} blocks: each block needs a whole group of eight; give {} to {}",
                 how_many(samples, "sample"), blocks, least, most_samples);
}

Problem find_check_problem(const std::string& key, const std::vector<double>& checked, const std::string& measured_key,
                           const std::vector<double>& measured) {
  for (const double mu : checked) {
    if (std::ranges::find(measured, mu) != measured.end()) continue;
    return problem(key, "{} is not in {}, so that nothing would be there to hold it against; add it there", mu,
                   measured_key);
  }
  return {};
}

}  // namespace granuscope
