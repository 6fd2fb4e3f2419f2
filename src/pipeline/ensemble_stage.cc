#include "pipeline/ensemble_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "storage/ensemble_file.h"
#include "support/atomic_file.h"
#include "support/error.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

bool holds(const std::filesystem::path& file, const std::string& configuration) {
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) return false;
  try {
    return read_ensemble_configuration(file) == configuration;
  } catch (const InputError&) {
    return false;  // damaged or foreign: drawn again, and replaced only when the new one is whole
  }
}

}  // namespace

bool is_there(const PlannedEnsemble& planned, const std::filesystem::path& run_folder) {
  return holds(run_folder / planned.file, configuration_text(planned.spec));
}

std::vector<PlannedEnsemble> plan_ensembles(const Experiment& experiment, const std::filesystem::path& run_folder) {
  std::vector<PlannedEnsemble> planned;
  for (double mu : experiment.mu) {
    PlannedEnsemble ensemble;
    EnsembleSpec& spec = ensemble.spec;
    spec.sampler = experiment.sampler_for(mu);
    spec.lattice = experiment.lattice;
    spec.load = Load::point;
    spec.overload = experiment.response.overload;
    spec.epsilon = experiment.response.epsilon;
    spec.estimator = estimator_named(experiment.response.estimator);
    spec.blocks = experiment.response.blocks;
    const std::uint64_t one_group_each = static_cast<std::uint64_t>(spec.blocks) * group_size;
    spec.samples = mu == 0 ? std::min(experiment.response.samples, one_group_each) : experiment.response.samples;
    const bool profiles_wanted = experiment.figures.response_profiles && mu == experiment.figures.profile_mu;
    spec.layers =
        layers_to_record(experiment.fit, profiles_wanted ? experiment.figures.profile_layers : std::vector<int>{});
    ensemble.file = std::filesystem::path("ensembles") / fmt::format("mu-{}.h5", exact(mu));
    ensemble.label = fmt::format("mu = {}", mu);
    ensemble.reusable = is_there(ensemble, run_folder);
    planned.push_back(std::move(ensemble));
  }
  return planned;
}

MeasuredEnsemble obtain_ensemble(PlannedEnsemble& planned, const std::filesystem::path& run_folder, int threads,
                                 ProgressStyle progress) {
  MeasuredEnsemble measured;
  measured.mu = planned.spec.sampler.mu;
  measured.law = name_of(planned.spec.sampler.law);
  measured.estimator = name_of(planned.spec.estimator);
  measured.overload = planned.spec.overload;
  measured.epsilon = planned.spec.epsilon;
  measured.lattice = planned.spec.lattice;
  const std::filesystem::path file = run_folder / planned.file;
  if (planned.reusable) {
    try {
      measured.record = read_ensemble(file);
      say(progress, fmt::format("sampling {}: {} piles already there", planned.label, planned.spec.samples));
      return measured;
    } catch (const InputError& damage) {
      // The plan read no further than the configuration.
      planned.reusable = false;
      say(progress, fmt::format("sampling {}: drawn again, because: {}", planned.label, damage.what()));
    }
  }
  Progress shown(fmt::format("sampling {}", planned.label), planned.spec.samples, progress);
  measured.record = run_ensemble(planned.spec, threads, &shown);
  shown.finish();
  make_folder(file.parent_path());
  write_ensemble(file, measured.record);
  return measured;
}

}  // namespace granuscope
