#include <utility>

#include "analysis/double_gaussian.h"
#include "ensemble/estimator.h"
#include "studies/model_classes/results.h"
#include "studies/study.h"

namespace granuscope {
namespace {
/// One ensemble of the study before it is drawn.
struct Wanted {
  std::string series, parameter, file;
  SamplerSpec sampler;
  bool aside = false;     ///< ModelSeries::aside
  bool traction = false;  ///< not for its response
  bool deep = false;      ///< followed by its fluctuations
};

class ModelsStudy final : public CopiedStudy<ModelsStudy> {
 public:
  explicit ModelsStudy(MeasuredModels measured) : measured_(std::move(measured)) {}

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
        make_key(table(), "bead_weights", "loads of one top bead",
                 "weights that the beads have by themselves, at the largest mu of the study: gravity", bead_weights_,
                 list(KeyRange{}.within(0, most_bead_weight).above(0), "beads without weight are measured anyway")),
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
        make_key(table(), "three_leg_cells", "",
                 "three-leg model, noise alike in cells: standard deviations of the share of the middle leg, whose "
                 "mean is 0.3",
                 three_leg_cells_,
                 list(KeyRange{}.within(0, middle_of_cells / sqrt3).above(0), "a uniform share would fall below 0")),
        make_key(table(), "traction_noise", "",
                 "at which depth legs of three_leg_free begin to pull under a uniform load, with the share uniform on "
                 "the mean plus and minus so much of it",
                 traction_noise_, list(KeyRange{}.within(0, 1).above(0), "a share is never negative")),
        make_key(table(), "stochastic_osl", "",
                 "stochastic OSL: standard deviations of the noise v in sigma_xx = (1 + v) sigma_zz / 3", osl_,
                 list(KeyRange{}.within(0, 0.57).above(0), "a uniform v would reach -1, where no wave propagates")),
        make_key(table(), "osl_grid", "nodes per bead diameter", "stochastic OSL: fineness of the explicit scheme",
                 grid_, KeyRange{}.within(1, 16)),
        make_key(table(), "osl_coarser_grids", "nodes per bead diameter",
                 "stochastic OSL: other grids to measure the largest disorder with, which show how far the scheme has "
                 "converged",
                 coarser_grids_, KeyRange{.longest = 8, .ascending = true}.within(1, 16)),
        make_key(table(), "osl_cells", "bead diameters, rows",
                 "stochastic OSL and three_leg_cells: width and height of the cells within which noise is the same; "
                 "must divide the columns",
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
        make_key(table(), "deep_octaves", "octaves",
                 "doublings of the depth, from 16 rows on, over which the models with two peaks, each with the last of "
                 "its values, are followed by their fluctuations; 0: not at all",
                 deep_octaves_, KeyRange{.or_zero = true}.within(3, 11)),
        make_key(table(), "deep_samples", "piles", "piles of each that are followed, at least eight per block",
                 deep_samples_),
        make_key(table(), "epsilon", "loads of one top bead", "by how much each top load is raised or lowered",
                 epsilon_, KeyRange{}.within(least_epsilon, epsilon_limit).below(epsilon_limit))};
  }

  bool asked() const override {
    return q_model_ || !mu_.empty() || !three_leg_free_.empty() || !three_leg_positive_.empty() ||
           !three_leg_clipped_.empty() || !osl_.empty() || !three_leg_cells_.empty() || !bead_weights_.empty();
  }

  Problem find_problem(const MainLine& main) const override {
    if (!bead_weights_.empty() && mu_.empty()) {
      return problem(key("bead_weights"), "heavy beads need a friction coefficient, and {} names none; give some",
                     key("mu"));
    }
    if (!traction_noise_.empty() && three_leg_free_.empty()) {
      return problem(key("traction_noise"), "tractions appear about a mean share, and {} names none; give some",
                     key("three_leg_free"));
    }
    if (!coarser_grids_.empty() && osl_.empty()) {
      return problem(key("osl_coarser_grids"), "a grid needs noise to be measured with, and {} names none; give some",
                     key("stochastic_osl"));
    }
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
    if (deep_octaves_ > 0) {
      if (auto found = find_samples_problem(key("deep_samples"), deep_samples_, main.response.blocks)) return found;
    }
    return find_samples_problem(key("samples"), samples_, main.response.blocks);
  }

  std::vector<StudyEnsemble> ensembles(const MainLine& main) const override {
    std::vector<StudyEnsemble> all;
    const std::vector<Wanted> wanted = wanted_of(main);
    for (std::size_t k = 0; k < wanted.size(); ++k) {
      const Wanted& one = wanted[k];
      const std::string label = one.parameter.empty() ? one.series : fmt::format("{}, {}", one.series, one.parameter);
      if (one.deep) {
        all.push_back({label + ", deep", one.file, deep_spec(one.sampler, main.response.blocks), static_cast<int>(k)});
        continue;
      }
      const FitSpec fit = fit_of(one.sampler.model);
      EnsembleSpec spec;
      spec.sampler = one.sampler;
      spec.lattice = {columns_, fit.last_layer + bottom_margin + 1};
      spec.response.estimator = EstimatorName::multiplexed;
      spec.response.epsilon = epsilon_;
      spec.response.blocks = main.response.blocks;
      spec.response.samples = samples_;
      if (one.traction) {
        spec.lattice.layers = traction_rows;
        spec.response.estimator = EstimatorName::point;
        spec.response.samples = group_size * static_cast<std::uint64_t>(main.response.blocks);
        spec.load = Load::uniform;
        spec.record_profiles = false;
        all.push_back({label, one.file, spec, static_cast<int>(k)});
        continue;
      }
      const ModelName model = one.sampler.model.name;
      // What a load at the top does is lost among heavy beads the sooner.
      if ((model == ModelName::frictional_beads && !one.aside) || model == ModelName::stochastic_osl) {
        const auto least = group_size * static_cast<std::uint64_t>(main.response.blocks);
        spec.response.samples = std::max(samples_ / costly, least);
      }
      // Of beads the stresses from the top on are shown.
      std::vector<int> shallow;
      if (model == ModelName::frictional_beads) {
        for (int layer = 1; layer < fit.first_layer; layer += (layer + 1) / 2) shallow.push_back(layer);
      }
      spec.layers = layers_to_record(fit, shallow);
      all.push_back({label, one.file, spec, static_cast<int>(k)});
    }
    return all;
  }

  void prepare() override { wanted_ = wanted_of(main_); }
  void add(const StudyEnsemble& which, const MeasuredEnsemble& ensemble) override {
    const Wanted& wanted = wanted_.at(static_cast<std::size_t>(which.part));
    if (wanted.traction) {
      measured_.tractions.push_back(measure_traction(ensemble));
      return;
    }
    if (wanted.deep) {
      DeepModel one{wanted.series, wanted.parameter,
                    measure_spreading(ensemble, DeepMeasurement::fluctuations, threads_)};
      const FormFit fit = fit_waves(one.response.bands);
      // Of what spreads as z, or less, no wave is faster than the others.
      const bool faster = fit.B.known() && fit.B.value > 3 * fit.B.standard_error;
      one.shapes = test_shapes(ensemble, one.response,
                               faster ? SoundForm{one.response.c_thrust.value, fit.D.value, fit.B.value} : SoundForm{});
      measured_.deep.push_back(std::move(one));
      return;
    }
    asides_.push_back(wanted.aside);
    replicated_.push_back(
        measure_model(ensemble, fit_of(ensemble.spec.sampler.model), wanted.series, wanted.parameter, threads_));
  }

  void finish() override {
    for (auto one = replicated_.begin(); one != replicated_.end();) {
      ModelSeries& series = measured_.series.emplace_back();
      series.name = one->response.series;
      series.aside = asides_[static_cast<std::size_t>(one - replicated_.begin())];
      std::vector<const MeasuredModel*> members;
      for (; one != replicated_.end() && one->response.series == series.name; ++one) {
        series.responses.push_back(one->response);
        members.push_back(&*one);
      }
      series.alpha = slowing_against_spreading(members);
    }
    replicated_.clear();
    asides_.clear();
  }

  std::vector<Claim> claims(const ClaimSpec&) const override { return judge_models(measured_.series); }

  Json json() const override { return models_json(measured_); }

  std::vector<ReportPart> parts() const override {
    const ReportPart tables = part(id(), "responses");
    return measured_.series.empty() ? std::vector{tables} : std::vector{page_1(models_page_1(json())), tables};
  }

  std::vector<FigurePlot> figures(const Analysis&) const override {
    if (measured_.series.empty()) return {};
    std::vector<FigurePlot> all = {
        [this](const fs::path& folder) { return plot_models(measured_.series, id(), folder); }};
    const auto some = [this](const auto& fits) {
      return std::ranges::any_of(
          measured_.series, [&](const ModelSeries& series) { return std::ranges::any_of(series.responses, fits); });
    };
    if (some([](const ModelResponse& one) { return one.theory && one.speed_loss.known(); })) {
      all.emplace_back([this](const fs::path& folder) { return plot_noise(measured_.series, folder); });
    }
    const auto appears = [](const TractionDepth& one) { return one.z.known(); };
    if (std::ranges::any_of(measured_.tractions, appears) &&
        some([](const ModelResponse& one) { return one.middle.known() && one.c.known(); })) {
      all.emplace_back(
          [this](const fs::path& folder) { return plot_middle(measured_.series, measured_.tractions, folder); });
    }
    if (some([](const ModelResponse& one) { return one.bead_weight > 0; })) {
      all.emplace_back([this](const fs::path& folder) { return plot_gravity(measured_.series, folder); });
    }
    for (const ModelSeries& series : measured_.series) {
      if (series.aside || series.responses.empty()) continue;
      all.emplace_back([&series](const fs::path& folder) { return render_pile_of(series, folder); });
    }
    return all;
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
    add_asides(add, main, all);
    return all;
  }

  /// What has figures of its own: heavy beads, noise in cells, other grids, and piles whose legs come to pull.
  template <class Add>
  void add_asides(const Add& add, const MainLine& main, std::vector<Wanted>& all) const {
    const std::size_t first = all.size();
    for (const double weight : bead_weights_) {
      add(fmt::format("beads under gravity, μ = {}", mu_.back()), fmt::format("g = {}", weight),
          fmt::format("beads-weight-{}", exact(weight)), [&](SamplerSpec& spec) {
            spec = main.sampler_for(mu_.back());
            spec.bead_weight = weight;
          });
    }
    const auto legs = [&](SamplerSpec& spec, double middle, double noise) -> ThreeLegSpec& {
      spec.model.name = ModelName::three_leg;
      spec.model.three_leg.middle = middle;
      spec.model.three_leg.noise = std::min(noise, 1 - middle);
      return spec.model.three_leg;
    };
    for (const double disorder : three_leg_cells_) {
      add("three-leg, noise in cells", fmt::format("Δ = {:.3g}", disorder / (1 - middle_of_cells)),
          fmt::format("three-leg-cells-{}", exact(disorder)), [&](SamplerSpec& spec) {
            ThreeLegSpec& of_cells = legs(spec, middle_of_cells, disorder * sqrt3);
            of_cells.cell_columns = of_cells.cell_rows = cells_;
          });
    }
    for (const int grid : coarser_grids_) {
      add("stochastic OSL, other grids", fmt::format("{} nodes a bead", grid),
          fmt::format("stochastic-osl-grid-{}", grid), [&](SamplerSpec& spec) {
            spec.model.name = ModelName::stochastic_osl;
            spec.model.stochastic_osl = {osl_.back(), cells_, cells_, grid};
          });
    }
    for (std::size_t k = first; k < all.size(); ++k) all[k].aside = true;
    for (const double middle : three_leg_free_) {
      for (const double share : traction_noise_) {
        add("three-leg, uniform load", fmt::format("p = {} ± {:.3g}", middle, share * middle),
            fmt::format("three-leg-traction-{}-{}", exact(middle), exact(share)),
            [&](SamplerSpec& spec) { legs(spec, middle, share * middle); });
        all.back().traction = true;
      }
    }
    if (deep_octaves_ > 0) add_deep(all);
  }

  /// Of each series with two peaks whose rows are handed down one by one, the last one.
  static void add_deep(std::vector<Wanted>& all) {
    std::vector<Wanted> deep;
    for (std::size_t k = 0; k < all.size(); ++k) {
      const Wanted& one = all[k];
      const bool last = k + 1 == all.size() || all[k + 1].series != one.series;
      const ModelSpec& model = one.sampler.model;
      if (!last || one.aside || one.traction || model.has_contacts() || speed_without_disorder(model) == 0) continue;
      deep.push_back(one);
      deep.back().file += "-deep";
      deep.back().deep = true;
    }
    all.insert(all.end(), deep.begin(), deep.end());
  }

  /// Rings on which the peaks never meet, and as many bases as the deepest lag has rows.
  EnsembleSpec deep_spec(const SamplerSpec& sampler, int blocks) const {
    // Rows hand on what single beads have for themselves within few of them, so that a short reference will do: modes
    // that have decayed by it are drowned in noise.
    constexpr int first_lag = 16;
    const int last_lag = first_lag << deep_octaves_, whole = 64 * cells_;
    EnsembleSpec spec;
    spec.sampler = sampler;
    spec.lattice.columns = (static_cast<int>(columns_needed(sampler, last_lag)) / whole + 1) * whole;
    spec.response.estimator = EstimatorName::fluctuation;
    spec.response.base_step = spec.response.reference_lag = first_lag;
    spec.response.blocks = blocks;
    spec.response.samples = deep_samples_;
    for (int lag = first_lag; lag <= last_lag; lag *= 2) spec.layers.push_back(lag);
    spec.lattice.layers = last_lag;
    spec.lattice.layers += fluctuation_plan(spec).layers_needed;
    return spec;
  }

  static constexpr double middle_of_cells = 0.3;
  static constexpr int traction_rows = 600;

  std::vector<double> mu_, bead_weights_, three_leg_cells_, traction_noise_;
  std::vector<int> coarser_grids_;
  bool q_model_ = false;
  std::vector<double> three_leg_free_, three_leg_positive_, three_leg_clipped_, osl_;
  double noise_ = 0.5;  ///< of the mean share
  int grid_ = 4, cells_ = 4;
  int columns_ = 256;
  double depth_ = 100;            ///< bead diameters
  std::uint64_t samples_ = 8192;  ///< of each model but the costly ones
  static constexpr std::uint64_t costly = 4;
  double epsilon_ = 0.2;
  int deep_octaves_ = 0;
  std::uint64_t deep_samples_ = 256;

  std::vector<Wanted> wanted_;
  std::vector<MeasuredModel> replicated_;
  std::vector<bool> asides_;  ///< of each of them
  MeasuredModels measured_;   ///< in the order of the keys
};

}  // namespace

std::unique_ptr<Study> models_study(MeasuredModels measured) {
  return std::make_unique<ModelsStudy>(std::move(measured));
}

}  // namespace granuscope
