#include "pipeline/ensemble_stage.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <sstream>
#include <system_error>

#include "storage/ensemble_file.h"
#include "support/atomic_file.h"
#include "support/error.h"
#include "support/number_format.h"
#include "support/one_line.h"

namespace granuscope {
namespace {

/// Lines "key=value" of a configuration text.
std::map<std::string, std::string> settings_of(const std::string& configuration) {
  std::map<std::string, std::string> settings;
  std::istringstream lines(configuration);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t equals = line.find('=');
    if (equals != std::string::npos) settings[line.substr(0, equals)] = line.substr(equals + 1);
  }
  return settings;
}

/// The first settings in which two ensembles differ: "seed = 2 where 1 is there, samples = ...".
std::string describe_difference(const std::string& there, const std::string& wanted) {
  constexpr std::size_t most_shown = 3;
  const std::map<std::string, std::string> before = settings_of(there);
  std::vector<std::string> differences;
  for (const auto& [key, value] : settings_of(wanted)) {
    const auto old = before.find(key);
    if (old == before.end()) {
      differences.push_back(fmt::format("{} = {} is new", key, one_line(value, 40)));
    } else if (old->second != value) {
      differences.push_back(
          fmt::format("{} = {} where {} is there", key, one_line(value, 40), one_line(old->second, 40)));
    }
  }
  const bool more = differences.size() > most_shown;
  if (more) differences.resize(most_shown);
  return fmt::format("{}{}", fmt::join(differences, ", "), more ? ", and more" : "");
}

}  // namespace

void look_for(PlannedEnsemble& planned, const std::filesystem::path& run_folder) {
  planned.reusable = false;
  planned.replaces.clear();
  const std::filesystem::path file = run_folder / planned.file;
  std::error_code ignored;
  if (!std::filesystem::exists(file, ignored)) return;
  try {
    const std::string there = read_ensemble_configuration(file);
    const std::string wanted = configuration_text(planned.spec);
    planned.reusable = there == wanted;
    if (!planned.reusable) planned.replaces = "it is of another experiment: " + describe_difference(there, wanted);
  } catch (const InputError& damage) {
    planned.replaces = damage.what();  // damaged or foreign
  }
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
    look_for(ensemble, run_folder);
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
      planned.replaces = damage.what();
    }
  }
  if (!planned.replaces.empty()) {
    say(progress, fmt::format("sampling {}: {} is drawn again and replaced once the new one is whole: {}",
                              planned.label, planned.file.string(), planned.replaces));
  }
  Progress shown(fmt::format("sampling {}", planned.label), planned.spec.samples, progress);
  measured.record = run_ensemble(planned.spec, threads, &shown);
  shown.finish();
  make_folder(file.parent_path());
  write_ensemble(file, measured.record);
  return measured;
}

}  // namespace granuscope
