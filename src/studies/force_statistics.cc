// How the forces of uniformly loaded piles are distributed: contact forces, mobilised friction and weights by depth,
// with the shape of their tails, beside the q-model, whose weights are known (Coppersmith et al., Phys. Rev. E 53, 4673
// (1996)).
#include <numbers>
#include <numeric>

#include "analysis/force_bands.h"
#include "analysis/jackknife.h"
#include "ensemble/estimator.h"
#include "plot/growing_panel.h"
#include "studies/study.h"

namespace granuscope {
/// By itself, for the names of the bins.
namespace force_distributions {
namespace {

using namespace force_bins;
using Numbers = std::vector<double>;

/// Of the points that a tail is fitted through: their joint covariance comes from blocks, at least twice as many.
constexpr std::size_t most_points = 10, fewest_points = 4;
/// In the last of them: its logarithm is then normally distributed well enough.
constexpr double least_count = 200;
/// A form is refused where chance alone would give such a chi^2 in less than one of a thousand cases.
constexpr double refusal = 1e-3;
/// Powers k that a stretched exponential is looked for between.
constexpr double least_power = 0.2, most_power = 6;

/// The groups of bins that a tail is fitted through.
struct TailGroups {
  std::size_t first = 0, points = 0, bins = 0;

  /// Where group `g` begins, or at g + 1/2 its middle, in mean weights.
  double at(double g) const { return (static_cast<double>(first) + g * static_cast<double>(bins)) / per_unit; }
};

/// From the value on that a share of all exceeds, to where a group still holds enough. The last bin is open and has no
/// place. Without points where there are too few bins.
TailGroups tail_groups(const double* counts, std::size_t blocks, double share) {
  const double all = std::accumulate(counts, counts + values, 0.0);
  std::size_t first = values - 1;
  for (double above = counts[first]; first > 0 && above + counts[first - 1] <= share * all;) above += counts[--first];
  for (std::size_t points = std::min(most_points, blocks / 2); points >= fewest_points; --points) {
    for (std::size_t bins = (values - 1 - first) / points; bins > 0; --bins) {
      const double* const last = counts + first + (points - 1) * bins;
      if (std::accumulate(last, last + bins, 0.0) >= least_count) return {first, points, bins};
    }
  }
  return {};
}

/// ln P in the middle of each group, of x = force over its mean. A mean over a group lies above that by the factor
/// sinh(a)/a, 2 a being the change of ln P over it.
Numbers log_densities(const Numbers& sums, const CountedForce& force, const TailGroups& groups) {
  const double unit = mean_of_force(sums, force) / (force.per_bead * sums[beads_at] * (groups.at(1) - groups.at(0)));
  Numbers logs;
  for (std::size_t g = 0; g < groups.points; ++g) {
    const double* const from = &sums[force.histogram + groups.first + g * groups.bins];
    logs.push_back(std::log(unit * std::accumulate(from, from + groups.bins, 0.0)));
  }
  Numbers middle;
  for (std::size_t g = 0; g < logs.size(); ++g) {
    const std::size_t before = g == 0 ? 0 : g - 1, after = std::min(g + 1, logs.size() - 1);
    const double a = (logs[after] - logs[before]) / (2 * static_cast<double>(after - before));
    middle.push_back(logs[g] - (a == 0 ? 0 : std::log(std::sinh(a) / a)));
  }
  return middle;
}

/// Points of a tail: x, and ln P with its replicates, whose covariance weighs them.
struct TailPoints {
  Numbers x;
  std::vector<Replicated> y;

  Numbers powers(double k) const {
    Numbers all;
    for (const double one : x) all.push_back(std::pow(one, k));
    return all;
  }
  LineTest test(double k) const { return test_line(powers(k), y); }
  /// ln P = intercept - (x/x0)^k, by the scatter of each point.
  Line line(double k) const {
    Numbers values, inverse_variances;
    for (const Replicated& one : y) {
      values.push_back(one.value);
      inverse_variances.push_back(1 / std::pow(estimate(one).standard_error, 2));
    }
    return fit_line(powers(k), values, inverse_variances);
  }
  double scale(double k) const { return std::pow(-line(k).slope, -1 / k); }
  /// The power with the least chi^2, on ever finer grids; not a number where that is at an end.
  double best_power() const {
    constexpr int grids = 8, around = 4;
    double best = least_power, least = test(best).chi2, step = 0.2, low = least_power;
    int points = static_cast<int>((most_power - least_power) / step) + 1;
    for (int grid = 0; grid < grids; ++grid) {
      for (int i = 0; i < points; ++i) {
        const double k = low + i * step;
        if (const double found = test(k).chi2; found < least) least = found, best = k;
      }
      step /= around;
      low = best - around * step;
      points = 2 * around + 1;
    }
    return best - least_power > 0.1 && most_power - best > 0.1 ? best : std::nan("");
  }
  /// As they are without a block, with the covariance of all.
  TailPoints without(std::size_t b) const {
    TailPoints rest = *this;
    for (Replicated& one : rest.y) one.value = one.without_block[b];
    return rest;
  }
};

/// chi^2 of P ~ exp(-(x/x0)^k) with its chance, that of T^2 of Hotelling as test_line scales it, x0 and k. `fitted`: k
/// was, else it is exact.
Json form_json(const TailPoints& points, const Replicated& k, bool fitted) {
  const std::size_t blocks = k.without_block.size();
  LineTest test = points.test(std::isfinite(k.value) ? k.value : 1);
  if (!std::isfinite(k.value)) test = {.reason = "no power from 0.2 to 6 has the least chi^2"};
  if (fitted && test.reason.empty()) --test.degrees_of_freedom;
  const double chance = chance_of(test, blocks);
  Replicated scale{points.scale(k.value), {}};
  for (std::size_t b = 0; b < blocks; ++b) scale.without_block.push_back(points.without(b).scale(k.without_block[b]));
  Json json = test;
  json.update({{"probability", finite_or_null(chance)},
               {"refused", chance < refusal},
               {"scale", estimate(scale, "the density does not fall by this form")}});
  if (fitted) json["power"] = estimate(k, "no power from 0.2 to 6 has the least chi^2");
  return json;
}

/// The three forms of a tail: {"from", "to", "points", "exponential", "Gaussian", "stretched", "refused"}, or a reason.
/// `curve`: the stretched one.
Json fit_tail(const std::vector<Numbers>& blocks, const CountedForce& force, double share, CurveRows& curve) {
  Numbers counts(values);
  for (const Numbers& block : blocks) {
    for (std::size_t i = 0; i < counts.size(); ++i) counts[i] += block[force.histogram + i];
  }
  const TailGroups groups = tail_groups(counts.data(), blocks.size(), share);
  if (groups.points == 0)
    return {{"reason", "its bins are too few, or hold too few forces; give more piles or a deeper band"}};
  TailPoints points;
  points.y = replicated(blocks, [&](const Numbers& sums) { return log_densities(sums, force, groups); });
  const double mean =
      replicated(blocks, [&](const Numbers& sums) { return Numbers{mean_of_force(sums, force)}; })[0].value;
  for (std::size_t g = 0; g < groups.points; ++g) points.x.push_back(groups.at(static_cast<double>(g) + 0.5) / mean);
  Replicated power{points.best_power(), {}};
  for (std::size_t b = 0; b < blocks.size(); ++b) power.without_block.push_back(points.without(b).best_power());
  const double from = groups.at(0) / mean, to = groups.at(static_cast<double>(groups.points)) / mean;
  const auto exact_power = [&](double k) { return Replicated{k, Numbers(blocks.size(), k)}; };
  Json json = {{"from", from},
               {"to", to},
               {"points", groups.points},
               {"exponential", form_json(points, exact_power(1), false)},
               {"Gaussian", form_json(points, exact_power(2), false)},
               {"stretched", form_json(points, power, true)}};
  Json refused = Json::array();
  for (const char* form : {"exponential", "Gaussian", "stretched"}) {
    if (json[form]["refused"]) refused.push_back(form);
  }
  json["refused"] = refused;
  const Line line = std::isfinite(power.value) ? points.line(power.value) : Line{};
  for (int i = 0; i <= 60 && line.slope < 0; ++i) {
    const double x = from + (to - from) * i / 60;
    curve.push_back({x, std::exp(line.intercept + line.slope * std::pow(x, power.value)), 0});
  }
  return json;
}

/// What is measured in one band of layers.
struct Band {
  Json numbers, tails = Json::array();
  std::vector<ForceSums> blocks;
  CurveRows tail_N;  ///< its stretched exponential
};

/// Of a model without contacts the weights alone. `name`: of its piles.
Band measure_band(const std::vector<Numbers>& blocks, bool contacts, double share, const Json& name) {
  Band band{.numbers = name, .blocks = blocks, .tail_N = {}};
  CurveRows unused;
  const auto add = [&](const CountedForce& force, const std::string& key, CurveRows& curve) {
    const auto moments = replicated(blocks, [&](const Numbers& sums) { return moments_of(sums, force); });
    band.numbers[key + "_mean"] = estimate(moments[0]);
    band.numbers[key + "_variance"] = estimate(moments[1]);
    band.numbers[key + "_skewness"] = estimate(moments[2]);
    Json tail = name;
    tail["force"] = force.symbol;
    tail.update(fit_tail(blocks, force, share, curve));
    band.tails.push_back(std::move(tail));
  };
  add(weights, "weight", unused);
  if (contacts) {
    add(normals, "normal", band.tail_N);
    const auto friction = replicated(blocks, mobilisation_of);
    band.numbers["mobilisation"] = estimate(friction[0]);
    band.numbers["sliding"] = estimate(friction[1]);
  }
  return band;
}

struct ForceStatistics {
  EnsembleSpec spec;
  Json name;                ///< "pile": "μ = 0.1" or "q-model"; columns, samples
  std::vector<Band> bands;  ///< from the top down
  bool has_contacts() const { return spec.sampler.model.has_contacts(); }
  std::string file_part() const { return has_contacts() ? "mu-" + exact(spec.sampler.mu) : "q-model"; }
};

/// The files beside the figure: P(w) of all bands, and of the deepest one the map of N and T/(mu N).
void add_tables(Plot& plot, const ForceStatistics& one) {
  CsvTable w({"first_layer: layers", "w: mean weights", "density: dimensionless", "standard_error: dimensionless"});
  for (const Band& band : one.bands) {
    for (const auto& [x, P, error] : density_of(band.blocks, weights))
      w.add_row({band.numbers["first_layer"].get<double>(), x, P, error});
  }
  plot.add_data(one.file_part() + "-weights", w);
  if (!one.has_contacts()) return;
  CsvTable joint({"N: mean weights", "T_over_mu_N: dimensionless", "angle_from_vertical: degrees",
                  "density: per mean weight and unit of T_over_mu_N"});
  const std::vector<Estimate> counts = counts_per_bead(one.bands.back().blocks);
  for (std::size_t i = 0; i < (map_normals - 1) * map_mobilisations; ++i) {  // the last row of N is open
    const std::size_t row = i / map_mobilisations, column = i % map_mobilisations;
    const double N = (static_cast<double>(row) + 0.5) / map_per_unit;
    const double mobilised_by = (2 * static_cast<double>(column) + 1) / map_mobilisations - 1;
    const double angle =
        one.spec.lattice.angle + std::atan(one.spec.sampler.mu * mobilised_by) * 180 / std::numbers::pi;
    joint.add_row({N, mobilised_by, angle, counts[map + i].value / 4 * map_per_unit * map_mobilisations});
  }
  plot.add_data(one.file_part() + "-map", joint);
}

Figure plot_force_statistics(const std::vector<ForceStatistics>& measured, const std::filesystem::path& run_folder) {
  Plot plot = two_panels("force-statistics");
  GrowingPanel forces{"N/⟨N⟩", "P(N/⟨N⟩)", true}, friction{"mobilised friction |T|/(μN)", "P(|T|/(μN))"};
  const std::string x = "N_over_mean: dimensionless", P = "density: dimensionless";
  friction.y.add(0);
  std::vector<std::string> sliding, powers;
  const auto told = [](const Json& number, const ForceStatistics& of) {
    return fmt::format("{} ({})", value_with_error(number["value"], number["stderr"]),
                       of.name["pile"].get<std::string>());
  };
  for (const ForceStatistics& one : measured) {
    add_tables(plot, one);
    if (!one.has_contacts()) continue;
    const Band& band = one.bands.back();
    const Ink ink = ink_of_value(sliding.size());
    forces.add(plot, one.file_part() + "-forces", density_of(band.blocks, normals), ink.bars(0.8, 0.3), x, P);
    forces.add(plot, one.file_part() + "-tail", band.tail_N, Style{.width = 1.2}, x, P);
    friction.add(plot, one.file_part() + "-friction", density_of_mobilisation(band.blocks), ink.joined_bars(0.8, 0.35),
                 "T_over_mu_N: dimensionless", P);
    plot.add_key(one.name["pile"], ink.points(0.6));
    sliding.push_back(told(band.numbers["sliding"], one));
    if (!band.tail_N.empty()) powers.push_back(told(band.tails.back()["stretched"]["power"], one));
  }
  if (!powers.empty()) plot.add_key("stretched exponential", Style{.width = 1.2});
  const ForceStatistics& first = measured.front();
  const Json& deepest = first.bands.back().numbers;
  return plot_panels(plot, forces, friction,
                     {{"piles", deepest["samples"].dump()},
                      {"columns", deepest["columns"].dump()},
                      {"first", deepest["first_layer"].dump()},
                      {"last", deepest["last_layer"].dump()},
                      {"powers", enumeration(powers)},
                      {"sliding", enumeration(sliding)}},
                     run_folder);
}

class ForceStatisticsStudy final : public CopiedStudy<ForceStatisticsStudy> {
 public:
  std::string id() const override { return "force_statistics"; }

  std::vector<Key> keys() override {
    return {
        make_key(table(), "mu", "",
                 "friction coefficients at which the distributions of contact forces and weights are measured, under a "
                 "uniform load; none: not at all",
                 mu_, friction_range_above_zero()),
        make_key(table(), "columns", "beads", "beads per layer of these piles", columns_),
        make_key(table(), "bands", "layer", "first layers of the bands that are measured, from the top down", bands_,
                 KeyRange{.ascending = true, .why = "bands are layers of the pile"}.within(0, most_layers)),
        make_key(table(), "thickness", "layers", "layers of each band", thickness_, KeyRange{}.within(1, 1000)),
        make_key(table(), "samples", "piles", "piles per friction coefficient, at least eight per block", samples_),
        make_key(table(), "tail", "", "share of the forces that counts as the tail, whose shape is fitted", tail_,
                 KeyRange{.why = "a tail is part of a distribution"}.above(0).below(1)),
        make_key(table(), "q_model", "", "also measure the q-model, whose weights come to 4 w exp(-2 w)", q_model_)};
  }

  bool asked() const override { return !mu_.empty(); }
  bool suits_any_angle() const override { return true; }

  Problem find_problem(const MainLine& main) const override {
    if (bands_.empty()) return problem(key("bands"), "no band is named; give the first layer of one at least");
    for (std::size_t i = 1; i < bands_.size(); ++i) {
      if (bands_[i] - bands_[i - 1] >= thickness_) continue;
      return problem(key("bands"), "the bands from layers {} and {} share layers, being {} thick; move them apart",
                     bands_[i - 1], bands_[i], thickness_);
    }
    const EnsembleSpec spec = spec_at(main, mu_.front());
    if (auto found = find_lattice_problem(key("columns"), columns_, key("bands"), spec.lattice.layers,
                                          bottom_margin + 1, drawing_memory(spec)))
      return found;
    return find_samples_problem(key("samples"), samples_, main.response.blocks);
  }

  std::vector<StudyEnsemble> ensembles(const MainLine& main) const override {
    std::vector<StudyEnsemble> all;
    for (const double mu : mu_) {
      all.push_back({fmt::format("force statistics, mu = {}", mu), fmt::format("force-statistics-mu-{}", exact(mu)),
                     spec_at(main, mu)});
    }
    if (q_model_ && !mu_.empty()) {
      EnsembleSpec spec = spec_at(main, mu_.front());
      spec.sampler = {.seed = main.sampling.seed, .model = {}};
      spec.sampler.model.name = ModelName::q_model;
      spec.lattice.angle = usual_angle;
      all.push_back({"force statistics, q-model", "force-statistics-q-model", spec});
    }
    return all;
  }

  void add(const StudyEnsemble&, const MeasuredEnsemble& ensemble) override {
    ForceStatistics one{ensemble.spec, {}, {}};
    const BlockSums& sums = ensemble.record.sums;
    one.name["pile"] = one.has_contacts() ? fmt::format("μ = {}", ensemble.spec.sampler.mu) : "q-model";
    one.name["columns"] = ensemble.spec.lattice.columns;
    one.name["samples"] = sums.samples();
    const auto thickness = static_cast<std::size_t>(thickness_);
    for (std::size_t row = 0; row < sums.layers.size(); row += thickness) {
      Json name = one.name;
      name.update({{"first_layer", sums.layers[row]}, {"last_layer", sums.layers[row + thickness - 1]}});
      one.bands.push_back(measure_band(band_sums(sums, ensemble.spec.lattice.columns, row, row + thickness),
                                       one.has_contacts(), tail_, name));
    }
    measured_.push_back(std::move(one));
  }

  Json json() const override {
    Json json = {{"bands", Json::array()}, {"tails", Json::array()}};
    for (const ForceStatistics& one : measured_) {
      for (const Band& band : one.bands) {
        json["bands"].push_back(band.numbers);
        for (const Json& tail : band.tails) json["tails"].push_back(tail);
      }
    }
    return json;
  }

  std::vector<ReportPart> parts() const override {
    if (measured_.empty()) return {};
    return {part("force_statistics", "bands")};
  }

  std::vector<FigurePlot> figures(const Analysis&) const override {
    return figures_of(measured_, plot_force_statistics);
  }

 private:
  EnsembleSpec spec_at(const MainLine& main, double mu) const {
    EnsembleSpec spec =
        main.ensemble_at(mu, {columns_, bands_.back() + thickness_ + bottom_margin, main.lattice.angle}, samples_);
    spec.load = Load::uniform;
    spec.record_profiles = false;
    spec.record_forces = true;
    for (const int first : bands_) {
      for (int layer = first; layer < first + thickness_; ++layer) spec.layers.push_back(layer);
    }
    return spec;
  }

  std::vector<double> mu_;  ///< each above 0; empty: not measured
  int columns_ = 400;
  std::vector<int> bands_{20, 60, 180};
  int thickness_ = 8;
  std::uint64_t samples_ = 1024;
  double tail_ = 0.05;
  bool q_model_ = true;
  std::vector<ForceStatistics> measured_;  ///< ascending in mu, the q-model last
};

}  // namespace
}  // namespace force_distributions

std::unique_ptr<Study> force_statistics_study() {
  return std::make_unique<force_distributions::ForceStatisticsStudy>();
}

}  // namespace granuscope
