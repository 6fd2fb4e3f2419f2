#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <memory>
#include <string>

#include "cli/flag_checks.h"
#include "cli/machine.h"
#include "cli/sample_statistics.h"
#include "cli/verbs.h"
#include "ensemble/replay.h"
#include "model/friction_cone.h"
#include "sampling/sampler.h"
#include "storage/pile_file.h"

namespace granuscope {
namespace {

struct SampleOptions {
  EnsembleSpec spec;
  std::string model = name_of(ModelName::frictional_beads);
  std::string law = name_of(Law::granusolve);
  std::string load = name_of(Load::uniform);
  std::string layer_order = name_of(LayerOrder::random);
  std::string repair_rules = name_of(RepairRules::all);
  int threads = 0;
  bool statistics = false;
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
        fmt::format("sample {} could not be completed within the effort (it got stuck in layer {}), so that "
                    "there is nothing to store; raise --effort or --max-tries, or take another --sample",
                    options.sample, failure->layer));
  }
  write_pile(options.file.path, pile);
  context.err << fmt::format("wrote {}\n", options.file.path);
}

/// The loads of the estimators that vary them are there for one pile at a time: what an ensemble names as failed.
void set_load(const SampleOptions& options, EnsembleSpec& spec) {
  const bool paired = options.load == name_of(EstimatorName::paired);
  const bool multiplexed = options.load == name_of(EstimatorName::multiplexed);
  if (paired || multiplexed) {
    spec.response.estimator = estimator_named(options.load);
    spec.load = Load::point;
    if (options.statistics) {
      throw InputError(fmt::format(
          "--load {} draws the one pile that an ensemble of this estimator would, but --statistics measures "
          "piles of one load; use granuscope run, or --load uniform or point",
          options.load));
    }
  } else {
    spec.load = load_named(options.load);
  }
}

/// What no ensemble could be drawn with, by the name of the flag.
void check_flags(EnsembleSpec spec) {
  spec.response.samples = group_size * static_cast<std::uint64_t>(spec.response.blocks);  // --samples may be fewer
  auto found = find_problem(spec);
  if (!found) return;
  found->key.erase(0, found->key.find('.') + 1);  // the table of a model
  std::replace(found->key.begin(), found->key.end(), '_', '-');
  found->key.insert(0, "--");
  refuse(found);
}

ExitCode sample(SampleOptions options, VerbContext& context) {
  EnsembleSpec& spec = options.spec;
  spec.sampler.model.name = model_named(options.model);
  if (!spec.sampler.model.has_contacts()) {
    throw InputError(fmt::format(
        "piles of the model {} have no contacts that could be stored; measure them by granuscope run, or give {} or {}",
        options.model, name_of(ModelName::frictional_beads), name_of(ModelName::diluted_beads)));
  }
  const DilutedBeadsSpec &diluted = spec.sampler.model.diluted_beads, usual;
  if (spec.sampler.model.is_beads() && (diluted.share != usual.share || diluted.least_slack != usual.least_slack)) {
    throw InputError(
        "--opened-share and --least-slack belong to --model diluted-beads and would change nothing; leave them out, or "
        "give that model");
  }
  spec.sampler.law = law_named(options.law);
  set_load(options, spec);
  spec.sampler.order = layer_order_named(options.layer_order);
  spec.sampler.rules = repair_rules_named(options.repair_rules);
  check_flags(spec);
  if (!options.statistics && !options.file.asked()) {
    throw InputError(
        "nothing is asked for; give --out FILE.h5 to store one pile, --statistics to measure many, or both");
  }
  if (options.statistics && spec.response.samples < 1)
    throw InputError("--samples 0 measures nothing; give at least 1");
  if (options.file.asked()) options.file.require_free({});
  const FrictionCone cone(spec.sampler.mu);  // refuses a mu outside the model before any memory is taken
  const Lattice lattice(spec.lattice);
  const int workers = worker_count(options.threads);
  require_memory(options.statistics ? workers * drawing_memory(spec.sampler, lattice)
                                    : bytes_per_bead * static_cast<double>(lattice.beads()));

  if (options.file.asked()) store_sample(options, context);
  if (!options.statistics) return ExitCode::done;
  try {
    context.out << sample_statistics_json(measure_samples(spec, options.threads, context.err));
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
  verb->add_option("--mu", spec.sampler.mu, "friction coefficient, 0 <= mu < sqrt(3)")->capture_default_str();
  verb->add_option("--columns", spec.lattice.columns, "beads per layer, periodic, at least 4")
      ->capture_default_str()
      ->check(lattice_side());
  verb->add_option("--layers", spec.lattice.layers, "layers, 0 is the top one")
      ->capture_default_str()
      ->check(lattice_side());
  verb->add_option("--model", options->model, "frictional-beads, or diluted-beads (small piles with opened contacts)")
      ->capture_default_str();
  verb->add_option("--opened-share", spec.sampler.model.diluted_beads.share,
                   "diluted-beads: of the contacts below the top layer")
      ->capture_default_str();
  verb->add_option("--least-slack", spec.sampler.model.diluted_beads.least_slack,
                   "diluted-beads: smallest N - |T|/mu that all closed contacts must be able to have at once")
      ->capture_default_str();
  verb->add_option(
          "--law", options->law,
          "what a random pile means: granusolve, polytope (small piles), or eloy-clement and rejection (tiny piles)")
      ->capture_default_str();
  verb->add_option("--load", options->load,
                   "uniform: 1 on every top bead; point: 1 + overload on the middle one; paired, multiplexed: the pile "
                   "that an ensemble of this estimator draws, to follow what it names as failed")
      ->capture_default_str();
  verb->add_option("--load-angle", spec.sampler.load_angle,
                   "of the load on every top bead from the vertical, in degrees, to the right > 0: a tilted pile")
      ->capture_default_str();
  verb->add_option("--load-offset", spec.sampler.load_offset,
                   "how far to the right of their centres the loads act on the top beads, in bead radii: a torque")
      ->capture_default_str();
  verb->add_option("--bead-weight", spec.sampler.bead_weight,
                   "of every bead by itself, in loads of one top bead: gravity")
      ->capture_default_str();
  verb->add_option("--overload", spec.response.overload,
                   "extra force of --load point or paired, in loads of one top bead")
      ->capture_default_str();
  verb->add_option("--epsilon", spec.response.epsilon,
                   "--load multiplexed: by how much each top load is raised or lowered")
      ->capture_default_str();
  verb->add_flag("--opposite", spec.response.opposite,
                 "--load multiplexed: the pile with all variations reversed, too");
  verb->add_option("--sign-run", spec.response.sign_run, "--load multiplexed: neighbouring top beads varied alike")
      ->capture_default_str();
  verb->add_option("--samples", spec.response.samples,
                   "how many piles --statistics draws; 64 or more give standard errors")
      ->capture_default_str()
      ->check(whole_number());
  verb->add_option("--seed", spec.sampler.seed, "with the sample's number the key of every random number")
      ->capture_default_str()
      ->check(whole_number());
  verb->add_option("--effort", spec.sampler.effort,
                   "granusolve, eloy-clement: a pile fails after so many bead solutions per bead")
      ->capture_default_str();
  verb->add_option("--max-tries", spec.sampler.max_tries, "rejection: a pile fails after so many tries")
      ->capture_default_str()
      ->check(whole_number());
  verb->add_option("--lambda", spec.sampler.lambda,
                   "polytope: piles have the density of the product of length^-lambda, 0 to 1")
      ->capture_default_str();
  verb->add_option("--burn-in", spec.sampler.burn_in,
                   "polytope: sweeps before the first of eight piles; 0: four measured autocorrelation times")
      ->capture_default_str()
      ->check(whole_number());
  verb->add_option("--thinning", spec.sampler.thinning,
                   "polytope: sweeps from one of them to the next; 0: half a measured autocorrelation time")
      ->capture_default_str()
      ->check(whole_number());
  verb->add_option("--layer-order", options->layer_order,
                   "granusolve: random, or fixed (breaks the mirror symmetry: for comparison only)")
      ->capture_default_str();
  verb->add_option("--repair-rules", options->repair_rules,
                   "granusolve: all, or no-pair, no-arcs, backtrack-only (other laws: for comparison only)")
      ->capture_default_str();
  verb->add_option("-j,--threads", options->threads, "threads, 0 for all; never changes a number")
      ->capture_default_str()
      ->check(CLI::Range(0, 4096));
  verb->add_flag("--statistics", options->statistics,
                 "print one JSON object on standard output and nothing else there");
  add_output(*verb, "-o,--out", options->file, "store one pile in this file (HDF5)");
  verb->add_option("--sample", options->sample, "which pile --out stores")
      ->capture_default_str()
      ->check(whole_number());
  verb->callback([options, &context] { context.action = [options, &context] { return sample(*options, context); }; });
}

}  // namespace granuscope
