#include "studies/dilution.h"

#include <numeric>
#include <utility>

#include "ensemble/ensemble_runner.h"
#include "plot/plot.h"
#include "sampling/diluted_beads.h"
#include "support/progress.h"

namespace granuscope {
void to_json(Json& json, const SolvableShare& one) {
  json = {{"mu", one.mu},
          {"size", one.size},
          {"opened_share", one.share},
          {"piles", one.piles},
          {"solvable", one.solvable()},
          {"solvable_at_the_edge_too", one.at_all()},
          {"no_idle_bead", one.no_idle_bead}};
}

void to_json(Json& json, const LargestShare& one) {
  json = {{"mu", one.mu}, {"size", one.size}, {"piles", one.piles}, {"largest_share", one.share}};
}

void to_json(Json& json, const DilutedResponse& one) {
  const auto chi2 = [&](ResponseShape shape) { return one.fits[static_cast<std::size_t>(shape)].chi2; };
  json = {{"mu", one.mu},
          {"opened_share", one.share},
          {"columns", one.columns},
          {"layers", one.layers},
          {"samples", one.samples},
          {"failed", one.failed},
          {"z", one.z},
          {"peaks", one.peaks},
          {"chi2_of_one_against_two",
           finite_or_null(std::round(chi2(ResponseShape::one_gaussian) - chi2(ResponseShape::two_gaussians)))},
          {"position", one.position},
          {"width", one.width},
          {"c", one.c},
          {"D", one.D},
          {"thrust_ratio", one.thrust_ratio}};
}

namespace {

/// What page 1 says: whether all responses have two peaks, and those with the least and the most opened contacts.
Json page_1_overlay(const DilutedPiles& measured) {
  const auto place = [](const char* list, std::size_t k) {
    return Json{{"key", fmt::format("/studies/dilution/{}/{}", list, k)}};
  };
  Json overlay = Json::object();
  if (!measured.largest.empty()) {
    // Of the largest piles, at the smallest and at the largest friction.
    const auto smallest_mu = std::ranges::count_if(
        measured.largest, [&](const LargestShare& one) { return one.mu == measured.largest.front().mu; });
    overlay["reach"] = {{"least", place("largest", static_cast<std::size_t>(smallest_mu) - 1)},
                        {"most", place("largest", measured.largest.size() - 1)}};
  }
  const auto& all = measured.responses;
  if (all.size() < 2) return overlay;
  const auto peaks = [&](int count) {
    return std::ranges::all_of(all, [&](const DilutedResponse& one) { return one.peaks == count; });
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
    KeyRange sides =
        KeyRange{.why = "below 4 there is no ring, and a linear programme of more than 32 x 32 beads takes seconds"}
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
        make_key(table(), "stepwise_piles", "piles",
                 "piles of each friction and size of which contacts are opened one after the other, as long as they "
                 "stay solvable; 0: none",
                 stepwise_piles_, KeyRange{.or_zero = true}.within(4, 100'000)),
        make_key(table(), "least_slack", "loads of one top bead",
                 "smallest N - |T|/mu that all contacts must be able to have at once where contacts are opened one "
                 "after the other",
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
      return problem(
          key(mu_.empty() ? "mu" : "sizes"),
          "piles are tried at each friction and of each size, and one of the two lists is empty; fill both, or none");
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

  void add(const StudyEnsemble&, const MeasuredEnsemble& ensemble) override {
    measured_.responses.push_back(measure_diluted_response(ensemble, fit(), threads_));
  }

  void finish() override {
    if (!tries_piles()) return;
    measured_.solvable = measure_solvable_shares(mu_, sizes_, shares_, piles_, main_.sampling.seed, threads_);
    if (stepwise_piles_ == 0) return;
    measured_.largest =
        measure_largest_shares(mu_, sizes_, least_slack_, stepwise_piles_, main_.sampling.seed, threads_);
  }

  Json json() const override {
    return {{"solvable", measured_.solvable}, {"largest", measured_.largest}, {"responses", measured_.responses}};
  }

  std::vector<ReportPart> parts() const override {
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
      all.push_back([this](const fs::path& folder) { return plot_diluted_responses(measured_, folder); });
    }
    if (!measured_.solvable.empty()) {
      all.push_back([this](const fs::path& folder) { return plot_solvable_shares(measured_, folder); });
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

  DilutedPiles measured_;
};

}  // namespace

std::unique_ptr<Study> dilution_study(DilutedPiles measured) {
  return std::make_unique<DilutionStudy>(std::move(measured));
}

namespace {

std::vector<double> even_load(const Lattice& lattice) {
  return std::vector<double>(static_cast<std::size_t>(lattice.columns()), 1.0);
}

}  // namespace

// The error of a count that may be none or all: of half a pile more in one more (Jeffreys' prior).
Estimate SolvableShare::share_of(std::uint64_t count) const {
  const auto all = static_cast<double>(piles), some = static_cast<double>(count);
  const double p = (some + 0.5) / (all + 1);
  return {.value = some / all, .standard_error = std::sqrt(p * (1 - p) / all), .reason = ""};
}

std::vector<SolvableShare> measure_solvable_shares(const std::vector<double>& mu, const std::vector<int>& sizes,
                                                   const std::vector<double>& shares, std::uint64_t piles,
                                                   std::uint64_t seed, int threads) {
  std::vector<SolvableShare> all;
  for (const double friction : mu) {
    for (const int size : sizes) {
      for (const double share : shares) {
        SolvableShare& one = all.emplace_back();
        one.mu = friction;
        one.size = size;
        one.share = share;
        one.piles = piles;
        one.no_idle_bead = std::pow(1 - share * share, size * (size - undiluted_layers));
      }
    }
  }
  for_each_index(all.size(), threads, [&](std::size_t k) {
    SolvableShare& one = all[k];
    const Lattice lattice({one.size, one.size});
    const ContactBalances balances(one.mu, lattice);
    for (std::uint64_t pile = 0; pile < piles; ++pile) {
      throw_if_interrupted();
      const OpenedContacts opened = open_at_random(lattice, one.share, RandomKey(seed, pile));
      const Solvability found = find_largest_slack(balances, opened, even_load(lattice)).solvability;
      if (found == Solvability::inside) ++one.inside;
      if (found == Solvability::edge) ++one.edge;
    }
  });
  return all;
}

std::vector<LargestShare> measure_largest_shares(const std::vector<double>& mu, const std::vector<int>& sizes,
                                                 double least_slack, std::uint64_t piles, std::uint64_t seed,
                                                 int threads) {
  std::vector<LargestShare> all;
  for (const double friction : mu) {
    for (const int size : sizes) all.push_back({friction, size, piles, {}});
  }
  std::vector<double> reached(all.size() * piles);
  for_each_index(reached.size(), threads, [&](std::size_t k) {
    const LargestShare& one = all[k / piles];
    const Lattice lattice({one.size, one.size});
    const ContactBalances balances(one.mu, lattice);
    const OpenedStepwise opened =
        open_while_solvable(balances, {even_load(lattice)}, 1, least_slack, RandomKey(seed, k % piles));
    reached[k] = static_cast<double>(opened.count) / (2.0 * one.size * (one.size - undiluted_layers));
  });
  for (std::size_t k = 0; k < all.size(); ++k) {
    const double* first = reached.data() + k * piles;
    const auto count = static_cast<double>(piles);
    const double mean = std::accumulate(first, first + piles, 0.0) / count;
    double squares = 0;
    for (std::uint64_t pile = 0; pile < piles; ++pile) squares += (first[pile] - mean) * (first[pile] - mean);
    all[k].share = {.value = mean, .standard_error = std::sqrt(squares / (count * (count - 1))), .reason = ""};
  }
  return all;
}

DilutedResponse measure_diluted_response(const MeasuredEnsemble& ensemble, const FitSpec& fit, int threads) {
  const BlockSums& sums = ensemble.record.sums;
  DilutedResponse response;
  response.mu = ensemble.spec.sampler.mu;
  response.share = ensemble.spec.sampler.model.diluted_beads.share;
  response.columns = ensemble.spec.lattice.columns;
  response.layers = ensemble.spec.lattice.layers;
  response.samples = sums.samples();
  response.failed = ensemble.record.failed.size();
  const Transport transport = measure_transport(ensemble, fit, {fit.last_layer}, threads).transport;
  response.c = transport.c;
  response.D = transport.D;
  if (!transport.profiles.empty()) response.profile = transport.profiles.back();
  for (const DepthFit& depth : transport.depths) {
    if (depth.layer != fit.last_layer) continue;
    response.z = depth.z;
    response.position = depth.peak_position;
    response.width = depth.width;
    response.thrust_ratio = depth.thrust_ratio;
  }
  for (std::size_t row = 0; row < sums.layers.size(); ++row) {
    if (sums.layers[row] != fit.last_layer) continue;
    response.fits = fit_response_shapes(layer_spectrum(sums, row, ensemble.spec.response.overload), response.z);
    const ResponseShape shape = best_shape(response.fits);
    const FittedResponseShape& best = response.fits[static_cast<std::size_t>(shape)];
    response.peaks = best.position > (shape == ResponseShape::two_gaussians ? best.width : 0) ? 2 : 1;
  }
  return response;
}

Figure plot_solvable_shares(const DilutedPiles& measured, const std::filesystem::path& run_folder) {
  if (measured.solvable.empty()) {
    throw InputError(
        "the figure of solvable piles has nothing to show: no pile was tried; give the study mu, sizes and shares");
  }
  Plot plot;
  plot.id = "solvable-piles";
  plot.height = 3.3;
  plot.key = {.inches = 0.66, .lines = 3, .sample = 2, .entries = {}};
  Panel by_size = left_panel(), by_friction = right_panel();
  // Left: all sizes at the largest friction; right: all frictions at the smallest size.
  const double most_mu = measured.solvable.back().mu;
  const int least_size = measured.solvable.front().size;
  double most_share = 0;
  for (std::size_t first = 0, next = 0; first < measured.solvable.size(); first = next) {
    const SolvableShare& head = measured.solvable[first];
    CsvTable table({"opened_share: dimensionless", "solvable_share: dimensionless", "standard_error: dimensionless",
                    "solvable_at_the_edge_too: dimensionless", "standard_error: dimensionless",
                    "no_idle_bead: dimensionless"});
    for (next = first; next < measured.solvable.size(); ++next) {
      const SolvableShare& one = measured.solvable[next];
      if (one.mu != head.mu || one.size != head.size) break;
      const Estimate inside = one.solvable(), at_all = one.at_all();
      table.add_row(
          {one.share, inside.value, inside.standard_error, at_all.value, at_all.standard_error, one.no_idle_bead});
      most_share = std::max(most_share, one.share);
    }
    const std::string file = plot.add_data(fmt::format("mu-{}-size-{}", exact(head.mu), head.size), table);
    const auto add = [&](Panel& panel, const std::string& title, bool bound) {
      const Ink ink = ink_of_series(plot.key.entries.size());
      panel.add(file, "1:2:3", ink.joined_bars(1, 0.55));
      if (bound) panel.add(file, "1:6", ink.line(0, 3));
      plot.add_key(title, ink.joined(1, 0.55));
    };
    if (head.mu == most_mu) add(by_size, fmt::format("(a) {0} × {0} beads", head.size), true);
    if (head.size == least_size) add(by_friction, fmt::format("(b) μ = {}", caption_number(head.mu)), false);
  }
  Range shares = range_of(0, std::max(most_share, 0.01));
  for (Panel* panel : {&by_size, &by_friction}) {
    panel->x = linear_axis("share of opened contacts", {-0.004, 1.04 * shares.high, false}, 6, shares);
    panel->y = {"share of solvable piles", -0.03, 1.05, false, {{"0", 0}, {"0.5", 0.5}, {"1", 1}}};
  }
  plot.panels = {by_size, by_friction};
  return plot_figure(plot,
                     {"studies/solvable_piles.captions",
                      {{"piles", fmt::format("{}", measured.solvable.front().piles)},
                       {"mu", caption_number(most_mu)},
                       {"size", fmt::format("{}", least_size)}}},
                     run_folder);
}

Figure plot_diluted_responses(const DilutedPiles& measured, const std::filesystem::path& run_folder) {
  Plot plot;
  plot.id = "diluted-response";
  plot.height = 3.3;
  plot.key = {.inches = 0.66, .lines = 3, .sample = 2, .entries = {}};
  Panel profiles = left_panel(), peaks = right_panel();
  std::vector<std::string> mu;
  Range height, lengths, shares;
  height.add(0);
  lengths.add(0);
  shares.add(0);
  double z = 0;
  for (std::size_t first = 0, next = 0; first < measured.responses.size(); first = next) {
    const DilutedResponse& head = measured.responses[first];
    CsvTable table({"opened_share: dimensionless", "peak_position: bead diameters", "standard_error: bead diameters",
                    "width: bead diameters", "standard_error: bead diameters"});
    for (next = first; next < measured.responses.size() && measured.responses[next].mu == head.mu; ++next) {
      const DilutedResponse& one = measured.responses[next];
      if (!one.profile) continue;
      CsvTable profile({"x: bead diameters", "response: per bead", "standard_error: per bead"});
      for (std::size_t i = 0; i < one.profile->x.size(); ++i) {
        profile.add_row({one.profile->x[i], one.profile->pressure[i], one.profile->standard_error[i]});
        height.add(one.profile->pressure[i]);
      }
      const Ink ink = ink_of_series(plot.key.entries.size());
      profiles.add(plot.add_data(fmt::format("mu-{}-share-{}", exact(one.mu), exact(one.share)), profile), "1:2:3",
                   ink.joined_bars(1, 0.5));
      plot.add_key(fmt::format("μ = {}, q = {}", caption_number(one.mu), caption_number(one.share)),
                   ink.joined(1, 0.55));
      z = one.z;
      shares.add(one.share);
      if (!one.position.known() || !one.width.known()) continue;
      table.add_row(
          {one.share, one.position.value, one.position.standard_error, one.width.value, one.width.standard_error});
      lengths.add(one.position.value);
      lengths.add(one.width.value);
    }
    mu.push_back(caption_number(head.mu));
    if (table.empty()) continue;
    const std::string file = plot.add_data("mu-" + exact(head.mu), table),
                      colour = ink_of_series(plot.key.entries.size() - 1).colour;
    peaks.add(file, "1:2:3", Ink{colour, 7}.joined_bars(1, 0.6), "xₚ, μ = " + mu.back());
    peaks.add(file, "1:4:5", Ink{colour, 13}.joined_bars(1, 0.7, 2), "W, μ = " + mu.back());
  }
  if (profiles.curves.empty() || peaks.curves.empty()) {
    throw InputError(
        "the figure of the response of diluted piles has nothing to show, because no peaks were found; give a larger "
        "number of samples, or smaller shares");
  }
  shares.add(shares.high + 0.01);
  const double half = 0.5 * measured.responses.front().columns;
  Range inner;  // no label at a corner of the panel
  inner.add(-0.7 * half);
  inner.add(0.7 * half);
  profiles.x = linear_axis("x  (bead diameters)", {-half, half, false}, 5, inner);
  profiles.y =
      linear_axis("P(x, z)", {height.low - 0.03 * height.size(), height.high + 0.05 * height.size(), false}, 6, height);
  peaks.x = linear_axis("share of opened contacts", {-0.005, shares.high, false}, 5, shares);
  peaks.y = linear_axis("xₚ, W  (bead diameters)", {0, 1.1 * lengths.high, false}, 6, lengths);
  plot.panels = {profiles, peaks};
  return plot_figure(plot,
                     {"studies/diluted_response.captions",
                      {{"mu", enumeration(mu)},
                       {"z", caption_number(z)},
                       {"columns", fmt::format("{}", measured.responses.front().columns)},
                       {"layers", fmt::format("{}", measured.responses.front().layers)}}},
                     run_folder);
}

}  // namespace granuscope
