#include <algorithm>
#include <chrono>
#include <cstdint>
#include <limits>
#include <numeric>
#include <set>

#include "analysis/force_bands.h"
#include "analysis/jackknife.h"
#include "analysis/mean_response.h"
#include "cli/flag_checks.h"
#include "cli/page_options.h"
#include "ensemble/ensemble_runner.h"
#include "model/lattice.h"
#include "report/clean_json.h"
#include "sampling/polytope.h"
#include "sampling/sampler.h"
#include "storage/pile_file.h"
#include "support/progress.h"
#include "support/provenance.h"

namespace granuscope {
namespace {

constexpr int usual_blocks = 32;
/// min_blocks whole groups.
constexpr std::uint64_t fewest_samples_with_errors = static_cast<std::uint64_t>(min_blocks) * group_size;

struct SampleOptions {
  EnsembleSpec spec;
  std::string load = name_of(Load::uniform);
  int threads = 0;
  bool statistics = false;
  std::string distributions, band;
  std::array<double, 2> layers{};  ///< of the band, first and last
  OutputFile file;
  std::uint64_t sample = 0;
};

void store_sample(const SampleOptions& options, VerbContext& context) {
  const Lattice lattice(options.spec.lattice);
  Pile pile(lattice);
  const auto draw = [&] {
    try {
      return replay(options.spec, options.sample, pile);
    } catch (const Interrupted&) {
      throw Interrupted("stopped on request before the pile was drawn, so that none was stored; start again");
    }
  };
  if (const auto failure = draw()) {
    throw InputError(
        "sample {} could not be completed within the effort (it got stuck in layer {}), so that "
        "there is nothing to store; raise --effort or --max-tries, or take another --sample",
        options.sample, failure->layer);
  }
  write_pile(options.file.path, pile);
  context.wrote(options.file.path);
}

/// The loads of the estimators that vary them are there for one pile at a time: what an ensemble names as failed.
void set_load(const SampleOptions& options, EnsembleSpec& spec) {
  const bool paired = options.load == name_of(EstimatorName::paired);
  const bool multiplexed = options.load == name_of(EstimatorName::multiplexed);
  if (paired || multiplexed) {
    spec.response.estimator = estimator_named(options.load);
    spec.load = Load::point;
    if (options.statistics) {
      throw InputError(
          "--load {} draws the one pile that an ensemble of this estimator would, but --statistics measures "
          "piles of one load; use granuscope run, or --load uniform or point",
          options.load);
    }
  } else {
    spec.load = load_named(options.load);
  }
  if (spec.load == Load::uniform && spec.response.overload != ResponseSpec{}.overload)
    throw InputError("--overload would change nothing under --load uniform; leave it out, or give --load point");
}

/// What no ensemble could be drawn with, by the name of the flag.
void check_flags(EnsembleSpec spec) {
  spec.response.samples = group_size * static_cast<std::uint64_t>(spec.response.blocks);  // --samples may be fewer
  spec.layers = {0};  // no response is looked for: overloads need no room of their own
  auto found = find_problem(spec);
  if (!found) return;
  found->key.erase(0, found->key.find('.') + 1);  // the table of a model
  Key named;
  named.name = found->key == "record_forces" ? "forces" : found->key;
  found->key = flag_of(named);
  refuse(found);
}

using Clock = std::chrono::steady_clock;

// Beyond this many beads the audit would take longer than a few seconds; then only some piles are audited.
constexpr double most_audited_beads = 5e7;

/// One block per sample: enough for means, too few for standard errors.
EnsembleRecord run_few(const EnsembleSpec& spec) {
  EnsembleSpec padded = spec;
  padded.response.samples = fewest_samples_with_errors;
  validate(padded);  // everything but the number of samples
  const Lattice lattice(spec.lattice);
  const auto sampler = make_sampler(spec.sampler, lattice);
  const std::vector<double> load = top_load(spec);
  const double total_load = std::accumulate(load.begin(), load.end(), 0.0);
  const auto columns = static_cast<std::size_t>(lattice.columns());
  const auto layers = static_cast<std::size_t>(lattice.layers());
  Pile pile(lattice);

  EnsembleRecord record;
  record.sums.layers.resize(layers);
  std::iota(record.sums.layers.begin(), record.sums.layers.end(), 0);
  record.sums.count.assign(1, 0);
  QuantitySums& thrust = record.sums.quantities["thrust"];
  QuantitySums& variance = record.sums.quantities["weight_variance"];
  thrust.sum.assign(layers, 0);
  variance.sum.assign(layers, 0);
  for (std::uint64_t sample = 0; sample < spec.response.samples; ++sample) {
    throw_if_interrupted();
    if (const auto failure = sampler->draw(sample, load, pile)) {
      record.failed.push_back({sample, failure->layer, replay_command(spec, sample)});
      continue;
    }
    ++record.sums.count[0];
    for (std::size_t n = 0; n < layers; ++n) {
      const double mean = mean_weight(spec.sampler.bead_weight, static_cast<int>(n));
      const double total = total_load + (mean - 1) * static_cast<double>(columns);
      for (std::size_t b = n * columns; b < (n + 1) * columns; ++b) {
        const double excess = (pile.V_R[b] + pile.V_L[b] - mean) / mean;
        thrust.sum[n] += lattice.geometry().cotangent * (pile.H_R[b] - pile.H_L[b]) / total;
        variance.sum[n] += excess * excess / static_cast<double>(columns);
      }
    }
  }
  record.counts = sampler->counts();
  return record;
}

Estimate layer_estimate(const BlockSums& sums, const std::string& quantity, std::size_t layer) {
  const Replicated mean = block_mean(sums, quantity, layer);
  if (sums.blocks() >= min_blocks) return estimate(mean, "no pile, or a whole block without any, could be completed");
  Estimate without_error;
  without_error.value = mean.value;
  without_error.reason = std::isfinite(mean.value)
                             ? fmt::format("a standard error needs at least {} samples", fewest_samples_with_errors)
                             : "no pile could be completed";
  return without_error;
}

/// How the forces of the contacts leaving a layer are distributed, in units of the mean weight that leaves a bead.
std::vector<std::pair<std::string, Estimate>> forces_of_layer(const BlockSums& sums, int columns, std::size_t row) {
  const auto blocks = band_sums(sums, columns, row, row + 1);
  auto all = replicated(blocks, [](const ForceSums& one) { return moments_of(one, normals); });
  all.pop_back();  // the skewness
  for (Replicated& one : replicated(blocks, mobilisation_of)) all.push_back(std::move(one));
  std::vector<std::pair<std::string, Estimate>> numbers;
  for (const char* name : {"normal_mean", "normal_variance", "mobilisation", "sliding"}) {
    numbers.emplace_back(name,
                         estimate(all[numbers.size()], "no pile, or a whole block without any, could be completed"));
  }
  return numbers;
}

constexpr const char* head_of_distributions = "of,x,density,standard_error\n";

/// P(w), P(N) and P(|T|/(mu N)) of these layers together, whose errors come from blocks of piles.
std::string distributions_table(const BlockSums& sums, const EnsembleSpec& spec, std::array<double, 2> band) {
  const auto blocks =
      band_sums(sums, spec.lattice.columns, static_cast<std::size_t>(band[0]), static_cast<std::size_t>(band[1]) + 1);
  CsvTable table({"of", "x", "density", "standard_error"});
  const auto add = [&](const char* of, const DensityRows& rows) {
    for (const auto& [x, density, error] : rows) table.add_cells({of, exact(x), exact(density), exact(error)});
  };
  add("w/<w>", density_of(blocks, weights));
  add("N/<N>", density_of(blocks, normals));
  if (spec.sampler.mu > 0) add("|T|/(mu N)", density_of_mobilisation(blocks));
  const Estimate sliding = estimate(replicated(blocks, mobilisation_of)[1]);
  if (spec.sampler.mu > 0) add("share that slides", {{1, sliding.value, sliding.standard_error}});
  return table.text();
}

/// Draws the completed piles again, all or evenly spaced ones, and returns the worst of their audits.
AuditResult audit_samples(const EnsembleSpec& spec, const std::vector<FailedSample>& failed, std::ostream& messages) {
  const Lattice lattice(spec.lattice);
  const auto sampler = make_sampler(spec.sampler, lattice);
  const std::vector<double> load = top_load(spec);
  Pile pile(lattice);
  std::set<std::uint64_t> skipped;
  for (const FailedSample& one : failed) skipped.insert(one.sample);
  const auto affordable =
      static_cast<std::uint64_t>(std::max(1.0, most_audited_beads / static_cast<double>(lattice.beads())));
  const std::uint64_t step = (spec.response.samples + affordable - 1) / affordable;

  AuditResult worst;
  std::uint64_t audited = 0;
  for (std::uint64_t sample = 0; sample < spec.response.samples; sample += step) {
    throw_if_interrupted();
    if (skipped.count(sample) != 0 || sampler->draw(sample, load, pile)) continue;
    ++audited;
    const AuditResult one = audit(pile);
    if (one.max_balance_residual > worst.max_balance_residual) {
      worst.max_balance_residual = one.max_balance_residual;
      worst.balance_layer = one.balance_layer;
    }
    if (one.max_cone_violation > worst.max_cone_violation) {
      worst.max_cone_violation = one.max_cone_violation;
      worst.cone_layer = one.cone_layer;
    }
  }
  messages << fmt::format("audited {} of {}\n", audited, how_many(spec.response.samples - failed.size(), "pile"));
  // Nothing looked at is not the same as nothing found.
  if (audited == 0) worst.max_balance_residual = worst.max_cone_violation = std::numeric_limits<double>::quiet_NaN();
  return worst;
}

/// Draws the piles and measures every layer. Standard errors are known from fewest_samples_with_errors on. Every pile
/// is audited, or evenly spaced ones if they are too many; how many, and which piles failed, is told.
SampleStatistics measure_samples(const SampleOptions& options, VerbContext& context) {
  EnsembleSpec spec = options.spec;
  const int threads = options.threads;
  std::ostream& messages = context.err;
  spec.layers.clear();  // all
  spec.record_profiles = false;
  const std::uint64_t groups = spec.response.samples / group_size;
  spec.response.blocks = static_cast<int>(std::clamp<std::uint64_t>(groups, min_blocks, usual_blocks));

  const auto started = Clock::now();
  const SamplerSpec& sampler = spec.sampler;
  if (sampler.law == Law::polytope && sampler.mu > 0 && (sampler.burn_in == 0 || sampler.thinning == 0)) {
    messages << "measuring how many sweeps the chains need\n" << std::flush;
  }
  spec.sampler = with_measured_chain(spec.sampler, Lattice(spec.lattice), top_load(spec));
  const auto draw = [&] {
    if (spec.response.samples < fewest_samples_with_errors) return run_few(spec);
    Progress shown("sampling", spec.response.samples);
    EnsembleRecord drawn = run_ensemble(spec, threads, &shown);
    shown.finish();
    return drawn;
  };
  const EnsembleRecord record = draw();
  const std::chrono::duration<double> elapsed = Clock::now() - started;

  constexpr std::size_t most_named = 8;
  for (const FailedSample& one : std::span(record.failed).first(std::min(record.failed.size(), most_named))) {
    messages << fmt::format("sample {} could not be completed (layer {}): {}\n", one.sample, one.layer, one.replay);
  }
  if (record.failed.size() > most_named) {
    messages << fmt::format("{} more of {} samples could not be completed\n", record.failed.size() - most_named,
                            spec.response.samples);
  }
  SampleStatistics statistics;
  statistics.law = name_of(spec.sampler.law);
  statistics.mu = spec.sampler.mu;
  statistics.columns = spec.lattice.columns;
  statistics.layers = spec.lattice.layers;
  statistics.samples = std::accumulate(record.sums.count.begin(), record.sums.count.end(), std::uint64_t{0});
  statistics.counts = record.counts;
  statistics.effective_samples = effective_samples(record.sums);
  statistics.lambda = spec.sampler.lambda;
  statistics.burn_in = spec.sampler.burn_in;
  statistics.thinning = spec.sampler.thinning;
  statistics.seconds = elapsed.count();
  for (std::size_t n = 0; n < record.sums.layers.size(); ++n) {
    statistics.per_layer.push_back({record.sums.layers[n], layer_estimate(record.sums, "thrust", n),
                                    layer_estimate(record.sums, "weight_variance", n)});
    if (spec.record_forces) statistics.per_layer.back().forces = forces_of_layer(record.sums, spec.lattice.columns, n);
  }
  if (!options.distributions.empty() && statistics.samples == 0) {
    messages << "no pile was completed, so that there is nothing to count and no " << options.distributions << "\n";
  } else if (!options.distributions.empty()) {
    OutputFile{options.distributions, options.file.force}.write(distributions_table(record.sums, spec, options.layers));
    context.wrote(options.distributions);
  }
  statistics.audit = audit_samples(spec, record.failed, messages);
  return statistics;
}

ExitCode sample(SampleOptions options, VerbContext& context) {
  EnsembleSpec& spec = options.spec;
  if (!options.distributions.empty()) spec.record_forces = true;
  if (!spec.sampler.model.has_contacts()) {
    throw InputError(
        "piles of the model {} have no contacts that could be stored; measure them by granuscope run, or give {} or {}",
        name_of(spec.sampler.model.name), name_of(ModelName::frictional_beads), name_of(ModelName::diluted_beads));
  }
  const DilutedBeadsSpec &diluted = spec.sampler.model.diluted_beads, usual;
  if (spec.sampler.model.is_beads() && (diluted.share != usual.share || diluted.least_slack != usual.least_slack)) {
    throw InputError(
        "--opened-share and --least-slack belong to --model diluted-beads and would change nothing; leave them out, or "
        "give that model");
  }
  set_load(options, spec);
  check_flags(spec);
  if (!options.statistics && !options.file.asked()) {
    throw InputError(
        "nothing is asked for; give --out FILE.h5 to store one pile, --statistics to measure many, or both");
  }
  if (spec.record_forces && (!options.statistics || spec.response.samples < fewest_samples_with_errors)) {
    throw InputError("--forces and --distributions belong to --statistics of at least {} --samples",
                     fewest_samples_with_errors);
  }
  const int above_bottom = Lattice(spec.lattice).usable_layers(),
            usable = above_bottom > 0 ? above_bottom : spec.lattice.layers;
  options.layers = {std::floor(usable / 2.0), usable - 1.0};
  const auto& [first, last] = options.layers;
  if (!options.band.empty() && !parse_numbers(options.band, options.layers)) {
    throw InputError("--band {} is not FIRST,LAST: two layers", options.band);
  }
  if (!options.distributions.empty()) {
    require_suffix(options.distributions, ".csv");
    if (fs::path(options.distributions).lexically_normal() == fs::path(options.file.path).lexically_normal())
      throw InputError("--distributions and --out name one file, {}; name two", options.file.path);
    OutputFile{options.distributions, options.file.force}.require_free({}, head_of_distributions);
    if (!(first >= 0 && first <= last && last < spec.lattice.layers && first == std::floor(first) &&
          last == std::floor(last))) {
      throw InputError(
          "--distributions counts layers {} to {}, and the pile has 0 to {}; give --band FIRST,LAST among them", first,
          last, spec.lattice.layers - 1);
    }
    if (above_bottom > 0 && last >= usable)
      context.err << fmt::format("the band ends below layer {}: the layers from there on follow another law\n",
                                 usable - 1);
  }
  if (options.statistics && spec.response.samples < 1)
    throw InputError("--samples 0 measures nothing; give at least 1");
  require_suffix(options.file.path, ".h5");
  if (options.file.asked()) options.file.require_free({});
  const FrictionCone cone(
      spec.sampler.mu, BeadGeometry(spec.lattice.angle));  // refuses a mu outside the model before any memory is taken
  const Lattice lattice(spec.lattice);
  const int workers = worker_count(options.threads);
  const double of_forces = spec.record_forces ? 8.0 * force_bins::width * usual_blocks * lattice.layers() : 0;
  require_memory(options.statistics ? workers * drawing_memory(spec.sampler, lattice) + of_forces
                                    : bytes_per_bead * static_cast<double>(lattice.beads()));

  if (options.file.asked()) store_sample(options, context);
  if (!options.statistics) return ExitCode::done;
  try {
    const SampleStatistics measured = measure_samples(options, context);
    context.out << sample_statistics_json(measured);
    if (measured.samples == 0)
      throw InputError("no pile could be completed, so that nothing is known; take fewer columns or another --law");
  } catch (const Interrupted&) {
    throw Interrupted("stopped on request before all samples were drawn, so that there are no statistics; start again");
  }
  return ExitCode::done;
}

}  // namespace

void add_sample_verb(CLI::App& app, VerbContext& context) {
  CLI::App* verb = app.add_subcommand("sample", "Draw random piles: store one of them, or measure many layer by layer");
  const auto options = std::make_shared<SampleOptions>();
  options->spec.response.samples = 256;
  EnsembleSpec& spec = options->spec;
  for (const Key& key : keys_of(spec.sampler.model)) {
    if (key.table == "model" || key.table == "model.diluted_beads")
      (key.name == "name"
           ? verb->add_option_function<std::string>(
                     "--model", [&spec](const std::string& name) { spec.sampler.model.name = model_named(name); },
                     "frictional-beads, or diluted-beads (small piles with opened contacts)")
                 ->default_str(key.text())
           : add_key(*verb, key));
  }
  for (const Key& key : keys_of(spec)) {
    if (key.only.elsewhere == Elsewhere::left_out || key.name == "estimator" || key.name == "blocks") continue;
    if (key.name == "load") {
      verb->add_option("--load", options->load,
                       "uniform: 1 on every top bead; point: 1 + overload on the middle one; paired, multiplexed: the "
                       "pile that an ensemble of this estimator draws, to follow what it names as failed")
          ->check(CLI::IsMember({"uniform", "point", "paired", "multiplexed"}))
          ->capture_default_str();
    } else {
      add_key(*verb, key,
              key.name == "samples" ? "how many piles --statistics draws; 64 or more give standard errors" : "");
    }
  }
  verb->add_option("-j,--threads", options->threads, "threads, 0 for all; never changes a number")
      ->capture_default_str()
      ->check(CLI::Range(0, 4096));
  verb->add_flag("--statistics", options->statistics,
                 "print one JSON object on standard output and nothing else there");
  verb->add_flag(
      "--forces", spec.record_forces,
      "with --statistics: also how normal forces scatter and how much friction is mobilised, by layer (uniform "
      "load, 64 samples or more)");
  verb->add_option(
      "--distributions", options->distributions,
      "with --statistics: CSV file to write: how w, N and |T|/(mu N) are distributed, with standard errors");
  verb->add_option(
          "--band", options->band,
          "FIRST,LAST: layers that --distributions counts together (if not given the lower half of those above "
          "the bottom's)")
      ->needs("--distributions");
  add_output(*verb, "-o,--out", options->file, "store one pile in this file (HDF5)");
  add_key(*verb, make_key("sample", "sample", "", "which pile --out stores", options->sample));
  context.actions[verb] = [options, &context] { return sample(*options, context); };
}

}  // namespace granuscope
