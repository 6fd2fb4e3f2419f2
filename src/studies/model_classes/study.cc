#include "studies/model_classes/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "model/lattice.h"
#include "report/estimate_json.h"
#include "studies/common_checks.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

using Json = nlohmann::ordered_json;

Json exact_or_unknown(double value) {
  return std::isfinite(value) ? granuscope::to_json(Estimate{.value = value, .standard_error = 0, .reason = ""})
                              : granuscope::to_json(Estimate{.reason = "no exact value is known"});
}

Json to_json(const ModelResponse& one) {
  Json chi2 = Json::object();
  for (const ResponseShape shape : all_response_shapes) {
    chi2[name_of(shape)] = finite_or_null(one.fits[static_cast<std::size_t>(shape)].chi2);
  }
  const auto of = [&](ResponseShape shape) { return one.fits[static_cast<std::size_t>(shape)].chi2; };
  const double elastic = std::min(of(ResponseShape::isotropic), of(ResponseShape::orthotropic));
  const double gaussian = std::min(of(ResponseShape::one_gaussian), of(ResponseShape::two_gaussians));
  const std::size_t colon = std::min(one.verdict.find(": "), one.verdict.size());
  return {{"series", one.series},
          {"model", one.model},
          {"parameter", one.parameter},
          {"samples", one.samples},
          {"window_layers", one.layers},
          {"window_z", one.z},
          {"peaks", one.peaks},
          {"c", granuscope::to_json(one.c)},
          {"c_expected", exact_or_unknown(one.c_expected)},
          {"D", granuscope::to_json(one.D)},
          {"D_expected", exact_or_unknown(one.D_expected)},
          {"c0_minus_c", granuscope::to_json(one.slowing)},
          {"c_thrust", granuscope::to_json(one.c_thrust)},
          {"width_exponent", granuscope::to_json(one.width_exponent)},
          {"shape", name_of(one.shape)},
          {"chi2", chi2},
          {"chi2_against_elastic", std::round(elastic - gaussian)},
          {"class", one.verdict.substr(0, colon)},
          {"why", colon < one.verdict.size() ? one.verdict.substr(colon + 2) : ""},
          {"middle", granuscope::to_json(one.middle)},
          {"c_of_middle", granuscope::to_json(one.c_of_middle)},
          {"share_of_mean", granuscope::to_json(one.share_of_mean)},
          {"traction", granuscope::to_json(one.traction)}};
}

/// What the sentences of page 1 need beside the results: series by the number of their peaks, exponents that are known,
/// and the smallest and largest known share of the slowing that a mean explains.
Json page_1_overlay(const Json& results) {
  constexpr double roughest = 0.2;  // standard error of a power of z that is told
  const std::string base = "/studies/model_classes";
  std::vector<std::string> by_peaks[2], exponents;
  std::string least, most, fastest, slowest, last;
  const auto value = [&results](const std::string& pointer) {
    return results.at(Json::json_pointer(pointer)).at("value");
  };
  const auto place = [&](std::string& chosen, const std::string& pointer, double sign) {
    const Json& candidate = value(pointer);
    if (!candidate.is_number()) return;
    if (chosen.empty() || sign * candidate.get<double>() > sign * value(chosen).get<double>()) chosen = pointer;
  };
  for (std::size_t i = 0; i < results.at("responses").size(); ++i) {
    const Json& one = results.at("responses")[i];
    const std::string pointer = fmt::format("/responses/{}", i);
    const std::size_t peaks = one.at("peaks") == 1 ? 0 : 1;
    std::vector<std::string>& alike = by_peaks[peaks];
    if (one.at("series") != last || alike.empty()) alike.push_back(base + pointer);
    last = one.at("series");
    place(least, pointer + "/share_of_mean", -1);
    place(most, pointer + "/share_of_mean", 1);
    const Json& power = one.at("width_exponent");
    if (!power.at("value").is_number() || power.at("stderr").get<double>() > roughest) continue;
    place(slowest, pointer + "/width_exponent", -1);
    place(fastest, pointer + "/width_exponent", 1);
  }
  for (std::size_t i = 0; i < results.at("exponents").size(); ++i) {
    const std::string pointer = fmt::format("/exponents/{}", i);
    if (value(pointer + "/alpha").is_number()) exponents.push_back(base + pointer);
  }
  const auto pair = [&](const std::string& low, const std::string& high) {
    return low.empty() ? Json(nullptr) : Json{{"low", {{"key", base + low}}}, {"high", {{"key", base + high}}}};
  };
  return {{"told_apart", !by_peaks[0].empty() && !by_peaks[1].empty()},
          {"one_peak", enumerated(by_peaks[0])},
          {"two_peaks", enumerated(by_peaks[1])},
          {"some_exponents", !exponents.empty()},
          {"exponents", enumerated(exponents)},
          {"widths", pair(slowest, fastest)},
          {"shares", pair(least, most)}};
}

/// One ensemble of the study before it is drawn.
struct Wanted {
  std::string series, parameter, file;
  SamplerSpec sampler;
};

class ModelsStudy final : public CopiedStudy<ModelsStudy> {
 public:
  explicit ModelsStudy(std::vector<ModelSeries> measured) : measured_(std::move(measured)) {}

  std::string id() const override { return "model_classes"; }

  std::vector<Key> keys() override {
    const auto list = [](KeyRange range, const char* why) {
      range.ascending = true;
      range.longest = 12;
      range.why = why;
      return range;
    };
    KeyRange shares = list(KeyRange{}.within(0, 1).above(0).below(1),
                           "the middle leg carries a share of the force, and leaves some to the others");
    return {
        make_key(table(), "mu", "", "friction coefficients of the beads that stand beside the models", mu_,
                 friction_range_above_zero()),
        make_key(table(), "q_model", "",
                 "measure the scalar q-model, with shares q uniform on [0, 1], 0 or 1, and of density 6 q (1 - q)",
                 q_model_),
        make_key(table(), "three_leg_free", "",
                 "three-leg model: mean shares of the middle leg, whose noise is not bounded", three_leg_free_, shares),
        make_key(table(), "three_leg_positive", "",
                 "three-leg model: the share of the middle leg is uniform from 0 to so much of the largest one with "
                 "which no leg pulls (1: all of it)",
                 three_leg_positive_,
                 list(KeyRange{}.within(0, 1).above(0), "it is a share of what the legs can bear")),
        make_key(table(), "three_leg_clipped", "",
                 "three-leg model: mean shares of the middle leg, whose noise is clipped so that no leg pulls",
                 three_leg_clipped_, shares),
        make_key(table(), "three_leg_noise", "",
                 "three_leg_free and _clipped: the share is uniform on the mean plus and minus so much of it", noise_,
                 KeyRange{.why = "a share is never negative"}.within(0, 1)),
        make_key(table(), "stochastic_osl", "",
                 "stochastic OSL: standard deviations of the noise v in sigma_xx = (1 + v) sigma_zz / 3", osl_,
                 list(KeyRange{}.within(0, 0.57).above(0), "a uniform v would reach -1, where no wave propagates")),
        make_key(table(), "osl_grid", "nodes per bead diameter", "stochastic OSL: fineness of the explicit scheme",
                 grid_, KeyRange{}.within(1, 16)),
        make_key(
            table(), "osl_cells", "bead diameters, rows",
            "stochastic OSL: width and height of the cells within which noise is the same; must divide the columns",
            cells_, KeyRange{}.within(1, 64)),
        make_key(table(), "columns", "beads", "beads per layer", columns_,
                 KeyRange{}.within(fewest_columns, most_columns)),
        make_key(table(), "depth", "bead diameters", "deepest layer that is measured; the fits begin at a third of it",
                 depth_,
                 KeyRange{.why = "below 30 the peaks have not yet parted, and beyond 10000 nothing is new"}.within(
                     30, 10'000)),
        make_key(table(), "samples", "piles",
                 "piles of each, at least eight per block; a quarter of them of beads and of stochastic OSL, which "
                 "cost more",
                 samples_),
        make_key(table(), "epsilon", "loads of one top bead", "by how much each top load is raised or lowered",
                 epsilon_, KeyRange{}.within(least_epsilon, epsilon_limit).below(epsilon_limit))};
  }

  bool asked() const override {
    return q_model_ || !mu_.empty() || !three_leg_free_.empty() || !three_leg_positive_.empty() ||
           !three_leg_clipped_.empty() || !osl_.empty();
  }

  Problem find_problem(const MainLine& main) const override {
    // Peaks run apart with c0 at most, and are at most as wide as the single one of the q-model.
    const double needed = 2 * tan30 * depth_ + 8 * std::sqrt(0.3 * depth_ + 1);
    if (columns_ < needed) {
      return problem(key("columns"),
                     "the peaks meet behind a ring of {} columns before z = {}; give {} or more, or a smaller depth",
                     columns_, depth_, std::ceil(needed));
    }
    const int layers = fit_of(ModelSpec{}).last_layer + bottom_margin + 1;
    if (auto found = find_lattice_problem(key("columns"), columns_, key("depth"), layers, bottom_margin + 4,
                                          pile_memory(columns_, layers))) {
      return found;
    }
    return find_samples_problem(key("samples"), samples_, main.response.blocks);
  }

  std::vector<StudyEnsemble> ensembles(const MainLine& main) const override {
    std::vector<StudyEnsemble> all;
    const std::vector<Wanted> wanted = wanted_of(main);
    for (std::size_t k = 0; k < wanted.size(); ++k) {
      const Wanted& one = wanted[k];
      const FitSpec fit = fit_of(one.sampler.model);
      EnsembleSpec spec;
      spec.sampler = one.sampler;
      spec.lattice = {columns_, fit.last_layer + bottom_margin + 1};
      spec.response.estimator = EstimatorName::multiplexed;
      spec.response.epsilon = epsilon_;
      spec.response.blocks = main.response.blocks;
      spec.response.samples = samples_;
      const ModelName model = one.sampler.model.name;
      if (model == ModelName::frictional_beads || model == ModelName::stochastic_osl) {
        const auto least = group_size * static_cast<std::uint64_t>(main.response.blocks);
        spec.response.samples = std::max(samples_ / costly, least);
      }
      spec.layers = layers_to_record(fit, {});
      const std::string label = one.parameter.empty() ? one.series : fmt::format("{}, {}", one.series, one.parameter);
      all.push_back({label, one.file, spec, static_cast<int>(k)});
    }
    return all;
  }

  void begin(const MainLine& main, int threads) override {
    wanted_ = wanted_of(main);
    threads_ = threads;
  }

  void add(const StudyEnsemble& which, const MeasuredEnsemble& ensemble) override {
    const Wanted& wanted = wanted_.at(static_cast<std::size_t>(which.part));
    replicated_.push_back(
        measure_model(ensemble, fit_of(ensemble.spec.sampler.model), wanted.series, wanted.parameter, threads_));
  }

  void finish() override {
    for (auto one = replicated_.begin(); one != replicated_.end();) {
      ModelSeries& series = measured_.emplace_back();
      series.name = one->response.series;
      std::vector<const MeasuredModel*> members;
      for (; one != replicated_.end() && one->response.series == series.name; ++one) {
        series.responses.push_back(one->response);
        members.push_back(&*one);
      }
      series.alpha = slowing_against_spreading(members);
    }
    replicated_.clear();
  }

  Json json() const override {
    Json responses = Json::array(), exponents = Json::array();
    for (const ModelSeries& series : measured_) {
      for (const ModelResponse& one : series.responses) responses.push_back(to_json(one));
      exponents.push_back({{"series", series.name},
                           {"points", series.alpha.points},
                           {"alpha", granuscope::to_json(series.alpha.exponent)}});
    }
    return {{"responses", responses}, {"exponents", exponents}};
  }

  std::vector<ReportPart> parts(const Json& results) const override {
    const ReportPart tables = part(id(), "responses");
    return measured_.empty() ? std::vector{tables} : std::vector{page_1(page_1_overlay(results)), tables};
  }

  std::vector<FigurePlot> figures(const Analysis&) const override {
    if (measured_.empty()) return {};
    return {[this](const std::filesystem::path& folder) { return plot_models(measured_, id(), folder); }};
  }

 private:
  /// Layers between a third of the depth and all of it, some 25 of them, as far apart in z for every model.
  FitSpec fit_of(const ModelSpec& model) const {
    const RowGeometry rows = rows_of(model);
    constexpr int depths = 25;
    FitSpec fit;
    fit.last_layer = static_cast<int>((depth_ - rows.depth(0)) / rows.spacing);
    fit.first_layer = fit.last_layer / 3;
    // An odd step: rows of both kinds.
    fit.layer_step = std::max(1, (fit.last_layer - fit.first_layer) / depths) | 1;
    fit.shallow_layer = fit.first_layer;
    return fit;
  }

  std::vector<Wanted> wanted_of(const MainLine& main) const {
    std::vector<Wanted> all;
    const auto add = [&](const std::string& series, const std::string& parameter, const std::string& file,
                         const auto& change) {
      all.push_back({series, parameter, "model-" + file, SamplerSpec{}});
      Wanted& one = all.back();
      one.sampler.seed = main.sampling.seed;
      change(one.sampler);
    };
    for (const double mu : mu_) {
      add("beads", fmt::format("μ = {}", mu), fmt::format("beads-mu-{}", exact(mu)),
          [&](SamplerSpec& spec) { spec = main.sampler_for(mu); });
    }
    const auto add_legs = [&](MiddleLaw law, const std::vector<double>& values, const char* symbol) {
      for (const double value : values) {
        add("three-leg, " + name_of(law), fmt::format("{} = {}", symbol, value),
            fmt::format("three-leg-{}-{}", name_of(law), exact(value)), [&](SamplerSpec& spec) {
              spec.model.name = ModelName::three_leg;
              ThreeLegSpec& legs = spec.model.three_leg;
              legs.law = law;
              if (law == MiddleLaw::positive) {
                legs.share = value;
              } else {
                legs.middle = value;
                legs.noise = std::min(noise_ * value, 1 - value);
              }
            });
      }
    };
    add_legs(MiddleLaw::free, three_leg_free_, "p");
    add_legs(MiddleLaw::positive, three_leg_positive_, "share of p_max");
    add_legs(MiddleLaw::clipped, three_leg_clipped_, "p");
    for (const double disorder : osl_) {
      add("stochastic OSL", fmt::format("Δ = {}", disorder), fmt::format("stochastic-osl-{}", exact(disorder)),
          [&](SamplerSpec& spec) {
            spec.model.name = ModelName::stochastic_osl;
            spec.model.stochastic_osl = {disorder, cells_, cells_, grid_};
          });
    }
    for (const SplitLaw split : {SplitLaw::critical, SplitLaw::beta, SplitLaw::uniform}) {
      if (!q_model_) break;
      add("q-model", "q " + name_of(split), "q-model-" + name_of(split), [&](SamplerSpec& spec) {
        spec.model.name = ModelName::q_model;
        spec.model.q_model.split = split;
      });
    }
    return all;
  }

  std::vector<double> mu_;
  bool q_model_ = false;
  std::vector<double> three_leg_free_, three_leg_positive_, three_leg_clipped_, osl_;
  double noise_ = 0.5;  ///< of the mean share
  int grid_ = 4, cells_ = 4;
  int columns_ = 256;
  double depth_ = 100;            ///< bead diameters
  std::uint64_t samples_ = 8192;  ///< of each model but the costly ones
  static constexpr std::uint64_t costly = 4;
  double epsilon_ = 0.2;

  int threads_ = 0;
  std::vector<Wanted> wanted_;
  std::vector<MeasuredModel> replicated_;
  std::vector<ModelSeries> measured_;  ///< in the order of the keys
};

}  // namespace

std::unique_ptr<Study> models_study(std::vector<ModelSeries> measured) {
  return std::make_unique<ModelsStudy>(std::move(measured));
}

}  // namespace granuscope
