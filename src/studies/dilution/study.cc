#include "studies/dilution/study.h"

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

Json to_json(const SolvableShare& one) {
  return {{"mu", one.mu},
          {"size", one.size},
          {"opened_share", one.share},
          {"piles", one.piles},
          {"solvable", granuscope::to_json(one.solvable())},
          {"solvable_at_the_edge_too", granuscope::to_json(one.at_all())},
          {"no_idle_bead", one.no_idle_bead}};
}

Json to_json(const LargestShare& one) {
  return {{"mu", one.mu}, {"size", one.size}, {"piles", one.piles}, {"largest_share", granuscope::to_json(one.share)}};
}

Json to_json(const DilutedResponse& one) {
  const auto chi2 = [&](ResponseShape shape) { return one.fits[static_cast<std::size_t>(shape)].chi2; };
  return {{"mu", one.mu},
          {"opened_share", one.share},
          {"columns", one.columns},
          {"layers", one.layers},
          {"samples", one.samples},
          {"failed", one.failed},
          {"z", one.z},
          {"peaks", one.peaks},
          {"chi2_of_one_against_two",
           finite_or_null(std::round(chi2(ResponseShape::one_gaussian) - chi2(ResponseShape::two_gaussians)))},
          {"position", granuscope::to_json(one.position)},
          {"width", granuscope::to_json(one.width)},
          {"c", granuscope::to_json(one.c)},
          {"D", granuscope::to_json(one.D)},
          {"thrust_ratio", granuscope::to_json(one.thrust_ratio)}};
}

/// What page 1 says: whether all responses have two peaks, and those with the least and the most opened contacts.
Json page_1_overlay(const DilutedPiles& measured) {
  const auto place = [](const char* list, std::size_t k) {
    return Json{{"key", fmt::format("/studies/dilution/{}/{}", list, k)}};
  };
  Json overlay = Json::object();
  if (!measured.largest.empty()) {
    // Of the largest piles, at the smallest and at the largest friction.
    const auto smallest_mu =
        std::count_if(measured.largest.begin(), measured.largest.end(),
                      [&](const LargestShare& one) { return one.mu == measured.largest.front().mu; });
    overlay["reach"] = {{"least", place("largest", static_cast<std::size_t>(smallest_mu) - 1)},
                        {"most", place("largest", measured.largest.size() - 1)}};
  }
  const auto& all = measured.responses;
  if (all.size() < 2) return overlay;
  const auto peaks = [&](int count) {
    return std::all_of(all.begin(), all.end(), [&](const DilutedResponse& one) { return one.peaks == count; });
  };
  overlay["stay"] = peaks(2);
  overlay["merge"] = all.front().peaks == 2 && all.back().peaks == 1;
  const auto alike = [](const DilutedResponse& one) { return one.position.known() && one.width.known(); };
  if (alike(all.front()) && alike(all.back())) {
    overlay["ends"] = {{"least", place("responses", 0)}, {"most", place("responses", all.size() - 1)}};
  }
  return overlay;
}

class DilutionStudy final : public CopiedStudy<DilutionStudy> {
 public:
  explicit DilutionStudy(DilutedPiles measured) : measured_(std::move(measured)) {}

  std::string id() const override { return "dilution"; }

  std::vector<Key> keys() override {
    KeyRange opened = KeyRange{.why = "from a quarter on there are as many balances as unknowns, 4 (1 - q) a bead"}
                          .within(0, 0.25)
                          .below(0.25);
    opened.ascending = true;
    opened.longest = 20;
    KeyRange sides = KeyRange{.why =
                                  "below 4 there is no ring, and a linear programme of more than 32 x 32 beads takes "
                                  "seconds"}
                         .within(fewest_columns, 32);
    sides.ascending = true;
    sides.longest = 8;
    KeyRange slack = KeyRange{}.within(0, tan30).above(0).below(tan30);
    return {
        make_key(table(), "mu", "", "friction coefficients at which contacts are opened", mu_,
                 friction_range_above_zero()),
        make_key(table(), "sizes", "beads", "columns, and layers, of the piles that are tried; none: no pile is",
                 sizes_, sides),
        make_key(table(), "shares", "",
                 "shares of the contacts below the top layer that are opened, each by itself: of how many piles does a "
                 "linear programme find a solution?",
                 shares_, opened),
        make_key(table(), "piles", "piles", "piles of each friction, size and share", piles_,
                 KeyRange{}.within(8, 100'000)),
        make_key(
            table(), "stepwise_piles", "piles",
            "piles of each friction and size of which contacts are opened one after the other, as long as they stay "
            "solvable; 0: none",
            stepwise_piles_, KeyRange{.or_zero = true}.within(4, 100'000)),
        make_key(
            table(), "least_slack", "loads of one top bead",
            "smallest N - |T|/mu that all contacts must be able to have at once where contacts are opened one after "
            "the other",
            least_slack_, slack),
        make_key(table(), "response_mu", "",
                 "friction coefficients at which the response is measured; none: not at all", response_mu_,
                 friction_range_above_zero()),
        make_key(table(), "response_shares", "",
                 "shares of the contacts that are opened one after the other in the piles whose response is measured",
                 response_shares_, opened),
        make_key(table(), "columns", "beads", "beads per layer of these piles", columns_,
                 KeyRange{}.within(fewest_columns, 64)),
        make_key(table(), "layers", "layers",
                 "layers of these piles; the response is measured from a third to two thirds of them", layers_,
                 KeyRange{}.within(9, 64)),
        make_key(table(), "samples", "piles",
                 "piles of each, at least eight per block; eight share their opened contacts", samples_),
        make_key(table(), "epsilon", "loads of one top bead", "by how much each top load is raised or lowered",
                 epsilon_, KeyRange{}.within(least_epsilon, epsilon_limit).below(epsilon_limit))};
  }

  bool asked() const override { return tries_piles() || !response_mu_.empty(); }

  Problem find_problem(const MainLine& main) const override {
    if (sizes_.empty() != mu_.empty()) {
      return problem(key(mu_.empty() ? "mu" : "sizes"),
                     "piles are tried at each friction and of each size, and one of the two lists is empty; fill both, "
                     "or none");
    }
    if (response_mu_.empty()) return {};
    if (response_shares_.empty()) {
      return problem(
          key("response_shares"),
          "there is no share of contacts to open in the piles whose response is wanted; give [0.0] and more");
    }
    const double reach = 2 * tan30 * Lattice::depth(fit().last_layer);
    if (columns_ < reach + 4) {
      return problem(key("columns"),
                     "the peaks meet behind a ring of {} columns before layer {}; give {} or more, or fewer layers",
                     columns_, fit().last_layer, std::ceil(reach + 4));
    }
    for (const SamplerSpec& one : wanted(main)) {
      if (auto found = granuscope::find_problem(one.model, {columns_, layers_})) {
        return problem(key("columns"), "{}", found->message);
      }
    }
    return find_samples_problem(key("samples"), samples_, main.response.blocks);
  }

  std::vector<StudyEnsemble> ensembles(const MainLine& main) const override {
    std::vector<StudyEnsemble> all;
    for (const SamplerSpec& one : wanted(main)) {
      EnsembleSpec spec;
      spec.sampler = one;
      spec.lattice = {columns_, layers_};
      spec.response = multiplexed_response(epsilon_, true);
      spec.response.blocks = main.response.blocks;
      spec.response.samples = samples_;
      spec.layers = layers_to_record(fit(), {});
      const double share = one.model.diluted_beads.share;
      all.push_back({fmt::format("diluted beads, mu = {}, share = {}", one.mu, share),
                     fmt::format("diluted-mu-{}-share-{}", exact(one.mu), exact(share)), spec});
    }
    return all;
  }

  double memory() const override {
    const double side = sizes_.empty() ? 0 : sizes_.back();
    return tries_piles() ? 5e4 * side * side : 0;  // a linear programme of two threads, some kilobytes a bead
  }
  // Of one core of a cloud machine: a programme takes a time that grows as the square of the number of beads.
  double seconds() const override {
    if (!tries_piles()) return 0;
    double beads_squared = 0;
    for (const int side : sizes_) beads_squared += std::pow(side, 4);
    const double piles = static_cast<double>(piles_) * static_cast<double>(shares_.size()),
                 stepwise = static_cast<double>(stepwise_piles_);
    return static_cast<double>(mu_.size()) * beads_squared * (1.2e-6 * piles + 2e-5 * stepwise);
  }

  void begin(const MainLine& main, int threads) override {
    seed_ = main.sampling.seed;
    threads_ = threads;
  }

  void add(const StudyEnsemble&, const MeasuredEnsemble& ensemble) override {
    measured_.responses.push_back(measure_diluted_response(ensemble, fit(), threads_));
  }

  void finish() override {
    if (!tries_piles()) return;
    measured_.solvable = measure_solvable_shares(mu_, sizes_, shares_, piles_, seed_, threads_);
    if (stepwise_piles_ == 0) return;
    measured_.largest = measure_largest_shares(mu_, sizes_, least_slack_, stepwise_piles_, seed_, threads_);
  }

  Json json() const override {
    return {{"solvable", list_of(measured_.solvable, to_json)},
            {"largest", list_of(measured_.largest, to_json)},
            {"responses", list_of(measured_.responses, to_json)}};
  }

  std::vector<ReportPart> parts(const Json&) const override {
    std::vector<ReportPart> all;
    if (!measured_.largest.empty() || !measured_.responses.empty()) all.push_back(page_1(page_1_overlay(measured_)));
    for (const auto& [page, needs] :
         {std::pair{"dilution_responses", "responses"}, std::pair{"dilution_largest", "largest"},
          std::pair{"dilution_solvable", "solvable"}}) {
      ReportPart one = part(page, needs);
      one.page = std::string("studies/") + page + ".table";
      all.push_back(one);
    }
    return all;
  }

  std::vector<FigurePlot> figures(const Analysis&) const override {
    std::vector<FigurePlot> all;
    if (!measured_.responses.empty()) {
      all.push_back([this](const std::filesystem::path& folder) { return plot_diluted_responses(measured_, folder); });
    }
    if (!measured_.solvable.empty()) {
      all.push_back([this](const std::filesystem::path& folder) { return plot_solvable_shares(measured_, folder); });
    }
    return all;
  }

 private:
  bool tries_piles() const { return !mu_.empty() && !sizes_.empty(); }

  /// Layers from a third to two thirds: above, the peaks have not parted; below, the floor is near.
  FitSpec fit() const {
    FitSpec spec;
    spec.first_layer = spec.shallow_layer = layers_ / 3;
    spec.last_layer = 2 * layers_ / 3;
    spec.layer_step = 1;
    return spec;
  }

  std::vector<SamplerSpec> wanted(const MainLine& main) const {
    std::vector<SamplerSpec> all;
    for (const double mu : response_mu_) {
      for (const double share : response_shares_) {
        SamplerSpec sampler;
        sampler.mu = mu;
        sampler.seed = main.sampling.seed;
        sampler.model.name = ModelName::diluted_beads;
        sampler.model.diluted_beads = {share, least_slack_};
        all.push_back(sampler);
      }
    }
    return all;
  }

  std::vector<double> mu_;
  std::vector<int> sizes_;
  std::vector<double> shares_{0.0, 0.02, 0.04, 0.06, 0.08, 0.1, 0.12, 0.14};
  std::uint64_t piles_ = 200, stepwise_piles_ = 16;
  double least_slack_ = DilutedBeadsSpec{}.least_slack;
  std::vector<double> response_mu_, response_shares_{0.0, 0.05};
  int columns_ = 24, layers_ = 18;
  std::uint64_t samples_ = 512;
  double epsilon_ = 0.2;

  std::uint64_t seed_ = 1;
  int threads_ = 0;
  DilutedPiles measured_;
};

}  // namespace

std::unique_ptr<Study> dilution_study(DilutedPiles measured) {
  return std::make_unique<DilutionStudy>(std::move(measured));
}

}  // namespace granuscope
