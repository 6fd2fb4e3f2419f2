#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "analysis/expected_response.h"
#include "analysis/transport.h"
#include "figure.h"
#include "measure.h"
#include "overlay.h"
#include "report/estimate_json.h"
#include "studies/common_checks.h"
#include "studies/nonlinearity/study.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

using Json = nlohmann::ordered_json;

Json to_json(const LoadResponse& one) {
  return {{"mu", one.spec.sampler.mu},
          {"estimator", one.uniform() ? name_of(one.spec.load) : name_of(one.spec.response.estimator)},
          {"load", one.load()},
          {"reference", one.reference},
          {"columns", one.spec.lattice.columns},
          {"layers", one.spec.lattice.layers},
          {"samples", one.samples},
          {"failed", one.failed},
          {"window_layers", {one.first_layer, one.last_layer}},
          {"own_window", one.own_window},
          {"c", granuscope::to_json(one.c)},
          {"D", granuscope::to_json(one.D)},
          {"c_thrust", granuscope::to_json(one.c_thrust)},
          {"c_minus_linear", granuscope::to_json(one.c_shift)},
          {"D_over_linear_minus_1", granuscope::to_json(one.D_shift)},
          {"c_thrust_minus_uniform", granuscope::to_json(one.c_thrust_shift)}};
}

Json to_json(const LoadExponents& one) {
  return {{"estimator", name_of(one.response.estimator)},
          {"load", load_size(one.response)},
          {"reference", one.reference},
          {"window", one.window},
          {"points", one.points},
          {"beta", granuscope::to_json(one.beta)},
          {"gamma", granuscope::to_json(one.gamma)},
          {"beta_minus_linear", granuscope::to_json(one.beta_shift)},
          {"gamma_minus_linear", granuscope::to_json(one.gamma_shift)}};
}

class NonlinearityStudy final : public CopiedStudy<NonlinearityStudy> {
 public:
  explicit NonlinearityStudy(LoadComparison measured) : measured_(std::move(measured)) {}

  std::string id() const override { return "nonlinearity"; }

  std::vector<Key> keys() override {
    const KeyRange loads{.fewest = 1,
                         .longest = 6,
                         .ascending = true,
                         .why = "beside loads of 1 it cannot be measured, or not in one figure"};
    return {make_key(table(), "mu", "",
                     "friction coefficients at which the response to several loads is compared with the linear one; "
                     "none: not at all",
                     mu_, friction_range_above_zero()),
            make_key(table(), "epsilons", "loads of one top bead",
                     "multiplexed loads compared; that of response.epsilon must be among them and stands for the "
                     "linear response",
                     epsilons_, KeyRange(loads).within(0.01, 0.99)),
            make_key(table(), "overloads", "loads of one top bead", "point loads compared", overloads_,
                     KeyRange(loads).within(0.01, 100)),
            make_key(table(), "multiplexed_samples", "piles",
                     "piles at response.epsilon and under a uniform load; at another epsilon in inverse proportion to "
                     "its square, for errors of one size",
                     multiplexed_samples_),
            make_key(table(), "point_samples", "piles",
                     "piles at the overload 1; at another one in inverse proportion to it", point_samples_)};
  }

  bool asked() const override { return !mu_.empty(); }

  Problem find_problem(const MainLine& main) const override {
    if (std::find(epsilons_.begin(), epsilons_.end(), main.response.epsilon) == epsilons_.end()) {
      return problem(key("epsilons"),
                     "response.epsilon = {} is not among [{}], but the linear response is measured with it and the "
                     "others are compared with that; add it",
                     main.response.epsilon, fmt::join(epsilons_, ", "));
    }
    if (mu_.back() > main.mu.back()) {
      return problem(key("mu"),
                     "{} is above the largest friction coefficient of friction.mu, {}, for which lattice.columns were "
                     "found wide enough; leave it out",
                     mu_.back(), main.mu.back());
    }
    const int blocks = main.response.blocks;
    if (auto found = find_samples_problem(key("multiplexed_samples"), multiplexed_samples_, blocks)) return found;
    return find_samples_problem(key("point_samples"), point_samples_, blocks);
  }

  std::vector<StudyEnsemble> ensembles(const MainLine& main) const override {
    std::vector<StudyEnsemble> all;
    for (const double mu : mu_) add_loads(mu, main, all);
    return all;
  }

  void begin(const MainLine& main, int threads) override {
    comparer_.emplace(main.fit, main.response.epsilon, threads);
  }
  void add(const StudyEnsemble&, const MeasuredEnsemble& ensemble) override { comparer_->add(ensemble); }
  void finish() override { measured_ = comparer_->finish(); }

  Json json() const override {
    return {{"responses", list_of(measured_.responses, to_json)}, {"exponents", list_of(measured_.exponents, to_json)}};
  }

  std::vector<ReportPart> parts(const Json& results) const override {
    ReportPart loads = part(id(), "responses");
    loads.overlay = load_overlay({{"studies", {{id(), results}}}}, loads.base);
    return {loads};
  }

  std::vector<FigurePlot> figures(const Analysis&) const override {
    if (measured_.responses.empty()) return {};
    return {[this](const std::filesystem::path& folder) { return plot_load_comparison(measured_, id(), folder); }};
  }

 private:
  /// On columns just wide enough for the response: beads outside it would cost time and tell nothing.
  void add_loads(double mu, const MainLine& main, std::vector<StudyEnsemble>& all) const {
    FitSpec fit = main.fit;
    fit.shallow_layer = fit.first_layer;  // nothing is plotted of the layers above the window
    constexpr double handy = 16;          // for the Fourier transforms
    const int enough = static_cast<int>(handy * std::ceil(columns_needed(mu, fit.last_layer) / handy));
    const LatticeSpec lattice{std::min(enough, main.lattice.columns), main.lattice.layers};
    const double reference = main.response.epsilon;
    const auto add_load = [&](const std::string& name, double mean_samples, const auto& change) {
      EnsembleSpec spec = main.ensemble_at(mu, lattice, whole_rounds(mean_samples, main.response.blocks));
      spec.layers = layers_to_record(fit, {});
      change(spec);
      all.push_back({fmt::format("load {}, mu = {}", name, mu), fmt::format("load-{}-mu-{}", name, exact(mu)), spec});
    };
    const auto multiplexed = static_cast<double>(multiplexed_samples_);
    for (const double epsilon : epsilons_) {
      add_load("multiplexed-" + exact(epsilon), multiplexed * std::pow(reference / epsilon, 2),
               [&](EnsembleSpec& spec) {
                 spec.response.estimator = EstimatorName::multiplexed;
                 spec.response.epsilon = epsilon;
               });
    }
    for (const double overload : overloads_) {
      add_load("point-" + exact(overload), static_cast<double>(point_samples_) / overload,
               [&](EnsembleSpec& spec) { spec.response.overload = overload; });
    }
    add_load(name_of(Load::uniform), multiplexed, [](EnsembleSpec& spec) {
      spec.load = Load::uniform;
      spec.record_profiles = false;
    });
  }

  /// The least number of samples, at least that many, of which every block holds as many groups.
  static std::uint64_t whole_rounds(double samples, int blocks) {
    const std::uint64_t round = group_size * static_cast<std::uint64_t>(blocks);
    return round * static_cast<std::uint64_t>(std::max(1.0, std::ceil(samples / static_cast<double>(round) - 1e-9)));
  }

  std::vector<double> mu_;                        ///< each above 0; empty: not measured
  std::vector<double> epsilons_{0.1, 0.25, 0.5};  ///< multiplexed; the main line's is taken for the linear response
  std::vector<double> overloads_{0.25, 1, 4};     ///< point
  std::uint64_t multiplexed_samples_ = 1024;      ///< piles at the main line's epsilon; others ~ 1/epsilon^2
  std::uint64_t point_samples_ = 8192;            ///< piles at the overload 1; others in inverse proportion
  std::optional<LoadComparer> comparer_;
  LoadComparison measured_;
};

}  // namespace

std::unique_ptr<Study> nonlinearity_study(LoadComparison measured) {
  return std::make_unique<NonlinearityStudy>(std::move(measured));
}

}  // namespace granuscope
