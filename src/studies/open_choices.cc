// What the paper's text leaves open, tried one choice at a time: how much c, D and their powers depend on it.

#include "analysis/mean_response.h"
#include "analysis/scaling.h"
#include "plot/growing_panel.h"
#include "studies/study.h"

namespace granuscope {
namespace {
/// One choice made in another way.
struct OpenChoice {
  const char* name;  ///< in files and summary.json
  const char* label;
  std::function<void(EnsembleSpec&)> make;
};

constexpr double loads_beside = 0.05;  ///< bead radii: half of what friction bears at mu = 0.1

constexpr std::size_t drawn_angle = 1, displaced_loads = 6;  ///< places in the list of those that the caption tells

/// The program's own choices first.
const std::vector<OpenChoice>& open_choices() {
  static const std::vector<OpenChoice> all{
      {"as_it_is", "", [](EnsembleSpec&) {}},
      {"angle", "angle drawn", [](EnsembleSpec& spec) { spec.sampler.drawn = DrawnVariable::angle; }},
      {"ratio", "T/N drawn", [](EnsembleSpec& spec) { spec.sampler.drawn = DrawnVariable::ratio; }},
      {"rightwards", "one direction", [](EnsembleSpec& spec) { spec.sampler.order = LayerOrder::rightwards; }},
      {"four_parents", "four parents", [](EnsembleSpec& spec) { spec.sampler.rules = RepairRules::no_pair; }},
      {"no_arcs", "pair or backtrack", [](EnsembleSpec& spec) { spec.sampler.rules = RepairRules::no_arcs; }},
      {"beside", "loads beside", [](EnsembleSpec& spec) { spec.sampler.load_offset = loads_beside; }},
      {"narrow", "half as wide", [](EnsembleSpec& spec) { spec.lattice.columns = spec.lattice.columns / 4 * 2; }}};
  return all;
}

/// One choice at every friction coefficient.
struct ChoiceMeasured {
  std::vector<MeasuredTransport> peaks;
  std::vector<Replicated> slowing;  ///< tan 30 degrees - c_thrust
  ScalingFits fits;
  ScalingFit power_of_slowing;
};

Estimate relative_change(const Replicated& from, const Replicated& to) {
  if (from.without_block.empty() || to.without_block.empty()) return {std::nan(""), std::nan(""), "it is unknown"};
  return estimate(transform([](double of_it, double usual) { return of_it / usual - 1; }, to, from));
}

Json scaling_json(const ScalingFit& fit) {
  Json json = fit.exponent;
  if (fit.exponent.known() && fit.misses_the_points()) json.update({{"power_law", false}, {"about_law", fit.scatter}});
  return json;
}

class OpenChoicesStudy final : public CopiedStudy<OpenChoicesStudy> {
 public:
  std::string id() const override { return "open_choices"; }

  std::vector<Key> keys() override {
    return {make_key(table(), "mu", "",
                     "friction coefficients, three or more, at which choices that the paper leaves open are made in "
                     "other ways (linear response, the main line's lattice and fit); none: not at all",
                     mu_, friction_range_above_zero()),
            make_key(table(), "samples", "pairs", "pairs of a pile and its opposite for each choice and coefficient",
                     samples_)};
  }

  bool asked() const override { return !mu_.empty(); }

  Problem find_problem(const MainLine& main) const override {
    if (mu_.size() < 3) return problem(key("mu"), "a power needs three friction coefficients; give more, or none");
    const int half = main.lattice.columns / 4 * 2;
    if (half < columns_needed(mu_.back(), main.fit.last_layer)) {
      return problem(key("mu"),
                     "one of the choices is a pile half as wide, on which the peaks of layer {} are not apart; give "
                     "lattice.columns of at least {}",
                     main.fit.last_layer, std::ceil(2 * columns_needed(mu_.back(), main.fit.last_layer) + 2));
    }
    return find_samples_problem(key("samples"), samples_, main.response.blocks);
  }

  std::vector<StudyEnsemble> ensembles(const MainLine& main) const override {
    std::vector<StudyEnsemble> all;
    for (const OpenChoice& choice : open_choices()) {
      for (const double mu : mu_) {
        EnsembleSpec spec = main.ensemble_at(mu, main.lattice, samples_);
        spec.response = multiplexed_response(main.response.epsilon, true);
        spec.response.samples = samples_;
        spec.response.blocks = main.response.blocks;
        spec.layers = layers_to_record(main.fit, {});
        choice.make(spec);
        all.push_back({fmt::format("open choice {}, mu = {}", choice.name, mu),
                       fmt::format("open-choice-{}-mu-{}", choice.name, exact(mu)), spec,
                       static_cast<int>(&choice - open_choices().data())});
      }
    }
    return all;
  }

  void add(const StudyEnsemble& one, const MeasuredEnsemble& ensemble) override {
    measured_.resize(open_choices().size());
    ChoiceMeasured& choice = measured_[static_cast<std::size_t>(one.part)];
    choice.peaks.push_back(measure_transport(ensemble, main_.fit, {}, threads_));
    choice.slowing.push_back(
        transform([](double c) { return tan30 - c; }, thrust_speed(ensemble.record.sums, main_.fit.first_layer)));
  }

  void finish() override {
    for (ChoiceMeasured& choice : measured_) {
      choice.fits = fit_scaling(choice.peaks, {mu_.front(), mu_.back()});
      std::vector<Replicated> x, y;
      for (std::size_t k = 0; k < mu_.size(); ++k) {
        y.push_back(transform([](double slowing) { return std::log(slowing); }, choice.slowing[k]));
        x.push_back(transform([&](double) { return std::log(mu_[k]); }, y.back()));
      }
      choice.power_of_slowing = fit_power_law(x, y, {mu_.front(), mu_.back()});
    }
  }

  Json json() const override {
    Json json = Json::object();
    if (measured_.empty()) return json;
    json = {{"mu", mu_}, {"lowest_mu", mu_.front()}, {"highest_mu", mu_.back()}, {"samples", samples_}};
    for (std::size_t i = 0; i < measured_.size(); ++i) {
      const ChoiceMeasured &one = measured_[i], &usual = measured_.front();
      Json choice = {{"choice", open_choices()[i].name},
                     {"power_of_slowing", scaling_json(one.power_of_slowing)},
                     {"gamma", scaling_json(one.fits.gamma)},
                     {"beta", scaling_json(one.fits.beta)},
                     {"alpha", scaling_json(one.fits.alpha)}};
      for (std::size_t k = 0; k < mu_.size(); ++k) {
        choice["at"].push_back({{"mu", mu_[k]},
                                {"c0_minus_c_thrust", estimate(one.slowing[k])},
                                {"D", one.peaks[k].transport.D},
                                {"slowing_change", relative_change(usual.slowing[k], one.slowing[k])},
                                {"D_change", relative_change(usual.peaks[k].D, one.peaks[k].D)}});
      }
      choice["lowest"] = choice["at"].front();
      choice["highest"] = choice["at"].back();
      json["choices"].push_back(std::move(choice));
    }
    return json;
  }

  std::vector<ReportPart> parts() const override {
    if (measured_.empty()) return {};
    return {{.page = "studies/open_choices.table", .base = "/studies/open_choices", .needs = "choices"}};
  }

  std::vector<FigurePlot> figures(const Analysis&) const override {
    if (measured_.empty()) return {};
    return {[this](const fs::path& folder) {
      Plot plot = two_panels("open-choices");
      GrowingPanel left{"friction coefficient μ", "change of c₀ − c (thrust)  (%)"};
      GrowingPanel right{"friction coefficient μ", "change of D  (%)"};
      for (std::size_t i = 1; i < measured_.size(); ++i) {
        CurveRows slowing, D;
        for (std::size_t k = 0; k < mu_.size(); ++k) {
          const Estimate by_thrust = relative_change(measured_[0].slowing[k], measured_[i].slowing[k]);
          const Estimate by_width = relative_change(measured_[0].peaks[k].D, measured_[i].peaks[k].D);
          // Apart, where bars would cover each other.
          const double x = mu_[k] * (1 + 0.012 * (static_cast<double>(i) - 4));
          if (by_thrust.known()) slowing.push_back({x, 100 * by_thrust.value, 100 * by_thrust.standard_error});
          if (by_width.known()) D.push_back({x, 100 * by_width.value, 100 * by_width.standard_error});
        }
        const Ink ink = ink_of_series(i - 1);
        const std::string name = open_choices()[i].name;
        left.add(plot, "thrust-" + name, slowing, ink.joined_bars(0.8, 0.5), "mu: dimensionless", "change: %");
        right.add(plot, "D-" + name, D, ink.joined_bars(0.8, 0.5), "mu: dimensionless", "change: %");
        plot.add_key(open_choices()[i].label, ink.points(0.6));
      }
      for (GrowingPanel* panel : {&left, &right}) panel->panel.add_level(0, {.colour = "frame", .width = 0.8});
      const auto change = [&](std::size_t choice, std::size_t k) {
        const Estimate moved = relative_change(measured_[0].slowing[k], measured_[choice].slowing[k]);
        return value_with_error(100 * moved.value, 100 * moved.standard_error);
      };
      return plot_panels(plot, left, right,
                         {{"pairs", std::to_string(samples_)},
                          {"angle_low", change(drawn_angle, 0)},
                          {"angle_high", change(drawn_angle, mu_.size() - 1)},
                          {"beside_low", change(displaced_loads, 0)},
                          {"beside_high", change(displaced_loads, mu_.size() - 1)},
                          {"beside", caption_number(loads_beside)}},
                         folder);
    }};
  }

 private:
  std::vector<double> mu_;  ///< each above 0; empty: not measured
  std::uint64_t samples_ = 256;
  std::vector<ChoiceMeasured> measured_;  ///< in the order of open_choices
};

}  // namespace

std::unique_ptr<Study> open_choices_study() { return std::make_unique<OpenChoicesStudy>(); }

}  // namespace granuscope
