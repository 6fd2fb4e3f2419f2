// The paper's words taken literally: c = x_p/z and D = W^2/z at one depth z, with its Eq. (1) sampled at the bead
// centres (integrating it over a bead, as the main fits do, takes 1/12 off W^2), by plain least squares in x.

#include <array>
#include <map>
#include <numbers>
#include <optional>

#include "analysis/claims.h"
#include "analysis/mean_response.h"
#include "analysis/scaling.h"
#include "plot/plot.h"
#include "plot/power_law_panel.h"
#include "studies/study.h"

namespace granuscope {
namespace {
/// The paper's exponents: c0 - c against mu, D against mu, c0 - c against D.
struct PaperExponent {
  const char *name, *symbol;
  PaperNumber number;
  std::optional<Rival> rival;
  ReplicatedPowerLaw ReplicatedFits::*fit;
  const char* x;  ///< what it is a power of

  const ScalingFit& fit_of(const ReplicatedFits& found) const { return (found.*fit).fit; }
  const Estimate& of(const ReplicatedFits& found) const { return fit_of(found).exponent; }
};
const std::array<PaperExponent, 3> paper{
    {{"gamma", "γ of xₚ/z", paper_gamma, second_order, &ReplicatedFits::gamma, "μ"},
     {"beta", "β of W²/z", paper_beta, std::nullopt, &ReplicatedFits::beta, "μ"},
     {"alpha", "α of xₚ/z against W²/z", paper_alpha, linear_in_D, &ReplicatedFits::alpha, "D"}}};

/// x_p and W of one response, bead diameters.
struct PeakReading {
  double peak = 0, width = 1;
};

/// A mirror-symmetric response P(x) at distances x >= 0 from its centre. `count`: beads at that distance, 1 or 2.
struct HalfResponse {
  std::vector<double> x, y, count;
};

HalfResponse half_of(const std::vector<double>& response, int kind_of_row, const Lattice& lattice) {
  std::map<long, std::array<double, 2>> at;  // by 2|x|
  for (int bead = 0; bead < lattice.columns(); ++bead) {
    std::array<double, 2>& sum = at[std::lround(2 * std::abs(lattice.x(kind_of_row, bead)))];
    sum[0] += response[static_cast<std::size_t>(bead)];
    sum[1] += 1;
  }
  HalfResponse half;
  for (const auto& [twice, sum] : at) {
    half.x.push_back(static_cast<double>(twice) / 2);
    half.y.push_back(sum[0] / sum[1]);
    half.count.push_back(sum[1]);
  }
  return half;
}

/// The normal equations of the two mirror Gaussians at `at`, and the sum of squared residuals. What lies further than
/// 10 widths from a peak adds to the sum what no reading changes, and is left out.
struct Normal {
  double pp = 0, pw = 0, ww = 0, rp = 0, rw = 0, sum = 0;
};
Normal normal_at(const HalfResponse& half, const PeakReading& at, double columns) {
  Normal n;
  for (std::size_t i = 0; i < half.x.size(); ++i) {
    double g = 0, by_peak = 0, by_width = 0;
    for (const double side : {half.x[i] - at.peak, half.x[i] + at.peak, half.x[i] + at.peak - columns}) {
      const double u = side / at.width;
      if (std::abs(u) > 10) continue;
      const double e = std::exp(-u * u / 2) / (2 * std::sqrt(2 * std::numbers::pi) * at.width);
      g += e;
      by_peak += (side == half.x[i] - at.peak ? 1 : -1) * e * u / at.width;
      by_width += e * (u * u - 1) / at.width;
    }
    const double rest = half.y[i] - g, w = half.count[i];
    n.sum += w * (rest * rest - half.y[i] * half.y[i]);
    n.pp += w * by_peak * by_peak;
    n.pw += w * by_peak * by_width;
    n.ww += w * by_width * by_width;
    n.rp += w * rest * by_peak;
    n.rw += w * rest * by_width;
  }
  return n;
}

/// Levenberg and Marquardt from `start`; none if it does not converge.
std::optional<PeakReading> read(const HalfResponse& half, PeakReading start, double columns) {
  Normal now = normal_at(half, start, columns);
  double damping = 1e-3;
  for (int step = 0; step < 200; ++step) {
    const double pp = now.pp * (1 + damping), ww = now.ww * (1 + damping), det = pp * ww - now.pw * now.pw;
    const PeakReading next{start.peak + (ww * now.rp - now.pw * now.rw) / det,
                           start.width + (pp * now.rw - now.pw * now.rp) / det};
    if (!std::isfinite(next.peak) || !(next.width > 0.1)) {
      damping *= 10;
      if (damping > 1e9) return {};
      continue;
    }
    const Normal tried = normal_at(half, next, columns);
    const double moved = std::abs(next.peak - start.peak) + std::abs(next.width - start.width);
    if (tried.sum <= now.sum) {
      start = next;
      now = tried;
      damping = std::max(damping / 10, 1e-12);
      if (moved < 1e-9) return start;
    } else {
      if (moved < 1e-9) return start;
      damping *= 10;
    }
  }
  return {};
}

/// One friction coefficient at one depth.
struct DepthReading {
  int layer = 0;
  double z = 0;
  Replicated peak, width_squared;        ///< Eq. (1) at the bead centres
  Replicated peak_inside, width_inside;  ///< integrated over a bead, W^2; weights of the main fits
};

struct FrictionReading {
  double mu = 0;
  std::vector<DepthReading> depths;
};

Replicated without_value(std::size_t blocks) {
  const double nan = std::nan("");
  return {nan, std::vector<double>(blocks, nan)};
}

/// Both readings at recorded layer number `row`; not numbers where a fit does not converge.
DepthReading read_depth(const MeasuredEnsemble& ensemble, std::size_t row) {
  const BlockSums& sums = ensemble.record.sums;
  const Lattice lattice({response_columns(ensemble.spec), 2});
  DepthReading result;
  result.layer = sums.layers[row];
  const int kind_of_row = sums.rows.shifted(result.layer) ? 1 : 0;
  result.z = Lattice::depth(result.layer);
  const double overload = ensemble.spec.response.overload, columns = lattice.columns();
  const BlockMeans response = mean_response(sums, row, overload);
  const LayerSpectrum spectrum = layer_spectrum(sums, row, overload);
  const std::size_t blocks = response.without_block.size();
  result.peak = result.width_squared = result.peak_inside = result.width_inside = without_value(blocks);
  if (spectrum.exact) {  // rays: nothing to fit, and no width
    double distance = 0;
    for (int bead = 0; bead < lattice.columns(); ++bead) {
      distance += std::abs(lattice.x(kind_of_row, bead)) * response.whole[static_cast<std::size_t>(bead)];
    }
    result.peak = {distance, std::vector<double>(blocks, distance)};
    result.width_squared = {0, std::vector<double>(blocks, 0)};
    return result;
  }
  const DoubleGaussian coarse = coarse_shape(spectrum, result.z);
  const auto whole =
      read(half_of(response.whole, kind_of_row, lattice), {coarse.peak, std::max(coarse.width, 0.4)}, columns);
  const auto inside = weighted_shape(spectrum, spectrum.modes(), ModeWeights::by_width, coarse);
  if (whole) result.peak.value = whole->peak, result.width_squared.value = whole->width * whole->width;
  if (inside) result.peak_inside.value = inside->peak, result.width_inside.value = inside->width * inside->width;
  for (std::size_t b = 0; b < blocks; ++b) {
    if (whole) {
      if (const auto one = read(half_of(response.without_block[b], kind_of_row, lattice), *whole, columns)) {
        result.peak.without_block[b] = one->peak;
        result.width_squared.without_block[b] = one->width * one->width;
      }
    }
    if (inside) {
      if (const auto one = weighted_shape(spectrum, spectrum.modes_without(b), ModeWeights::by_width, *inside)) {
        result.peak_inside.without_block[b] = one->peak;
        result.width_inside.without_block[b] = one->width * one->width;
      }
    }
  }
  return result;
}

/// Whether each of the paper's three numbers lies within two standard errors and its own.
bool meets_the_paper(const ReplicatedFits& found) {
  return std::ranges::all_of(paper, [&](const PaperExponent& one) {
    const Estimate& read = one.of(found);
    return read.known() && std::abs(read.value - one.number.value) <= 2 * read.standard_error + one.number.error;
  });
}

/// Sum of the squared distances from the paper's numbers, in standard errors of both.
double distance_from_paper(const ReplicatedFits& found) {
  double sum = 0;
  for (const PaperExponent& one : paper) {
    const Estimate& read = one.of(found);
    sum += std::pow((read.value - one.number.value) / std::hypot(read.standard_error, one.number.error), 2);
  }
  return sum;
}

Json exponents_json(const ReplicatedFits& found) {
  Json json;
  for (const PaperExponent& one : paper) {
    const ScalingFit& fit = (found.*one.fit).fit;
    json[one.name] = fit.exponent;
    if (fit.exponent.known() && fit.misses_the_points())
      json[one.name].update({{"power_law", false}, {"about_law", fit.scatter}});
  }
  return json;
}

/// One depth at which one may read.
struct DepthExponents {
  int layer = 0;
  double z = 0;
  ReplicatedFits literal, from_load;
  double ratio_without_friction = std::nan("");  ///< x_p/z at mu = 0, which the paper gives as tan 30 degrees
};

/// gamma and alpha, and beside them beta, against the depth at which c and D are read. `met`: the depths of all three.
Figure plot_literal_reading(const std::vector<DepthExponents>& depths, const DepthExponents& best,
                            const std::vector<double>& met, const std::filesystem::path& run_folder) {
  Plot plot;
  plot.id = "literal-reading";
  plot.height = 2.2;
  const std::array<const char*, 3> symbols{"γ", "β", "α"};
  // Another reading than the slopes: each exponent has its marker, all have its colour.
  const std::array<Ink, 3> inks{Ink{"vermilion", 13}, Ink{"vermilion", 5}, Ink{"vermilion", 9}};
  std::array<Panel, 2> panels{left_panel(), right_panel()};
  Range z;
  std::array<Range, 2> shown;  // of gamma and alpha, and of beta
  CsvTable from_load({"z: bead diameters", "gamma: dimensionless"});
  for (const DepthExponents& depth : depths) {
    z.add(depth.z);
    const double gamma = paper[0].of(depth.from_load).value;
    from_load.add_row({depth.z, gamma});
    shown[0].add(gamma);
  }
  for (std::size_t i = 0; i < paper.size(); ++i) {
    const std::string name = paper[i].name;
    CsvTable table({"z: bead diameters", name + ": dimensionless", "standard_error: dimensionless",
                    "chi2_per_dof: dimensionless"});
    for (const DepthExponents& depth : depths) {
      const ScalingFit& fit = paper[i].fit_of(depth.literal);
      const Estimate& one = fit.exponent;
      table.add_row({depth.z, one.value, one.standard_error, fit.scatter.chi2 / fit.scatter.degrees_of_freedom});
      shown[i == 1].add(one.value, one.standard_error);
    }
    shown[i == 1].add(paper[i].number.value);
    panels[i == 1].add(plot.add_data(name, table), "1:2:3", inks[i].bars(0.8, 0.45), symbols[i]);
  }
  panels[0].add(plot.add_data("gamma-from-load", from_load), "1:2", inks[0].line(0.9));
  for (std::size_t p = 0; p < panels.size(); ++p) {
    Panel& panel = panels[p];
    panel.x = linear_axis("depth z at which c and D are read", widened(z, 0.03), 6);
    panel.y = linear_axis(p == 0 ? "exponents γ and α" : "exponent β", widened(shown[p], 0.08), 6);
    panel.top = 0.08;
    for (std::size_t i = 0; i < paper.size(); ++i) {
      if ((i == 1) == (p == 1)) panel.add_level(paper[i].number.value, {"lines", "black", 1.2, 3});
    }
  }
  for (std::size_t i = 0; i < paper.size(); ++i) plot.add_key(symbols[i], inks[i].points(0.6));
  plot.add_key("γ from z − ½", inks[0].line(0.9));
  plot.add_key("the paper", {"lines", "black", 1.2, 3});
  plot.key.inches = 0.25;
  plot.key.horizontal = true;
  plot.panels.assign(panels.begin(), panels.end());
  return plot_figure(plot,
                     {"studies/literal_reading.captions",
                      {{"gamma", exponent_text(paper[0].fit_of(best.literal))},
                       {"beta", exponent_text(paper[1].fit_of(best.literal))},
                       {"alpha", exponent_text(paper[2].fit_of(best.literal))},
                       {"best", fmt::format("{:.1f}", best.z)},
                       {"met", met.empty() ? "" : "yes"},
                       {"from", met.empty() ? "" : fmt::format("{:.1f}", met.front())},
                       {"to", met.empty() ? "" : fmt::format("{:.1f}", met.back())}}},
                     run_folder);
}

class LiteralReading final : public CopiedStudy<LiteralReading> {
 public:
  std::string id() const override { return "literal_reading"; }

  std::vector<Key> keys() override {
    return {make_key(table(), "show", "",
                     "also read c = x_p/z and D = W^2/z at each recorded depth, as the paper's words say", show_)};
  }

  bool asked() const override { return show_; }

  Problem find_problem(const MainLine& main) const override {
    if (main.response.estimator == EstimatorName::point && main.sampling.model.name == ModelName::frictional_beads)
      return {};
    return problem(key("show"),
                   "the paper's procedure is read literally only where it was followed: by the estimator point on "
                   "beads; set it to false or response.estimator to \"point\"");
  }

  void add_main(const MainLine& main, const MeasuredEnsemble& ensemble) override {
    FrictionReading one{ensemble.spec.sampler.mu, {}};
    const BlockSums& sums = ensemble.record.sums;
    for (std::size_t row = 0; row < sums.layers.size(); ++row) {
      if (sums.layers[row] >= main.fit.shallow_layer) one.depths.push_back(read_depth(ensemble, row));
    }
    readings_.push_back(std::move(one));
  }

  void prepare() override { window_ = main_.fit.scaling_window; }

  void finish() override {
    if (readings_.empty()) return;
    std::vector<std::size_t> rows;  // of each depth in depths_
    for (std::size_t k = 0; k < readings_.front().depths.size(); ++k) {
      DepthExponents depth;
      depth.layer = readings_.front().depths[k].layer;
      depth.z = readings_.front().depths[k].z;
      depth.literal = fit_coefficients(points_at(k, depth.z), window_);
      depth.from_load = fit_coefficients(points_at(k, depth.z - Lattice::depth(0)), window_);
      for (const FrictionReading& one : readings_) {
        if (one.mu == 0) depth.ratio_without_friction = one.depths[k].peak.value / depth.z;
      }
      if (!std::ranges::all_of(paper, [&](const auto& one) { return one.of(depth.literal).known(); })) continue;
      if (meets_the_paper(depth.literal)) met_.push_back(depth.z);
      depths_.push_back(std::move(depth));
      rows.push_back(k);
    }
    if (depths_.empty()) return;
    const auto nearest = std::ranges::min_element(depths_, [](const auto& a, const auto& b) {
      return distance_from_paper(a.literal) < distance_from_paper(b.literal);
    });
    best_ = static_cast<std::size_t>(nearest - depths_.begin());
    const DepthExponents& best = depths_[best_];
    const std::size_t k = rows[best_];
    points_ = points_at(k, best.z);
    add_change("as_read", best.literal);
    add_change("depth_from_load", best.from_load);
    std::vector<Coefficients> integrated, smoothed;
    for (const FrictionReading& one : readings_) {
      if (one.mu == 0) continue;
      const DepthReading& at = one.depths[k];
      integrated.push_back({one.mu, over(at.peak_inside, at.z), over(at.width_inside, at.z)});
      if (k == 0 || k + 1 >= one.depths.size()) continue;
      std::vector<Replicated> c, D;
      for (std::size_t near = k - 1; near <= k + 1; ++near) {
        c.push_back(over(one.depths[near].peak, one.depths[near].z));
        D.push_back(over(one.depths[near].width_squared, one.depths[near].z));
      }
      smoothed.push_back({one.mu, mean_of(c), mean_of(D)});
    }
    add_change("integrated_over_a_bead", fit_coefficients(integrated, window_));
    add_change("mean_of_three_depths", fit_coefficients(smoothed, window_));
    std::vector<Coefficients> points = points_;
    std::erase_if(points,
                  [&](const auto& p) { return p.scanned < window_[0] - 1e-9 || p.scanned > window_[1] + 1e-9; });
    if (points.size() > static_cast<std::size_t>(min_power_law_points)) {
      add_change("without_lowest_mu", fit_coefficients(points, {points[1].scanned, window_[1]}));
      add_change("without_highest_mu", fit_coefficients(points, {window_[0], points[points.size() - 2].scanned}));
    }
  }

  std::vector<OtherReading> readings() const override {
    if (depths_.empty()) return {};
    const DepthExponents& best = depths_[best_];
    OtherReading reading{"at_one_depth", fmt::format("z = {:.1f}", best.z), {}, best.literal.shown()};
    for (const Coefficients& one : points_) reading.points.push_back({one.scanned, estimate(one.c), estimate(one.D)});
    return {reading};
  }

  // By the rule for numbers at the depth that comes nearest to the paper's three: the worst verdict counts, and of
  // equal ones the number farthest off is shown. One of the three makes up for the choice of the depth.
  std::vector<Claim> claims(const ClaimSpec&) const override {
    if (!asked()) return {};
    Claim claim = open_claim(
        "c-of-mu-as-read", "c₀ − c ∝ μ as the paper reads it: c = xₚ/z and D = W²/z at one depth have its γ, β and α.",
        paper[0].symbol);
    if (depths_.empty()) {
      leave_open(claim, "at no depth are c and D known at three friction coefficients of the window");
      return {claim};
    }
    const DepthExponents& best = depths_[best_];
    const auto rank = [](const Claim& one) {
      const std::array<const char*, 4> worst_last{reproduced, not_decided, not_tested, not_reproduced};
      const auto at = std::ranges::find(worst_last, one.verdict) - worst_last.begin();
      return std::pair(at, std::abs(one.z_score));
    };
    for (const PaperExponent& one : paper) {
      Claim tried = open_claim(claim.id, claim.statement, fmt::format("{}, z = {:.1f}", one.symbol, best.z));
      judge_by_number(tried, one.of(best.literal), one.number, one.rival, one.symbol);
      tried.power_law = !one.fit_of(best.literal).misses_the_points();
      if (!tried.power_law) tried.quantity += ", on average over μ";
      if (claim.verdict.empty() || rank(tried) > rank(claim)) claim = std::move(tried);
    }
    claim.explanation =
        fmt::format("At z = {:.1f} γ is {}, β {} and α {}. ", best.z, exponent_text(paper[0].fit_of(best.literal)),
                    exponent_text(paper[1].fit_of(best.literal)), exponent_text(paper[2].fit_of(best.literal))) +
        (met_.empty() ? "At no depth are all three within two errors of the paper’s numbers."
                      : fmt::format("All three are within two errors of the paper’s numbers at {} of {} depths, "
                                    "between z = {:.1f} and {:.1f}.",
                                    met_.size(), depths_.size(), met_.front(), met_.back()));
    for (const PaperExponent& one : paper) {
      if (const std::string misfit = misfit_sentence(one.fit_of(best.literal), one.x); !misfit.empty()) {
        add_sentence(claim, "Of {} at this depth: {}", one.symbol, misfit);
      }
    }
    add_sentence(claim,
                 "The paper prints no depth for its exponents: this one was chosen by them. Since α follows from the "
                 "other two, one number is left that tests it.");
    if (std::isfinite(best.ratio_without_friction)) {
      add_sentence(
          claim, "Against it speaks the paper’s own c = tan 30° = {:.4f} at μ = 0, where xₚ/z is {:.4f} at this depth.",
          tan30, best.ratio_without_friction);
    }
    return {claim};
  }

  std::vector<ReportPart> parts() const override {
    if (depths_.empty()) return {};
    return {
        {.page = "studies/literal_reading.table", .base = "/studies/literal_reading", .needs = "readings"},
        {.page = "studies/literal_reading_points.table", .base = "/studies/literal_reading/best", .needs = "points"}};
  }

  std::vector<FigurePlot> figures(const Analysis&) const override {
    if (depths_.empty()) return {};
    return {[this](const fs::path& folder) { return plot_literal_reading(depths_, depths_[best_], met_, folder); }};
  }

  Json json() const override {
    Json json = Json::object();
    if (depths_.empty()) return json;
    json["window"] = window_;
    json["depths"] = Json::array();
    for (const DepthExponents& one : depths_) {
      Json depth = {{"layer", one.layer}, {"z", one.z}};
      depth.update(exponents_json(one.literal));
      depth["from_load"] = exponents_json(one.from_load);
      if (std::isfinite(one.ratio_without_friction)) depth["ratio_without_friction"] = one.ratio_without_friction;
      depth["meets_the_paper"] = meets_the_paper(one.literal);
      json["depths"].push_back(std::move(depth));
    }
    Json best = json["depths"][best_];
    for (const Coefficients& one : points_) {
      best["points"].push_back({{"mu", one.scanned}, {"c", estimate(one.c)}, {"D", estimate(one.D)}});
    }
    json["best"] = std::move(best);
    json["met"] = {{"depths", met_.size()}};
    if (!met_.empty()) {
      json["met"]["first_z"] = met_.front();
      json["met"]["last_z"] = met_.back();
    }
    json["readings"] = Json::array();
    for (const auto& [found, shown] : changes_) {
      Json changed = {{"change", shown.change}};
      changed.update(exponents_json(found));
      changed.update(
          {{"gamma_shift", shown.gamma_shift}, {"beta_shift", shown.beta_shift}, {"alpha_shift", shown.alpha_shift}});
      json["readings"].push_back(std::move(changed));
    }
    return json;
  }

 private:
  static Replicated over(const Replicated& number, double depth) {
    return transform([depth](double value) { return value / depth; }, number);
  }

  std::vector<Coefficients> points_at(std::size_t k, double depth) const {
    std::vector<Coefficients> points;
    for (const FrictionReading& one : readings_) {
      if (one.mu == 0) continue;
      points.push_back({one.mu, over(one.depths[k].peak, depth), over(one.depths[k].width_squared, depth)});
    }
    return points;
  }

  void add_change(const char* change, const ReplicatedFits& found) {
    changes_.emplace_back(found, variation_of(depths_[best_].literal, change, found));
  }

  bool show_ = false;
  std::array<double, 2> window_{};
  std::vector<FrictionReading> readings_;  ///< ascending in mu, all with the same depths
  std::vector<DepthExponents> depths_;     ///< where exponents are known, from the top down
  std::vector<double> met_;                ///< z of those with all three numbers of the paper
  std::size_t best_ = 0;                   ///< the depth that comes nearest to the paper
  std::vector<Coefficients> points_;       ///< c and D there
  std::vector<std::pair<ReplicatedFits, ScalingVariation>> changes_;  ///< there, with one choice changed
};

}  // namespace

std::unique_ptr<Study> literal_reading_study() { return std::make_unique<LiteralReading>(); }

}  // namespace granuscope
