#include <numbers>

#include "ensemble/estimator.h"
#include "plot/growing_panel.h"
#include "studies/study.h"

// The balances of beads whose contacts stand at another angle are those of 30 degrees with H stretched by
// tan 30°/tan(angle); then only the cone differs, t/tan(angle) = 1 +- 2 mu/sin(2 angle) + mu^2/cos^2(angle). Its shift,
// the last term, is of the order of the squared width, as 1 - c/c0 and what a layer adds to W^2 are (by 1 - kappa,
// which alone widens waves of a lattice): over mu^2/sin^2(2 angle) both depend on the angle, also as mu -> 0.
namespace granuscope {
namespace {
/// The linear response at one angle and friction.
struct ResponseAtAngle {
  EnsembleSpec spec;
  std::uint64_t samples = 0;
  double c0 = 0;
  Estimate c, D, c_thrust;
  Estimate share;     ///< c/c0
  Estimate slowing;   ///< (1 - c/c0)/mu^2
  Estimate widening;  ///< what a layer adds to W^2, squared distances of neighbours, over mu^2/sin^2(2 angle)
};

Estimate times(const Estimate& one, double factor) {
  Estimate scaled = one;
  scaled.value *= factor;
  scaled.standard_error *= std::abs(factor);
  scaled.systematic *= std::abs(factor);
  return scaled;
}

void to_json(Json& json, const ResponseAtAngle& one) {
  json = {{"angle", one.spec.lattice.angle},
          {"mu", one.spec.sampler.mu},
          {"columns", one.spec.lattice.columns},
          {"layers", one.spec.lattice.layers},
          {"samples", one.samples},
          {"c0", one.c0},
          {"c", one.c},
          {"c_over_c0", one.share},
          {"D", one.D},
          {"c_thrust", one.c_thrust},
          {"slowing", one.slowing},
          {"widening", one.widening}};
}

class ContactAngleStudy final : public CopiedStudy<ContactAngleStudy> {
 public:
  std::string id() const override { return "contact_angle"; }

  std::vector<Key> keys() override {
    return {make_key(table(), "angles", "degrees",
                     "angles of the contacts at which the linear response is compared; none: not at all", angles_,
                     KeyRange{.longest = 6, .ascending = true}.within(least_angle, most_angle)),
            make_key(table(), "mu", "", "friction coefficients of each, where below 1/tan(angle)", mu_,
                     friction_range_above_zero()),
            make_key(table(), "samples", "piles", "piles per angle and friction coefficient, at least eight per block",
                     samples_)};
  }

  bool asked() const override { return !angles_.empty(); }
  bool suits_any_angle() const override { return true; }

  Problem find_problem(const MainLine& main) const override {
    if (ensembles(main).empty()) {
      return problem(key("mu"), "at none of these angles beads can have such friction; give some below {:.4g}",
                     BeadGeometry(angles_.front()).cotangent);
    }
    for (const StudyEnsemble& one : ensembles(main)) {
      if (auto found = find_lattice_problem(key("mu"), one.spec.lattice.columns, "lattice.layers",
                                            one.spec.lattice.layers, bottom_margin + 1, drawing_memory(one.spec))) {
        return found;
      }
    }
    return find_samples_problem(key("samples"), samples_, main.response.blocks);
  }

  std::vector<StudyEnsemble> ensembles(const MainLine& main) const override {
    std::vector<StudyEnsemble> all;
    for (const double angle : angles_) {
      for (const double mu : mu_) {
        if (!(mu < BeadGeometry(angle).cotangent)) continue;
        EnsembleSpec spec = main.ensemble_at(mu, {fewest_columns, main.lattice.layers, angle}, samples_);
        constexpr double handy = 16;  // for the Fourier transforms
        const double needed = columns_needed(like_at_30(spec), main.fit.last_layer);
        spec.lattice.columns = static_cast<int>(handy * std::ceil(needed / handy));
        spec.response.estimator = EstimatorName::multiplexed;
        spec.response.epsilon = main.response.epsilon;
        FitSpec fit = main.fit;
        fit.shallow_layer = fit.first_layer;
        spec.layers = layers_to_record(fit, {});
        all.push_back({fmt::format("contacts at {} degrees, mu = {}", angle, mu),
                       fmt::format("contact-angle-{}-mu-{}", exact(angle), exact(mu)), spec});
      }
    }
    return all;
  }

  void add(const StudyEnsemble& which, const MeasuredEnsemble& ensemble) override {
    const Transport found = measure_transport(ensemble, main_.fit, {}, threads_).transport;
    const BeadGeometry geometry(which.spec.lattice.angle);
    const double mu = which.spec.sampler.mu, small = mu / std::sin(2 * geometry.angle * std::numbers::pi / 180);
    ResponseAtAngle one{which.spec, found.samples, geometry.tangent, found.c, found.D, found.c_thrust, {}, {}, {}};
    one.share = times(found.c, 1 / geometry.tangent);
    one.slowing = times(found.c, -1 / geometry.tangent / mu / mu);
    one.slowing.value += 1 / mu / mu;
    one.widening = times(found.D, found.rows().spacing / std::pow(geometry.twice_sine * small, 2));
    measured_.push_back(one);
  }

  Json json() const override { return measured_; }
  std::vector<ReportPart> parts() const override { return {table_part()}; }

  std::vector<FigurePlot> figures(const Analysis&) const override {
    if (measured_.empty()) return {};
    return {[this](const fs::path& folder) { return plot(folder); }};
  }

 private:
  Figure plot(const fs::path& folder) const {
    Plot plot = two_panels("contact-angle");
    plot.key.lines = 2;
    plot.key.inches = 0.5;
    GrowingPanel speed{"friction coefficient μ", "c/c₀"},
        spreading{"friction coefficient μ", "D  (bead diameters)", true};
    std::vector<std::string> speeds;
    for (std::size_t k = 0; k < angles_.size(); ++k) {
      CurveRows shares, spreads;
      for (const ResponseAtAngle& one : measured_) {
        const double mu = one.spec.sampler.mu;
        if (one.spec.lattice.angle != angles_[k]) continue;
        if (one.share.known()) shares.push_back({mu, one.share.value, one.share.standard_error});
        if (one.D.known() && one.D.value > 0) spreads.push_back({mu, one.D.value, one.D.standard_error});
      }
      const Ink ink = ink_of_value(k);
      const std::string name = exact(angles_[k]), mu = "mu: dimensionless";
      speed.add(plot, name + "-speed", shares, ink.joined_bars(1, 0.6), mu, "c/c0: dimensionless");
      spreading.add(plot, name + "-spreading", spreads, ink.joined_bars(1, 0.6), mu, "D: bead diameters");
      plot.add_key("contacts at " + name + "°", ink.joined(1, 0.6));
      if (!shares.empty())
        speeds.push_back(fmt::format("{} ({}°)", value_with_error(shares.back()[1], shares.back()[2]), name));
    }
    return plot_panels(
        plot, speed, spreading,
        {{"piles", std::to_string(samples_)}, {"mu", caption_number(mu_.back())}, {"speeds", enumeration(speeds)}},
        folder);
  }

  std::vector<double> angles_, mu_{0.1, 0.2, 0.3};
  std::uint64_t samples_ = 256;
  std::vector<ResponseAtAngle> measured_;
};

}  // namespace

std::unique_ptr<Study> contact_angle_study() { return std::make_unique<ContactAngleStudy>(); }

}  // namespace granuscope
