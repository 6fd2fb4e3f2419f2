#include "study.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "analysis/expected_response.h"
#include "analysis/transport.h"
#include "ensemble/ensemble_runner.h"
#include "figures.h"
#include "json.h"
#include "studies/common_checks.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

using Json = nlohmann::ordered_json;

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
                 range_of_mu("without friction nothing fails, and above 0.6 eloy-clement takes for ever even on 6 x 6 "
                             "beads")),
        make_key(table(), "cost_sizes", "beads", "columns and layers of the square piles for it", cost_sizes_,
                 KeyRange{.fewest = 1,
                          .ascending = true,
                          .why = "the narrowest ring has 4 beads, and at 40 nothing that eloy-clement begins is "
                                 "finished"}
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

  void begin(const MainLine&, int threads) override { threads_ = threads; }

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

  std::vector<ReportPart> parts(const Json& results) const override {
    ReportPart laws = part(id(), "laws"), responses = part("law_responses", "responses"),
               rules = part("law_rules", "rules");
    laws.overlay = laws_overlay(results, laws.base);
    responses.overlay = law_responses_overlay(results);
    rules.overlay = law_rules_overlay(results, rules.base);
    const Json told = laws_page_1(results, laws.base);
    if (told.is_null()) return {laws, responses, rules};
    return {page_1(told), laws, responses, rules};
  }

  std::vector<FigurePlot> figures(const Analysis&) const override {
    std::vector<FigurePlot> plots;
    if (!measured_.on_piles.empty()) {
      plots.emplace_back([this](const std::filesystem::path& folder) { return plot_laws(measured_.on_piles, folder); });
    }
    if (!measured_.costs.empty()) {
      plots.emplace_back(
          [this](const std::filesystem::path& folder) { return plot_law_cost(measured_.costs, folder); });
    }
    return plots;
  }

 private:
  static double beads_of(LatticeSpec lattice) { return static_cast<double>(lattice.columns) * lattice.layers; }

  Problem find_response_problem(const MainLine& main) const {
    if (samples_ == 0) {
      return problem(key("response_samples"),
                     "{} piles for c and D, but {} is 0, so that there is no table to put them into; set both or "
                     "neither",
                     response_samples_, key("samples"));
    }
    if (auto found = find_samples_problem(key("response_samples"), response_samples_, main.response.blocks)) {
      return found;
    }
    const auto& [columns, layers] = response_lattice_;
    const FitSpec fit = law_response_fit(response_lattice_);
    constexpr int least_depths = 3;
    const int least_layers = fit.first_layer + least_depths + bottom_margin;
    if (layers < least_layers) {
      return problem(key("response_layers"),
                     "{} layers: slopes need {} depths from layer {} on, and the lowest {} layers follow another law; "
                     "give at least {}",
                     layers, least_depths, fit.first_layer, bottom_margin, least_layers);
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
  int threads_ = 0;
  ComparedLaws measured_;
};

}  // namespace

std::unique_ptr<Study> law_comparison_study(ComparedLaws measured) {
  return std::make_unique<LawComparisonStudy>(std::move(measured));
}

}  // namespace granuscope
