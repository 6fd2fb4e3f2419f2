#include "studies/numerical_stability.h"

#include <utility>

#include "model/audit.h"
#include "plot/plot.h"
#include "sampling/random_key.h"
#include "sampling/sampler.h"
#include "support/progress.h"

namespace granuscope {
namespace {
using TopLoads = std::vector<double>;

TopLoads even_load(int columns) { return TopLoads(static_cast<std::size_t>(columns), 1.0); }

TopLoads overloaded(int columns) {
  TopLoads load = even_load(columns);
  load[load.size() / 2] = 2;
  return load;
}

TopLoads half_unloaded(int columns) {
  TopLoads load = even_load(columns);
  std::fill(load.begin(), load.begin() + columns / 2, 0.0);
  return load;
}

/// 1e-5 to 1e5 in random order, both among them.
TopLoads ten_orders(int columns, std::uint64_t seed) {
  const RandomKey key(seed, 0);
  TopLoads load;
  for (int i = 0; i < columns; ++i) load.push_back(1e-5 * portable_power(1e10, key.attempt(0, i, 1).first));
  load[0] = 1e5;
  load[1] = 1e-5;
  return load;
}

/// Ranges of layers that double in length.
std::vector<ResidualAtDepth> by_depth(const std::vector<LayerResidual>& layers) {
  std::vector<ResidualAtDepth> depths;
  const int count = static_cast<int>(layers.size());
  for (int first = 0, next = 1; first < count; first = next, next = std::min(2 * next, count)) {
    ResidualAtDepth range{first, next - 1, 0};
    for (int layer = first; layer < next; ++layer) {
      const LayerResidual& one = layers[static_cast<std::size_t>(layer)];
      range.residual = std::max({range.residual, one.balance, one.cone});
    }
    depths.push_back(range);
  }
  return depths;
}

StabilityTrial attempt(double mu, LatticeSpec size, const std::string& name, const TopLoads& load, std::uint64_t seed) {
  throw_if_interrupted();
  StabilityTrial trial;
  trial.mu = mu;
  trial.columns = size.columns;
  trial.layers = size.layers;
  trial.load = name;
  const Lattice lattice(size);
  SamplerSpec spec;
  spec.mu = mu;
  spec.seed = seed;
  try {
    const auto sampler = make_sampler(spec, lattice);
    Pile pile(lattice);
    if (const auto failure = sampler->draw(0, load, pile)) {
      trial.outcome = "stuck";
      trial.reason =
          fmt::format("the effort of {} solutions per bead ran out at layer {}", spec.effort, failure->layer);
      return trial;
    }
    trial.depths = by_depth(audit_layers(pile));
    for (const ResidualAtDepth& range : trial.depths) trial.residual = std::max(trial.residual, range.residual);
    const SamplerCounts& counts = sampler->counts();
    trial.rounded_per_bead = static_cast<double>(counts.rounded) / static_cast<double>(counts.beads);
    trial.outcome = "solved";
  } catch (const InputError& refused) {
    trial.outcome = "refused";
    trial.reason = refused.what();
  }
  return trial;
}

constexpr const char* figure_id = "numerical-stability";

/// The number 1/sqrt(3) and those next to it all read 0.5774.
std::string friction_in_words(double mu) {
  if (mu == tan30) return "1/√3";
  if (mu == std::nextafter(tan30, 0.0)) return "1/√3, one number below";
  if (mu == std::nextafter(tan30, 1.0)) return "1/√3, one number above";
  return mu == 1e-9 ? "10⁻⁹" : caption_number(mu);
}

}  // namespace

std::vector<double> stability_friction() {
  return {1e-9, 1e-3, std::nextafter(tan30, 0.0), tan30, std::nextafter(tan30, 1.0), 1.7, 1.73};
}

std::vector<StabilityTrial> run_stability_trials(const StabilitySpec& spec, std::uint64_t seed) {
  std::vector<StabilityTrial> trials;
  if (spec.layers <= 0) return trials;
  for (const double mu : stability_friction()) {
    trials.push_back(attempt(mu, {spec.columns, spec.layers}, "one bead 2, others 1", overloaded(spec.columns), seed));
    trials.back().deep = true;
  }
  const LatticeSpec narrow{4, narrow_stability_layers}, uneven{spec.columns, uneven_stability_layers};
  for (const double mu : stability_friction()) {
    trials.push_back(attempt(mu, narrow, "one bead 2, others 1", overloaded(narrow.columns), seed));
    trials.push_back(attempt(mu, uneven, "ten orders of magnitude", ten_orders(uneven.columns, seed), seed));
    trials.push_back(attempt(mu, uneven, "half of the beads unloaded", half_unloaded(uneven.columns), seed));
  }
  return trials;
}

Figure plot_stability(const std::vector<StabilityTrial>& trials, const std::filesystem::path& run_folder) {
  Plot plot;
  plot.id = figure_id;
  plot.height = 3.4;
  plot.key = {.inches = 0.82, .lines = 3, .horizontal = true, .centred = true, .sample = 2, .entries = {}};
  Panel panel;
  panel.left = 0.125;
  panel.name = 0.02;
  std::vector<std::string> unsolved;
  Range layers, residuals;
  layers.add(1);
  double worst = 0;
  int columns = 0, deepest = 0;
  for (const StabilityTrial& trial : trials) {
    if (!trial.deep) continue;
    columns = trial.columns;
    deepest = std::max(deepest, trial.layers);
    if (trial.outcome != "solved") {
      unsolved.push_back(fmt::format("μ = {} ({})", friction_in_words(trial.mu), trial.reason));
      continue;
    }
    CsvTable table({"first_layer: layers", "last_layer: layers", "residual: dimensionless"});
    for (const ResidualAtDepth& range : trial.depths) {
      // A logarithmic axis has no place for layer 0, nor for what balances exactly.
      if (range.first_layer == 0 || !(range.residual > 0)) continue;
      table.add_row({static_cast<double>(range.first_layer), static_cast<double>(range.last_layer), range.residual});
      layers.add(range.first_layer);
      residuals.add(range.residual);
    }
    if (table.empty()) continue;
    worst = std::max(worst, trial.residual);
    const Style style = ink_of_series(panel.curves.size()).joined(0.8, 0.5);
    panel.add(plot.add_data(std::to_string(panel.curves.size() + 1), table), "1:3", style);
    plot.add_key("μ = " + friction_in_words(trial.mu), style);
  }
  if (panel.curves.empty()) {
    throw InputError(
        "the stability test has no residuals to show, because none of its deep piles was solved; give "
        "studies.numerical_stability.layers a smaller number");
  }
  panel.x = log_axis("layer, from here to twice as deep", widened_by_factor(layers, 1.3));
  panel.y = log_axis("largest relative residual", widened_by_factor(residuals, 2));
  plot.panels = {panel};
  return plot_figure(plot,
                     {"studies/numerical_stability.captions",
                      {{"columns", fmt::format("{}", columns)},
                       {"layers", fmt::format("{}", deepest)},
                       {"worst", significant(worst, 2)},
                       {"unsolved", enumeration(unsolved)}}},
                     run_folder);
}

void to_json(Json& json, const StabilityTrial& trial) {
  json = {{"mu", trial.mu},
          {"columns", trial.columns},
          {"layers", trial.layers},
          {"load", trial.load},
          {"outcome", trial.outcome}};
  if (trial.outcome != "solved") {
    json["reason"] = trial.reason;
    return;
  }
  json["residual"] = trial.residual;
  json["rounded_per_bead"] = trial.rounded_per_bead;
  json["depths"] = Json::array();
  for (const ResidualAtDepth& range : trial.depths) {
    json["depths"].push_back({{"layers", {range.first_layer, range.last_layer}}, {"residual", range.residual}});
  }
}

namespace {

constexpr double bytes_per_bead = 100;     // a deep pile is held as a whole
constexpr double seconds_per_bead = 2e-7;  // drawn by itself and audited, on one core of a cloud machine

class NumericalStabilityStudy final : public CopiedStudy<NumericalStabilityStudy> {
 public:
  explicit NumericalStabilityStudy(std::vector<StabilityTrial> measured) : trials_(std::move(measured)) {}
  std::string id() const override { return "numerical_stability"; }

  std::vector<Key> keys() override {
    return {make_key(table(), "layers", "layers",
                     "layers of the piles that strain the sampler: friction from 1e-9 to 1.73, with others on four "
                     "columns and under uneven loads beside them; 0: none",
                     spec_.layers, KeyRange{.or_zero = true}.within(2, most_layers)),
            make_key(table(), "columns", "beads", "beads per layer of these piles", spec_.columns,
                     KeyRange{}.within(4, most_columns))};
  }

  bool asked() const override { return spec_.layers > 0; }

  Problem find_problem(const MainLine&) const override {
    constexpr double most_beads = 2e7;
    if (beads() <= most_beads) return {};
    return problem(key("layers"),
                   "{} layers of {} beads: such a pile is held in memory as a whole; give at most {:g} beads, or 0 "
                   "layers to leave the study out",
                   spec_.layers, spec_.columns, most_beads);
  }

  double memory() const override { return bytes_per_bead * beads(); }
  double seconds() const override {
    return asked() ? seconds_per_bead * static_cast<double>(stability_friction().size()) * beads() : 0;
  }

  void finish() override { trials_ = run_stability_trials(spec_, main_.sampling.seed); }

  Json json() const override { return trials_; }

  std::vector<ReportPart> parts() const override { return {part(ReportPart::Place::numerics)}; }

  std::vector<FigurePlot> figures(const Analysis&) const override { return figures_of(trials_, plot_stability); }

 private:
  double beads() const { return static_cast<double>(spec_.layers) * spec_.columns; }

  StabilitySpec spec_;
  std::vector<StabilityTrial> trials_;  ///< the deep piles first, ascending in mu
};

}  // namespace

std::unique_ptr<Study> numerical_stability_study(std::vector<StabilityTrial> measured) {
  return std::make_unique<NumericalStabilityStudy>(std::move(measured));
}

}  // namespace granuscope
