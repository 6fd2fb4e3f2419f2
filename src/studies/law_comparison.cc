#include "studies/law_comparison.h"

#include <map>
#include <utility>

#include "analysis/double_gaussian.h"
#include "plot/plot.h"

namespace granuscope {
namespace {
constexpr double response_epsilon = 0.5;
constexpr LatticeSpec tiny{6, 6};     ///< the piles that every law can draw
constexpr LatticeSpec narrow{4, 16};  ///< the deepest piles that rejection still draws in a second
constexpr double effort = 1e5;        ///< solutions per bead that eloy-clement is granted
constexpr double most_mu = 0.6;
constexpr int most_cost_columns = 40;
constexpr int cost_blocks = 8;  ///< counted, not measured: few, and piles that eloy-clement still finishes

enum Measurement { on_piles, response, cost };

std::string name_in_file(Law law, double lambda, RepairRules rules) {
  return law == Law::polytope        ? fmt::format("{}-{}", name_of(law), lambda)
         : rules != RepairRules::all ? fmt::format("{}-{}", name_of(law), name_of(rules))
                                     : name_of(law);
}

EnsembleSpec piles_of(const MainLine& main, Law law, double mu, LatticeSpec size, std::uint64_t samples) {
  EnsembleSpec spec = main.uniform_piles(law, mu, size, samples);
  if (law == Law::eloy_clement) spec.sampler.effort = effort;
  return spec;
}

KeyRange range_of_mu(const std::string& why) {
  return KeyRange{.ascending = true, .why = why}.within(0, most_mu).above(0);
}

class LawComparisonStudy final : public CopiedStudy<LawComparisonStudy> {
 public:
  explicit LawComparisonStudy(ComparedLaws measured) : measured_(std::move(measured)) {}
  std::string id() const override { return "law_comparison"; }

  std::vector<Key> keys() override {
    const auto sweeps = KeyRange{.why = "a chain counts no more sweeps"}.within(0, static_cast<double>(most_sweeps));
    const KeyRange size{.least = 4, .why = "a ring of fewer beads, or fewer layers, are no pile to compare laws on"};
    return {
        make_key(table(), "samples", "piles",
                 "uniformly loaded piles of every law from which the laws are compared (rejection and eloy-clement on "
                 "6 x 6 beads only); 0: none",
                 samples_),
        make_key(table(), "mu", "", "friction coefficient of that comparison", mu_,
                 range_of_mu("without friction all laws are one, and above 0.6 the laws that throw away what fails "
                             "take for ever even on 6 x 6 beads")),
        make_key(table(), "columns", "beads", "beads per layer of the piles of granusolve and polytope in it",
                 lattice_.columns, size),
        make_key(table(), "layers", "layers", "layers of these piles", lattice_.layers, size),
        make_key(
            table(), "response_samples", "piles",
            "multiplexed piles of granusolve and polytope from which c and D under these laws are compared; 0: none",
            response_samples_),
        make_key(table(), "response_columns", "beads", "beads per layer of these piles", response_lattice_.columns),
        make_key(table(), "response_layers", "layers",
                 "layers of these piles; c and D are slopes over layer 4 to the last but 21", response_lattice_.layers),
        make_key(table(), "response_burn_in", "sweeps",
                 "polytope: from the start of a chain to the first of its eight piles; 0: measured, which takes long",
                 response_burn_in_, sweeps),
        make_key(table(), "response_thinning", "sweeps",
                 "polytope: from one of the eight piles of a chain to the next; 0: measured", response_thinning_,
                 sweeps),
        make_key(table(), "cost_mu", "",
                 "friction coefficients at which the work of eloy-clement is counted against size, beside granusolve; "
                 "none: not at all",
                 cost_mu_,
                 range_of_mu(
                     "without friction nothing fails, and above 0.6 eloy-clement takes for ever even on 6 x 6 beads")),
        make_key(
            table(), "cost_sizes", "beads", "columns and layers of the square piles for it", cost_sizes_,
            KeyRange{.fewest = 1,
                     .ascending = true,
                     .why = "the narrowest ring has 4 beads, and at 40 nothing that eloy-clement begins is finished"}
                .within(4, most_cost_columns))};
  }

  bool asked() const override { return samples_ > 0 || response_samples_ > 0 || !cost_mu_.empty(); }

  Problem find_problem(const MainLine& main) const override {
    if (samples_ > 0) {
      if (auto found = find_samples_problem(key("samples"), samples_, main.response.blocks)) return found;
      if (beads_of(lattice_) > static_cast<double>(most_polytope_beads)) {
        return problem(key("columns"),
                       "{} x {} beads: the chain of the law polytope forgets too slowly on more than {}; give fewer",
                       lattice_.columns, lattice_.layers, most_polytope_beads);
      }
    }
    return response_samples_ > 0 ? find_response_problem(main) : Problem{};
  }

  std::vector<StudyEnsemble> ensembles(const MainLine& main) const override {
    std::vector<StudyEnsemble> all;
    if (samples_ > 0) add_laws(main, all);
    if (response_samples_ > 0) add_responses(main, all);
    for (const double mu : cost_mu_) {
      for (const Law law : {Law::granusolve, Law::eloy_clement}) {
        for (const int size : cost_sizes_) all.push_back(cost_of(main, law, mu, size));
      }
    }
    return all;
  }

  void add(const StudyEnsemble& which, const MeasuredEnsemble& ensemble) override {
    switch (which.part) {
      case on_piles:
        measured_.on_piles.push_back(measure_law(ensemble));
        break;
      case response:
        measured_.responses.push_back(measure_law_response(ensemble, threads_));
        break;
      default:
        measured_.costs.push_back(measure_law(ensemble));
    }
  }

  Json json() const override { return laws_json(measured_); }

  std::vector<ReportPart> parts() const override {
    std::vector<ReportPart> all;
    const Json told = laws_page_1(measured_);
    if (!told.is_null()) all.push_back(page_1(told));
    for (const auto& [page, needs] : {std::pair{"law_comparison", "laws"}, std::pair{"law_responses", "responses"},
                                      std::pair{"law_rules", "rules"}}) {
      all.push_back(part(page, needs));
      all.back().overlay = laws_overlay(measured_);
    }
    return all;
  }

  std::vector<FigurePlot> figures(const Analysis&) const override {
    std::vector<FigurePlot> plots = figures_of(measured_.on_piles, plot_laws);
    std::ranges::copy(figures_of(measured_.costs, plot_law_cost), std::back_inserter(plots));
    return plots;
  }

 private:
  static double beads_of(LatticeSpec lattice) { return static_cast<double>(lattice.columns) * lattice.layers; }

  Problem find_response_problem(const MainLine& main) const {
    if (samples_ == 0) {
      return problem(
          key("response_samples"),
          "{} piles for c and D, but {} is 0, so that there is no table to put them into; set both or neither",
          response_samples_, key("samples"));
    }
    if (auto found = find_samples_problem(key("response_samples"), response_samples_, main.response.blocks)) {
      return found;
    }
    const int columns = response_lattice_.columns, layers = response_lattice_.layers;
    const FitSpec fit = law_response_fit(response_lattice_);
    constexpr int least_depths = 3;
    const int least_layers = fit.first_layer + least_depths + bottom_margin;
    if (layers < least_layers) {
      return problem(key("response_layers"),
                     "{}: slopes need {} depths from layer {} on, and the lowest {} layers follow another law; "
                     "give at least {}",
                     how_many(layers, "layer"), least_depths, fit.first_layer, bottom_margin, least_layers);
    }
    const double least_columns = columns_needed(mu_, fit.last_layer);
    if (columns >= least_columns && beads_of(response_lattice_) <= static_cast<double>(most_polytope_beads)) return {};
    return problem(key("response_columns"),
                   "{} x {} beads: the two peaks need {} columns not to meet behind the ring, and the chain of the law "
                   "polytope forgets too slowly on more than {} beads; give a size between",
                   columns, layers, std::ceil(least_columns), most_polytope_beads);
  }

  void add_laws(const MainLine& main, std::vector<StudyEnsemble>& all) const {
    const auto add = [&](Law law, double lambda, LatticeSpec size, RepairRules rules = RepairRules::all) {
      EnsembleSpec spec = piles_of(main, law, mu_, size, samples_);
      spec.sampler.lambda = lambda;
      spec.sampler.rules = rules;
      const std::string which = name_in_file(law, lambda, rules);
      all.push_back({fmt::format("law {}, {} x {}", which, size.columns, size.layers),
                     fmt::format("law-{}-{}x{}", which, size.columns, size.layers), spec, on_piles});
    };
    add(Law::granusolve, 1, lattice_);
    for (const RepairRules rules : {RepairRules::no_pair, RepairRules::no_arcs, RepairRules::backtrack_only}) {
      add(Law::granusolve, 1, lattice_, rules);
    }
    add(Law::polytope, 1, lattice_);
    add(Law::polytope, 0, lattice_);
    add(Law::granusolve, 1, tiny);
    add(Law::eloy_clement, 1, tiny);
    add(Law::rejection, 1, tiny);
    add(Law::polytope, 1, tiny);
    add(Law::rejection, 1, narrow);
  }

  /// What none of its rules could complete is left out: backtracks alone finish hardly a pile.
  void add_responses(const MainLine& main, std::vector<StudyEnsemble>& all) const {
    const auto add = [&](Law law, double lambda, RepairRules rules) {
      EnsembleSpec spec = piles_of(main, law, mu_, response_lattice_, response_samples_);
      spec.sampler.lambda = lambda;
      spec.sampler.rules = rules;
      if (law == Law::polytope) {
        spec.sampler.burn_in = response_burn_in_;
        spec.sampler.thinning = response_thinning_;
      }
      spec.load = Load::point;
      spec.response.estimator = EstimatorName::multiplexed;
      spec.response.epsilon = response_epsilon;
      spec.record_profiles = true;
      spec.layers = layers_to_record(law_response_fit(spec.lattice), {});
      const std::string which = name_in_file(law, lambda, rules);
      all.push_back(
          {fmt::format("response under {}, {} x {}", which, response_lattice_.columns, response_lattice_.layers),
           fmt::format("law-response-{}", which), spec, response});
    };
    for (const RepairRules rules : {RepairRules::all, RepairRules::no_pair, RepairRules::no_arcs}) {
      add(Law::granusolve, 1, rules);
    }
    for (const double lambda : {1.0, 0.0}) add(Law::polytope, lambda, RepairRules::all);
  }

  static StudyEnsemble cost_of(const MainLine& main, Law law, double mu, int size) {
    EnsembleSpec spec = piles_of(main, law, mu, {size, size}, group_size * cost_blocks);
    spec.response.blocks = cost_blocks;
    return {fmt::format("work of {}, mu = {}, {} x {}", name_of(law), mu, size, size),
            fmt::format("law-cost-{}-mu-{}-{}x{}", name_of(law), exact(mu), size, size), spec, cost};
  }

  double mu_ = 0.3;
  LatticeSpec lattice_{12, 30};           ///< of the piles of granusolve and polytope
  std::uint64_t samples_ = 0;             ///< piles of each law; 0: not measured
  std::vector<double> cost_mu_;           ///< empty: the work is not counted
  std::vector<int> cost_sizes_{4, 6, 8};  ///< ascending
  std::uint64_t response_samples_ = 0;    ///< piles of each law; 0: not measured
  LatticeSpec response_lattice_{24, 27};
  std::uint64_t response_burn_in_ = 20'000, response_thinning_ = 2000;  ///< polytope, sweeps; 0: measured
  ComparedLaws measured_;
};

}  // namespace

std::unique_ptr<Study> law_comparison_study(ComparedLaws measured) {
  return std::make_unique<LawComparisonStudy>(std::move(measured));
}

namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// At mu = 0.3 the peaks of granusolve are half a bead wide there, and narrower above.
constexpr int first_response_layer = 4;

/// What was drawn, and how its chains ran; the mean over the chains, all of which run alike.
template <class Measured>
void set_law(const EnsembleSpec& spec, const SamplerCounts& counts, Measured& result) {
  const bool chain = spec.sampler.law == Law::polytope;
  const auto per_chain = [&](std::uint64_t sweeps) {
    return chain && counts.chains > 0 ? static_cast<double>(sweeps) / static_cast<double>(counts.chains) : nan;
  };
  result.spec = spec;
  result.burn_in = per_chain(counts.burn_in);
  result.thinning = per_chain(counts.thinning);
}

}  // namespace

LawOnPiles measure_law(const MeasuredEnsemble& ensemble) {
  const auto& [spec, record] = ensemble;
  const BlockSums& sums = record.sums;
  const SamplerCounts& counts = record.counts;
  const auto per_bead = [&](std::uint64_t count) {
    return counts.beads == 0 ? nan : static_cast<double>(count) / static_cast<double>(counts.beads);
  };
  LawOnPiles result;
  set_law(spec, counts, result);
  result.samples = sums.samples();
  result.failed = record.failed.size();
  result.effective_samples = effective_samples(sums);
  result.flat = test_flat_law(sums);
  result.draws_per_bead = per_bead(counts.uniforms);
  result.pair_per_bead = per_bead(counts.repaired_by_pair);
  result.arc_per_bead = per_bead(counts.repaired_by_arc + counts.repaired_by_ring);
  result.backtracked_per_bead = per_bead(counts.backtracked);
  const int layers = spec.lattice.layers;
  result.first_layer = layers / 3;
  result.last_layer = std::max(result.first_layer, 2 * layers / 3 - 1);
  std::vector<Replicated> thrusts, variances;
  for (std::size_t row = 0; row < sums.layers.size(); ++row) {
    const int layer = sums.layers[row];
    const Replicated thrust = block_mean(sums, "thrust", row), variance = block_mean(sums, "weight_variance", row);
    result.depths.push_back({layer, Lattice::depth(layer), estimate(thrust), estimate(variance)});
    if (layer < result.first_layer || layer > result.last_layer) continue;
    thrusts.push_back(thrust);
    variances.push_back(variance);
  }
  const Replicated alpha = mean_of(thrusts);
  result.alpha_thrust = estimate(alpha, "no pile was completed");
  result.c_thrust = estimate(transform([](double kappa) { return speed_from_thrust(kappa); }, alpha),
                             "the mean thrust ratio is unknown");
  result.weight_variance = estimate(mean_of(variances), "no pile was completed");
  return result;
}

FitSpec law_response_fit(const LatticeSpec& lattice) {
  FitSpec fit;
  fit.first_layer = fit.shallow_layer = first_response_layer;
  fit.last_layer = lattice.layers - bottom_margin - 1;
  fit.layer_step = 1;
  return fit;
}

LawResponse measure_law_response(const MeasuredEnsemble& ensemble, int threads) {
  const FitSpec fit = law_response_fit(ensemble.spec.lattice);
  const Transport transport = measure_transport(ensemble, fit, {}, threads).transport;
  LawResponse result;
  set_law(ensemble.spec, ensemble.record.counts, result);
  result.samples = transport.samples;
  result.failed = ensemble.record.failed.size();
  result.effective_samples = effective_samples(ensemble.record.sums);
  result.first_layer = transport.window_layers[0];
  result.last_layer = transport.window_layers[1];
  result.c = transport.c;
  result.D = transport.D;
  return result;
}

namespace {

/// Which law, and how its chains ran.
template <class Measured>
Json law_json(const Measured& one) {
  const SamplerSpec& sampler = one.spec.sampler;
  Json json = {{"law", name_of(sampler.law)}};
  if (sampler.law == Law::granusolve) json["repair_rules"] = name_of(sampler.rules);
  if (sampler.law != Law::polytope) return json;
  json["lambda"] = sampler.lambda;
  json["burn_in"] = finite_or_null(one.burn_in);
  json["thinning"] = finite_or_null(one.thinning);
  if (json["burn_in"].is_null()) json["reason"] = "no chain was begun";
  return json;
}

}  // namespace

void to_json(Json& json, const LawResponse& one) {
  json = law_json(one);
  json.update(Json{{"mu", one.spec.sampler.mu},
                   {"columns", one.spec.lattice.columns},
                   {"layers", one.spec.lattice.layers},
                   {"epsilon", one.spec.response.epsilon},
                   {"samples", one.samples},
                   {"failed", one.failed},
                   {"effective_samples", one.effective_samples},
                   {"window_layers", {one.first_layer, one.last_layer}},
                   {"c", one.c},
                   {"D", one.D}});
}

void to_json(Json& json, const LawOnPiles& one) {
  json = law_json(one);
  json.update(Json{{"mu", one.spec.sampler.mu},
                   {"columns", one.spec.lattice.columns},
                   {"layers", one.spec.lattice.layers},
                   {"samples", one.samples},
                   {"failed", one.failed},
                   {"effective_samples", one.effective_samples},
                   {"draws_per_bead", finite_or_null(one.draws_per_bead)},
                   {"pair_per_bead", finite_or_null(one.pair_per_bead)},
                   {"arc_per_bead", finite_or_null(one.arc_per_bead)},
                   {"backtracked_per_bead", finite_or_null(one.backtracked_per_bead)},
                   {"window_layers", {one.first_layer, one.last_layer}},
                   {"alpha_thrust", one.alpha_thrust},
                   {"c_thrust", one.c_thrust},
                   {"weight_variance", one.weight_variance},
                   {"depths", one.depths}});
  if (!one.flat.means.empty()) json["flat_law"] = one.flat;
  if (json["draws_per_bead"].is_null()) json["reason"] = "no pile was completed";
}

namespace {

/// By how many standard errors of their difference a number lies from another; 0 where both are exact.
double distance(const Estimate& one, const Estimate& other) {
  const double error = std::hypot(one.standard_error, other.standard_error);
  return error > 0 ? std::abs(one.value - other.value) / error : 0;
}

std::string errors_apart(const Estimate& one, const Estimate& first) {
  if (!one.known() || !first.known() || (one.standard_error == 0 && first.standard_error == 0)) return "n/a";
  return fmt::format("{:.1f}", distance(one, first));
}

bool all_rules(const EnsembleSpec& spec) {
  return spec.sampler.law != Law::granusolve || spec.sampler.rules == RepairRules::all;
}

bool same_size(const LawOnPiles& one, const LawOnPiles& other) {
  return one.spec.lattice.columns == other.spec.lattice.columns && one.spec.lattice.layers == other.spec.lattice.layers;
}

}  // namespace

Json laws_json(const ComparedLaws& measured) {
  return {{"laws", measured.on_piles}, {"responses", measured.responses}, {"costs", measured.costs}};
}

Json laws_overlay(const ComparedLaws& measured) {
  Json chains = Json::array(), rules = Json::array(), responses = Json::array();
  const auto& laws = measured.on_piles;
  for (std::size_t i = 0; i < laws.size(); ++i) {
    const Json place = {{"key", fmt::format("/studies/law_comparison/laws/{}", i)}};
    const Law law = laws[i].spec.sampler.law;
    if (law == Law::polytope) {
      chains.push_back(place);
      chains.back()["last"] = false;
    }
    if (law == Law::granusolve && same_size(laws[i], laws[0])) rules.push_back(place);
  }
  if (!chains.empty()) chains.back()["last"] = true;
  for (const LawResponse& one : measured.responses) {
    const LawResponse& first = measured.responses.front();
    const bool itself = &one == &first;
    responses.push_back({{"c_apart", itself ? "–" : errors_apart(one.c, first.c)},
                         {"D_apart", itself ? "–" : errors_apart(one.D, first.D)}});
  }
  return {{"chains", chains}, {"rules", rules}, {"responses", responses}};
}

Json laws_page_1(const ComparedLaws& measured) {
  constexpr double sure = 3;  // standard errors
  const std::string base = "/studies/law_comparison";
  std::vector<std::string> same, small, responses;
  const LawOnPiles *first = nullptr, *first_small = nullptr;
  double farthest = 0;
  for (std::size_t i = 0; i < measured.on_piles.size(); ++i) {
    const LawOnPiles& one = measured.on_piles[i];
    if (!all_rules(one.spec) || !one.alpha_thrust.known()) continue;
    const std::string pointer = fmt::format("{}/laws/{}", base, i);
    if (first == nullptr) first = &one;
    if (same_size(one, *first)) {
      same.push_back(pointer);
      farthest = std::max(farthest, distance(one.alpha_thrust, first->alpha_thrust));
      continue;
    }
    if (first_small == nullptr) first_small = &one;
    if (same_size(one, *first_small)) small.push_back(pointer);
  }
  if (same.size() < 2) return nullptr;
  if (small.size() < 2) small.clear();
  for (std::size_t i = 0; i < measured.responses.size(); ++i) {
    const LawResponse& one = measured.responses[i];
    if (all_rules(one.spec) && one.c.known() && one.D.known()) {
      responses.push_back(fmt::format("{}/responses/{}", base, i));
    }
  }
  if (responses.size() < 2) responses.clear();
  std::string cheapest, dearest;  // of the largest piles at the largest friction, which come last
  for (std::size_t i = 0; i < measured.costs.size(); ++i) {
    const LawOnPiles &one = measured.costs[i], &last = measured.costs.back();
    if (one.spec.sampler.mu != last.spec.sampler.mu || one.spec.lattice.columns != last.spec.lattice.columns) continue;
    if (one.failed != 0 || !std::isfinite(one.draws_per_bead)) continue;
    (one.spec.sampler.law == Law::granusolve ? cheapest : dearest) = fmt::format("{}/costs/{}", base, i);
  }
  Json cost = nullptr;
  if (!cheapest.empty() && !dearest.empty()) cost = {{"cheap", {{"key", cheapest}}}, {"dear", {{"key", dearest}}}};
  return {{"differ", farthest > sure},
          {"same", enumerated(same)},
          {"first", {{"key", same.front()}}},
          {"small", enumerated(small)},
          {"first_small", small.empty() ? Json(nullptr) : Json{{"key", small.front()}}},
          {"responses", enumerated(responses)},
          {"cost", cost}};
}

namespace {

constexpr const char* thrust_id = "law-comparison";
constexpr const char* cost_id = "law-cost";

std::string name_in_words(const LawOnPiles& one) {
  const SamplerSpec& law = one.spec.sampler;
  const LatticeSpec& lattice = one.spec.lattice;
  const std::string lambda = law.law == Law::polytope ? ", λ = " + caption_number(law.lambda) : "";
  const std::string rules = law.rules == RepairRules::all ? "" : " (" + name_of(law.rules) + ")";
  return fmt::format("{}{}{}, {} × {}", name_of(law.law), rules, lambda, lattice.columns, lattice.layers);
}

std::string size_in_words(const LawOnPiles& one) {
  return fmt::format("{} × {}", one.spec.lattice.columns, one.spec.lattice.layers);
}

/// "1.47 to 8.32 at μ = 0.3", and with "up to 8 × 8 beads" where the curve ends before the others.
std::string growth_in_words(const LawOnPiles& smallest, const LawOnPiles& largest, double most_columns) {
  const std::string end =
      largest.spec.lattice.columns < most_columns ? fmt::format(" up to {} beads", size_in_words(largest)) : "";
  return fmt::format("{} to {} at μ = {}{}", significant(smallest.draws_per_bead, 3),
                     significant(largest.draws_per_bead, 3), caption_number(largest.spec.sampler.mu), end);
}

}  // namespace

Figure plot_laws(const std::vector<LawOnPiles>& laws, const std::filesystem::path& run_folder) {
  Plot plot;
  plot.id = thrust_id;
  Panel panel;
  panel.name = 0.02;
  std::vector<std::string> repaired, failed;
  Range layers, alphas;
  layers.add(0);
  alphas.add(1);
  for (const LawOnPiles& one : laws) {
    CsvTable table({"layer: layers", "thrust_ratio: dimensionless", "thrust_error: dimensionless",
                    "weight_variance: loads of one top bead squared", "variance_error: loads of one top bead squared"});
    for (const ThrustAtDepth& depth : one.depths) {
      if (!depth.thrust_ratio.known()) continue;
      const double alpha = depth.thrust_ratio.value, error = depth.thrust_ratio.standard_error;
      table.add_row({static_cast<double>(depth.layer), alpha, error, depth.weight_variance.value,
                     depth.weight_variance.standard_error});
      layers.add(depth.layer);
      alphas.add(alpha, error);
    }
    if (one.failed > 0) {
      failed.push_back(fmt::format("{} of {} piles of {}", one.failed, one.failed + one.samples, name_in_words(one)));
    }
    if (table.empty()) continue;
    const Ink ink = ink_of_series(panel.curves.size());
    panel.add(plot.add_data(std::to_string(panel.curves.size() + 1), table), "1:2:3", ink.joined_bars(0.8, 0.45));
    plot.add_key(fmt::format("{}:  κ = {}", name_in_words(one), in_words(one.alpha_thrust)), ink.points(0.6));
    if (one.spec.sampler.law == Law::granusolve && one.spec.sampler.rules == RepairRules::all) {
      repaired.push_back(
          fmt::format("on {} × {} beads the pair rule gave {:.2f} %, arcs and rings {:.3f} % and backtracks {:.3f} % "
                      "of the beads their value",
                      one.spec.lattice.columns, one.spec.lattice.layers, 100 * one.pair_per_bead,
                      100 * one.arc_per_bead, 100 * one.backtracked_per_bead));
    }
  }
  if (panel.curves.empty()) {
    throw InputError(
        "the comparison of laws has nothing to show, because no pile of it was completed; give it smaller piles or "
        "less friction");
  }
  const std::size_t lines = plot.key.entries.size();
  plot.key.lines = static_cast<int>(lines);
  plot.key.inches = 0.1 + 0.165 * static_cast<double>(lines);
  plot.key.sample = 2;
  plot.height = 3.1 + plot.key.inches;
  panel.x = linear_axis("layer", {-0.5, layers.high + 1, false}, 8, layers);
  panel.y = linear_axis("thrust ratio κ", {alphas.low - 0.02, alphas.high + 0.02, false}, 6, alphas);
  panel.add_level(1, {.colour = "frame", .width = 0.8});
  plot.panels = {panel};
  return plot_figure(plot,
                     {"studies/law_thrust.captions",
                      {{"mu", caption_number(laws.front().spec.sampler.mu)},
                       {"repaired", enumeration(repaired)},
                       {"failed", enumeration(failed)}}},
                     run_folder);
}

Figure plot_law_cost(const std::vector<LawOnPiles>& costs, const std::filesystem::path& run_folder) {
  std::map<std::pair<std::string, double>, std::vector<const LawOnPiles*>> curves_of;
  std::vector<std::string> incomplete;
  Range columns, draws;
  draws.add(1);
  for (const LawOnPiles& one : costs) {
    if (one.failed > 0) {
      incomplete.push_back(fmt::format("{} of {} piles of {} × {} beads under {} at μ = {}", one.failed,
                                       one.failed + one.samples, one.spec.lattice.columns, one.spec.lattice.layers,
                                       name_of(one.spec.sampler.law), caption_number(one.spec.sampler.mu)));
    }
    // What failed has drawn without an end: its work is no one's.
    if (one.failed > 0 || !std::isfinite(one.draws_per_bead)) continue;
    curves_of[{name_of(one.spec.sampler.law), one.spec.sampler.mu}].push_back(&one);
    columns.add(one.spec.lattice.columns);
    draws.add(one.draws_per_bead);
  }
  if (curves_of.empty()) {
    throw InputError(
        "the figure of the laws' work has nothing to show, because no size was completed; give smaller cost_sizes");
  }
  Plot plot;
  plot.id = cost_id;
  plot.half_width = true;
  plot.height = 2.3;
  plot.key = {.inches = 0.48, .lines = 2, .horizontal = true, .centred = true, .sample = 2, .entries = {}};
  Panel panel;
  panel.left = 0.125;
  panel.name = 0.02;
  std::map<std::string, std::vector<std::string>> growth;  // of each law
  const LawOnPiles *least = nullptr, *most = nullptr;
  for (const auto& [which, sizes] : curves_of) {
    CsvTable table({"columns: beads", "layers: layers", "piles: piles", "draws_per_bead: draws per bead"});
    for (const LawOnPiles* one : sizes) {
      table.add_row({static_cast<double>(one->spec.lattice.columns), static_cast<double>(one->spec.lattice.layers),
                     static_cast<double>(one->samples), one->draws_per_bead});
    }
    const auto& [law, mu] = which;
    const Style style = ink_of_series(panel.curves.size()).joined(1.2, 0.55);
    panel.add(plot.add_data(fmt::format("{}-mu-{}", law, exact(mu)), table), "1:4", style);
    plot.add_key(fmt::format("{}, μ = {}", law, caption_number(mu)), style);
    growth[law].push_back(growth_in_words(*sizes.front(), *sizes.back(), columns.high));
    if (least == nullptr || sizes.front()->spec.lattice.columns < least->spec.lattice.columns) least = sizes.front();
    if (most == nullptr || sizes.back()->spec.lattice.columns > most->spec.lattice.columns) most = sizes.back();
  }
  panel.x = linear_axis("columns and layers of a pile", {columns.low - 0.5, columns.high + 0.5, false}, 8, columns);
  panel.y = log_axis("draws per bead", widened_by_factor(draws, 1.5));
  plot.panels = {panel};
  std::vector<std::string> of_each_law;
  of_each_law.reserve(growth.size());
  for (const auto& [law, numbers] : growth) of_each_law.push_back(fmt::format("{} {}", law, enumeration(numbers)));
  return plot_figure(plot,
                     {"studies/law_cost.captions",
                      {{"growth", fmt::format("{}", fmt::join(of_each_law, "; "))},
                       {"piles", std::to_string(most->samples)},
                       {"smallest", size_in_words(*least)},
                       {"largest", size_in_words(*most)},
                       {"incomplete", enumeration(incomplete)}}},
                     run_folder);
}

}  // namespace granuscope
