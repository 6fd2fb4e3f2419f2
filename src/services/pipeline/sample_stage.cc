#include "pipeline/sample_stage.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <sstream>

#include "analysis/transport.h"
#include "ensemble/estimator.h"
#include "pipeline/block_files.h"
#include "pipeline/shards.h"
#include "storage/ensemble_file.h"
#include "support/error.h"
#include "support/files.h"
#include "support/plain_text.h"
#include "support/templates.h"

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

}  // namespace

std::uint64_t count_in(const std::string& configuration, const std::string& key) {
  return std::strtoull(settings_of(configuration)[key].c_str(), nullptr, 10);
}

std::string describe_difference(const std::string& there, const std::string& wanted) {
  constexpr std::size_t most_shown = 3;
  const std::map<std::string, std::string> before = settings_of(there), after = settings_of(wanted);
  std::vector<std::string> differences;
  for (const auto& [key, value] : after) {
    const auto old = before.find(key);
    if (old == before.end()) {
      differences.push_back(fmt::format("{} = {} is new", key, single_line(value, 40)));
    } else if (old->second != value) {
      differences.push_back(
          fmt::format("{} = {} where {} is there", key, single_line(value, 40), single_line(old->second, 40)));
    }
  }
  for (const auto& [key, value] : before) {
    if (!after.contains(key)) differences.push_back(fmt::format("{} = {} is there only", key, single_line(value, 40)));
  }
  const bool more = differences.size() > most_shown;
  if (more) differences.resize(most_shown);
  return fmt::format("{}{}", fmt::join(differences, ", "), more ? ", and more" : "");
}

namespace {

bool only_more_samples(const std::string& there, const std::string& wanted) {
  std::map<std::string, std::string> before = settings_of(there), after = settings_of(wanted);
  before["samples"] = after["samples"];
  return before == after && count_in(there, "samples") < count_in(wanted, "samples");
}

}  // namespace

std::uint64_t round_of(const EnsembleSpec& spec) {
  return group_size * static_cast<std::uint64_t>(spec.response.blocks);
}

SamplerSpec measure_sampler(const PlannedEnsemble& planned, ProgressStyle progress) {
  const SamplerSpec& sampler = planned.spec.sampler;
  const bool stated = sampler.burn_in > 0 && sampler.thinning > 0;
  if (sampler.law != Law::polytope || sampler.mu == 0 || stated) return sampler;
  log_line(progress, "sampling {}: measuring how many sweeps its chains need", planned.label);
  const SamplerSpec measured = measured_sampler(planned.spec);
  log_line(progress, "sampling {}: {} sweeps to the first of eight piles, {} to each other one", planned.label,
           measured.burn_in, measured.thinning);
  return measured;
}

void draw_in_pieces(const EnsembleSpec& spec, const SamplerSpec& measured, std::uint64_t done, EnsembleRecord& record,
                    int threads, Progress* progress, const PartPolicy& parts,
                    const std::function<void(std::uint64_t groups)>& keep) {
  using Clock = std::chrono::steady_clock;
  const auto seconds_since = [](Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
  };
  const std::uint64_t all = groups_of(spec);
  auto kept = Clock::now();
  // What a group costs depends on the law: pieces grow until they take as long as they should.
  std::uint64_t per_piece = static_cast<std::uint64_t>(spec.response.blocks);
  const std::uint64_t done_at_start = done;
  while (done < all) {
    const std::uint64_t to = std::min(all, done + per_piece);
    const auto start = Clock::now();
    const EnsembleRecord before = record;  // what an interruption leaves of it is of no use
    try {
      add_groups(spec, measured, done, to, record, threads, progress);
    } catch (const Interrupted&) {
      record = before;
      if (done > done_at_start) keep(done);
      throw;
    }
    done = to;
    if (seconds_since(start) < parts.look) per_piece *= 2;
    if (done == all || seconds_since(kept) < parts.seconds) continue;
    keep(done);
    kept = Clock::now();
  }
}

namespace {

/// Samples of an ensemble that are drawn, those that failed included.
std::uint64_t samples_begun(const EnsembleRecord& record) {
  return std::accumulate(record.sums.count.begin(), record.sums.count.end(),
                         static_cast<std::uint64_t>(record.failed.size()));
}

/// The configuration of an ensemble of which the first groups are drawn.
std::string part_configuration(const EnsembleSpec& spec, std::uint64_t groups) {
  return fmt::format("{}groups_drawn={}\n", configuration_text(spec), groups);
}

/// Whether a file is in the run's folder; none is where no folder is named. One that cannot even be opened may be whole
/// all the same, and is not to be drawn again and replaced like a damaged one: then EnvironmentError.
bool is_there(const std::filesystem::path& run_folder, const std::filesystem::path& relative) {
  if (run_folder.empty()) return false;
  const std::filesystem::path file = run_folder / relative;
  const FileDescriptor opened(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (opened.valid()) return true;
  if (errno == ENOENT || errno == ENOTDIR || errno == ENAMETOOLONG) return false;  // then writing it says so
  throw EnvironmentError(
      "cannot open '{}', which may hold finished work that drawing it again would replace: {} Or remove it.",
      file.string(), system_reason(errno));
}

/// How many groups the run's folder holds of this ensemble; 0 where there is no part of it.
std::uint64_t groups_begun(const PlannedEnsemble& planned, const std::filesystem::path& run_folder) {
  if (!is_there(run_folder, part_file(planned))) return 0;
  const std::filesystem::path file = run_folder / part_file(planned);
  try {
    const std::string there = read_ensemble_configuration(file);
    const std::uint64_t groups = count_in(there, "groups_drawn");
    const bool usable = groups < groups_of(planned.spec) && there == part_configuration(planned.spec, groups);
    return usable ? groups : 0;
  } catch (const InputError&) {
    return 0;  // damaged or foreign
  }
}

/// The beginning that an earlier run or a smaller ensemble left, or nothing drawn yet; the first `groups` are in it.
EnsembleRecord beginning_of(const PlannedEnsemble& planned, const std::filesystem::path& run_folder,
                            std::uint64_t& groups) {
  EnsembleRecord nothing = begin_ensemble(planned.spec);
  const auto go_on_from = [&](EnsembleRecord begun, std::uint64_t with_groups) {
    begun.configuration = nothing.configuration;
    begun.configuration_key = nothing.configuration_key;
    groups = with_groups;
    return begun;
  };
  if (planned.begun > 0) {
    try {
      EnsembleRecord begun = read_ensemble(run_folder / part_file(planned));
      require_shape(run_folder / part_file(planned), begun, planned.spec, 0, planned.spec.response.blocks);
      return go_on_from(std::move(begun), planned.begun);
    } catch (const InputError&) {  // NOLINT(bugprone-empty-catch): the plan read no further than the configuration
    }
  }
  if (planned.smaller == nullptr) return nothing;
  EnsembleRecord smaller = *planned.smaller;
  smaller.sums = in_memory(smaller.sums);
  return go_on_from(std::move(smaller), samples_begun(*planned.smaller) / group_size);
}

/// Whether an ensemble is drawn in memory, all of its blocks at once, and not a block for each thread. There it takes
/// this three times: what there is, what a stop would go back to, what is being written.
bool fits_in_memory(const EnsembleSpec& spec) {
  constexpr double most_bytes = 16e6;
  const BlockSums shapes = begin_blocks(spec, 0, 0).sums;
  double numbers = 0;
  for (const auto& [name, quantity] : shapes.quantities) numbers += quantity.width;
  return 8.0 * numbers * static_cast<double>(shapes.layers.size()) * spec.response.blocks <= most_bytes;
}

/// Draws what is missing of the ensemble, keeping what there is now and then.
EnsembleRecord draw_whole(const PlannedEnsemble& planned, const std::filesystem::path& run_folder, int threads,
                          ProgressStyle progress, const PartPolicy& parts) {
  const EnsembleSpec& spec = planned.spec;
  std::uint64_t done = 0;
  EnsembleRecord record = beginning_of(planned, run_folder, done);
  const std::uint64_t there = std::min(spec.response.samples, done * group_size);
  if (done > 0) log_line(progress, "sampling {}: going on after {} piles", planned.label, there);
  const SamplerSpec sampler = measure_sampler(planned, progress);
  Progress shown(fmt::format("sampling {}", planned.label), spec.response.samples - there, progress);
  draw_in_pieces(spec, sampler, done, record, threads, &shown, parts, [&](std::uint64_t groups) {
    EnsembleRecord part = record;
    part.configuration = part_configuration(spec, groups);
    part.configuration_key = cache_key(part.configuration);
    write_ensemble(run_folder / part_file(planned), part);
  });
  shown.finish();
  return record;
}

}  // namespace

std::uint64_t samples_there(const PlannedEnsemble& planned) {
  const std::uint64_t smaller = planned.smaller == nullptr ? 0 : samples_begun(*planned.smaller);
  return std::min(planned.spec.response.samples, std::max(smaller, planned.begun * group_size));
}

std::filesystem::path part_file(const PlannedEnsemble& planned) {
  std::filesystem::path file = planned.file;
  return file.replace_extension(".part.h5");
}

void look_for(PlannedEnsemble& planned, const std::filesystem::path& run_folder) {
  planned.reusable = false;
  planned.replaces.clear();
  planned.begun = groups_begun(planned, run_folder);
  planned.blocks_there = BlockFiles(planned, run_folder).count();
  if (!is_there(run_folder, planned.file)) return;
  const std::filesystem::path file = run_folder / planned.file;
  try {
    const std::string there = read_ensemble_configuration(file);
    const std::string wanted = configuration_text(planned.spec) + planned.notes;
    planned.reusable = there == wanted;
    if (!planned.reusable) planned.replaces = "it is of another experiment: " + describe_difference(there, wanted);
    if (!planned.reusable && only_more_samples(there, wanted)) {
      planned.replaces +=
          fmt::format(" (piles are drawn {0} at a time: only from a multiple of {0} more go on)", group_size);
    }
  } catch (const InputError& damage) {
    planned.replaces = damage.what();  // damaged or foreign
  }
}

namespace {

/// What the stored configuration of a growing ensemble says beside its spec: from where it grew, and towards what.
std::string growth_notes(std::uint64_t first_samples, const PrecisionSpec& asked) {
  if (asked.effective > 0)
    return fmt::format("first_samples={}\neffective={}\n", first_samples, exact(asked.effective));
  return fmt::format("first_samples={}\nprecision_c={}\nprecision_D={}\n", first_samples, exact(asked.c),
                     exact(asked.D));
}

/// Makes it begin with so many samples, in whole rounds, and grow from there.
void let_grow(PlannedEnsemble& planned, std::uint64_t first_samples, const PrecisionSpec& towards) {
  const std::uint64_t round = round_of(planned.spec);
  planned.spec.response.samples = planned.grows_from = (first_samples + round - 1) / round * round;
  planned.towards = towards;
  planned.notes = growth_notes(planned.grows_from, towards);
}

/// A growing ensemble goes on from a smaller or equally demanding one of the same first size: where that one was looked
/// at and found wanting, this one would have been, too. Then `planned` becomes what is there.
void look_for_smaller(PlannedEnsemble& planned, const std::filesystem::path& run_folder) {
  const PrecisionSpec& asked = planned.towards;
  if (planned.reusable || !is_there(run_folder, planned.file)) return;
  const std::filesystem::path file = run_folder / planned.file;
  try {
    const std::map<std::string, std::string> there = settings_of(read_ensemble_configuration(file));
    const auto number = [&](const char* key) {
      const auto found = there.find(key);
      const double value = found == there.end() ? 0 : std::strtod(found->second.c_str(), nullptr);
      return value > 0 ? value : std::numeric_limits<double>::infinity();
    };
    PrecisionSpec towards = asked;
    towards.effective = std::isinf(number("effective")) ? 0 : number("effective");
    towards.c = std::isinf(number("precision_c")) ? 0 : number("precision_c");
    towards.D = std::isinf(number("precision_D")) ? 0 : number("precision_D");
    const bool no_less_demanding =
        (asked.c > 0 ? asked.c : std::numeric_limits<double>::infinity()) <= number("precision_c") &&
        (asked.D > 0 ? asked.D : std::numeric_limits<double>::infinity()) <= number("precision_D") &&
        asked.effective >= towards.effective;
    if (!no_less_demanding) return;
    for (std::uint64_t rounds = planned.grows_from / round_of(planned.spec);
         rounds * round_of(planned.spec) <= asked.most_samples; rounds = next_size(rounds)) {
      PlannedEnsemble candidate = planned;
      candidate.spec.response.samples = rounds * round_of(planned.spec);
      if (static_cast<double>(candidate.spec.response.samples) != number("samples")) continue;
      candidate.notes = growth_notes(planned.grows_from, towards);
      look_for(candidate, run_folder);
      if (candidate.reusable) planned = candidate;
    }
  } catch (const InputError&) {  // NOLINT(bugprone-empty-catch): look_for has said why it cannot be used
  }
}

/// An ensemble goes on from one of fewer samples, in whole groups, that is the same otherwise.
void look_for_beginning(PlannedEnsemble& planned, const std::filesystem::path& run_folder) {
  if (planned.reusable || !is_there(run_folder, planned.file)) return;
  try {
    const std::uint64_t samples = count_in(read_ensemble_configuration(run_folder / planned.file), "samples");
    if (samples == 0 || samples >= planned.spec.response.samples || samples % group_size != 0) return;
    PlannedEnsemble beginning = planned;
    beginning.spec.response.samples = samples;
    look_for(beginning, run_folder);
    if (!beginning.reusable) return;
    std::optional<MeasuredEnsemble> found = reuse_ensemble(beginning, run_folder);
    planned.replaces = beginning.replaces;  // what is damaged, if it is
    if (!found) return;
    planned.smaller = std::make_shared<const EnsembleRecord>(std::move(found->record));
    planned.groups_before = samples / group_size;
  } catch (const InputError&) {  // NOLINT(bugprone-empty-catch): look_for has said why it cannot be used
  }
}

}  // namespace

bool grow(PlannedEnsemble& planned, EnsembleRecord record, const std::filesystem::path& run_folder) {
  const std::uint64_t round = round_of(planned.spec), next = round * next_size(planned.spec.response.samples / round);
  if (next > planned.towards.most_samples) return false;
  planned.groups_before = planned.spec.response.samples / group_size;
  planned.spec.response.samples = next;
  planned.notes = growth_notes(planned.grows_from, planned.towards);
  planned.begun = groups_begun(planned, run_folder);
  planned.blocks_there = BlockFiles(planned, run_folder).count();
  planned.smaller = std::make_shared<const EnsembleRecord>(std::move(record));
  planned.reusable = false;
  planned.replaces.clear();
  return true;
}

std::uint64_t expected_samples(const PlannedEnsemble& planned, double samples_needed) {
  const std::uint64_t round = round_of(planned.spec);
  return round * expected_size(planned.spec.response.samples / round, samples_needed / static_cast<double>(round),
                               planned.towards.most_samples / round);
}

Transport measure_for_precision(const PlannedEnsemble& planned, const MeasuredEnsemble& ensemble, const FitSpec& fit,
                                int threads) {
  if (planned.towards.effective == 0) return measure_transport(ensemble, fit, {}, threads).transport;
  Transport measured;
  measured.spec = ensemble.spec;
  measured.effective_samples = effective_samples(ensemble.record.sums);
  return measured;
}

std::vector<PlannedEnsemble> plan_ensembles(const Experiment& experiment, const std::filesystem::path& run_folder) {
  std::vector<PlannedEnsemble> planned;
  const ScanParameter& scan = experiment.scanned();
  for (const double value : experiment.scan_values()) {
    PlannedEnsemble ensemble;
    EnsembleSpec& spec = ensemble.spec;
    spec = experiment.main_ensemble(value);
    const std::uint64_t one_group_each = static_cast<std::uint64_t>(spec.response.blocks) * group_size;
    const bool frictionless = spec.sampler.model.has_contacts() && spec.sampler.mu == 0;
    if (frictionless) spec.response.samples = std::min(spec.response.samples, one_group_each);
    ensemble.file = std::filesystem::path("ensembles") / (scan.file_part(spec.sampler) + ".h5");
    ensemble.label = fmt::format("{} = {}", scan.name, value);
    if (!frictionless && experiment.precision.asked()) let_grow(ensemble, spec.response.samples, experiment.precision);
    look_for(ensemble, run_folder);
    if (ensemble.grows_from > 0) {
      look_for_smaller(ensemble, run_folder);
    } else {
      look_for_beginning(ensemble, run_folder);
    }
    planned.push_back(std::move(ensemble));
  }
  return planned;
}

PlannedEnsemble plan_ensemble(const StudyEnsemble& asked, const std::filesystem::path& run_folder) {
  PlannedEnsemble planned;
  planned.label = asked.label;
  planned.spec = asked.spec;
  planned.file = std::filesystem::path("ensembles") / (asked.file + ".h5");
  if (asked.effective > 0) {
    let_grow(planned, 1, {.most_samples = asked.spec.response.samples, .effective = asked.effective});
    look_for(planned, run_folder);
    look_for_smaller(planned, run_folder);
    return planned;
  }
  look_for(planned, run_folder);
  look_for_beginning(planned, run_folder);
  return planned;
}

std::optional<MeasuredEnsemble> reuse_ensemble(PlannedEnsemble& planned, const std::filesystem::path& run_folder) {
  if (!planned.reusable) return std::nullopt;
  try {
    MeasuredEnsemble there{planned.spec, open_ensemble(run_folder / planned.file)};
    require_shape(run_folder / planned.file, there.record, planned.spec, 0, planned.spec.response.blocks);
    return there;
  } catch (const InputError& damage) {
    // The plan read no further than the configuration.
    planned.reusable = false;
    planned.replaces = damage.what();
    return std::nullopt;
  }
}

namespace {

/// Removes what stops have left of an ensemble that is whole, but not what they have drawn of the next size of a
/// growing one.
void forget_unfinished(const PlannedEnsemble& planned, const std::filesystem::path& run_folder) {
  const auto goes_on = [&](const std::filesystem::path& file) {
    if (planned.grows_from == 0) return false;
    try {
      return count_in(read_ensemble_configuration(file), "samples") > planned.spec.response.samples;
    } catch (const InputError&) {
      return false;
    }
  };
  const std::filesystem::path part = run_folder / part_file(planned);
  if (path_exists(part) && !goes_on(part)) remove_if_there(part);
  const BlockFiles blocks(planned, run_folder);
  for (const std::filesystem::path& file : blocks.there()) {
    if (goes_on(file)) return;
  }
  blocks.remove();
}

}  // namespace

MeasuredEnsemble obtain_ensemble(PlannedEnsemble& planned, const std::filesystem::path& run_folder, int threads,
                                 ProgressStyle progress, const PartPolicy& parts) {
  if (std::optional<MeasuredEnsemble> there = reuse_ensemble(planned, run_folder)) {
    log_line(progress, "sampling {}: {} piles already there", planned.label, planned.spec.response.samples);
    forget_unfinished(planned, run_folder);
    return *std::move(there);
  }
  const std::filesystem::path file = run_folder / planned.file;
  if (!planned.replaces.empty()) {
    log_line(progress, "sampling {}: {} is drawn again and replaced once the new one is whole: {}", planned.label,
             planned.file.string(), planned.replaces);
  }
  // What would be lost in the end is missed before anything is drawn.
  make_folder(file.parent_path());
  require_writable(file);
  if (planned.blocks_there > 0 || (planned.begun == 0 && !fits_in_memory(planned.spec))) {
    BlockFiles(planned, run_folder).complete(threads, progress, parts);
    forget_unfinished(planned, run_folder);
    return {planned.spec, open_ensemble(file)};
  }
  MeasuredEnsemble drawn{planned.spec, draw_whole(planned, run_folder, threads, progress, parts)};
  drawn.record.configuration += planned.notes;
  drawn.record.configuration_key = cache_key(drawn.record.configuration);
  write_ensemble(file, drawn.record);
  forget_unfinished(planned, run_folder);
  return drawn;
}

void SampleStage::draw_by_crew(const std::vector<PlannedEnsemble>& ensembles) {
  if (options_.crew == nullptr) return;
  options_.crew->draw(experiment_, options_, ensembles);
  for (const PlannedEnsemble& planned : ensembles) {
    if (!planned.reusable) drawn_by_crew_.insert(planned.file);
  }
}

MeasuredEnsemble SampleStage::obtain(PlannedEnsemble& planned) {
  MeasuredEnsemble ensemble;
  const auto start = std::chrono::steady_clock::now();
  const std::uint64_t there = samples_there(planned);
  timed(data_.timings, "sample " + planned.label,
        [&] { ensemble = obtain_ensemble(planned, options_.folder, options_.threads, options_.progress); });
  StageTiming& timing = *std::ranges::find_if(
      data_.timings, [&](const StageTiming& one) { return one.stage == "sample " + planned.label; });
  const bool reused = planned.reusable && !drawn_by_crew_.contains(planned.file);
  if (reused) {
    const auto earlier = earlier_.find(timing.stage);
    timing = earlier == earlier_.end() ? StageTiming{timing.stage, std::nan(""), true} : earlier->second;
  } else {
    const std::uint64_t beads = beads_of(planned.spec, planned.spec.response.samples - there);
    drawn_in_seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    drawn_in_this_run_ += static_cast<double>(beads);
    timing.beads += beads;
    drawn_();
  }
  if (const auto& failed = ensemble.record.failed; !failed.empty()) {
    log_line(
        options_.progress,
        "{}: averages do without {} of {} piles, which could not be completed{}; this command meets the first failure: "
        "{}",
        planned.label, failed.size(), planned.spec.response.samples,
        failed.size() < planned.spec.response.samples ? "" : " (take fewer columns, more effort or another law)",
        failed.front().replay);
  }
  completed_ += planned.spec.response.samples - ensemble.record.failed.size();
  ++obtained_;
  if (reused) ++reused_;
  return ensemble;
}

/// ", 54 s more" at the rate at which beads were drawn in this run, once there is one.
std::string SampleStage::time_for(const EnsembleSpec& spec, std::uint64_t samples) const {
  const auto beads = static_cast<double>(beads_of(spec, samples));
  if (drawn_in_seconds_ <= 0 || drawn_in_this_run_ <= 0) return "";
  return fmt::format(", {} more", describe_duration(beads * drawn_in_seconds_ / drawn_in_this_run_));
}

PrecisionOutcome SampleStage::reach_precision(PlannedEnsemble& planned, MeasuredEnsemble& ensemble) {
  if (planned.grows_from == 0) return {};
  const PrecisionSpec asked = planned.towards;
  PrecisionOutcome outcome{true, asked.c, asked.D, false, {}};
  bool counted = planned.reusable && !drawn_by_crew_.contains(planned.file);  // as reused
  for (;;) {
    Transport measured;
    timed(data_.timings, "analyse",
          [&] { measured = measure_for_precision(planned, ensemble, experiment_.fit, options_.threads); });
    const std::uint64_t samples = planned.spec.response.samples;
    const PrecisionLook look = look_at_precision(asked, measured, samples);
    outcome.reached = look.reached;
    outcome.reason = look.reason;
    if (look.reached || look.unattainable) break;
    const bool of_study = asked.effective > 0;
    const char* const limit = of_study ? "samples" : "precision.most_samples";
    const std::string so_far =
        of_study ? fmt::format("worth {} independent piles", significant(measured.effective_samples.value, 2))
                 : fmt::format("c ± {}, D ± {}", significant(measured.c.standard_error, 2),
                               significant(measured.D.standard_error, 2));
    if (!grow(planned, std::move(ensemble.record), options_.folder)) {
      ensemble.record = open_ensemble(options_.folder / planned.file);
      outcome.reason =
          fmt::format("{} piles: {}; about {} would be needed, and the next step would be more than {} = {}", samples,
                      so_far, significant(look.samples_needed, 2), limit, asked.most_samples);
      break;
    }
    const std::uint64_t stop = expected_samples(planned, look.samples_needed);
    const bool allowed = static_cast<double>(stop) >= look.samples_needed;
    log_line(options_.progress, "{}: {} after {} piles; about {} in all are needed, {} {}{}", planned.label, so_far,
             samples, significant(look.samples_needed, 2), stop,
             allowed ? "with whole steps" : fmt::format("are as many as {} allows", limit),
             time_for(planned.spec, stop - samples));
    if (options_.crew != nullptr) {
      draw_by_crew({planned});
      look_for(planned, options_.folder);
    }
    const bool reused = planned.reusable;
    const std::size_t reused_before = reused_;
    ensemble = obtain(planned);
    --obtained_;  // it is still the same one, and not reused if any of it was drawn
    const bool reused_again = reused_ > reused_before;
    reused_ = reused_before - (counted && !reused_again ? 1U : 0U);
    counted = counted && reused_again;
    planned.reusable = reused && planned.reusable;
  }
  if (outcome.reached) ensemble.record.sums.scatter = stopped_scatter(planned.spec.response.blocks);
  return outcome;
}

void SampleStage::tell_reuse() {
  if (reused_ == 0) return;
  data_.reuse = fmt::format("Already there, and not drawn again: {} of {}.", reused_, how_many(obtained_, "ensemble"));
}

void SampleStage::tell_rounding(const SamplerCounts& counts) {
  if (counts.beads == 0 || !experiment_.sampling.model.has_contacts()) return;
  const std::string beads = significant(static_cast<double>(counts.beads), 3);
  data_.checks.push_back(
      counts.rounded == 0
          ? fmt::format(
                "Rounding carried none of the {} beads of the main ensembles out of the interval that has a solution.",
                beads)
          : fmt::format("Rounding carried {1} of the {0} beads of the main ensembles out of the interval that has a "
                        "solution; they were put onto its end.",
                        beads, counts.rounded));
}

double seconds_to_draw(const PlannedEnsemble& planned, int threads) {
  if (planned.reusable) return 0;
  constexpr double seconds_per_bead = 1e-8;  // of granusolve at small friction
  const double blocks = planned.spec.response.blocks;
  const double left = 1 - static_cast<double>(samples_there(planned)) /
                              std::max(1.0, static_cast<double>(planned.spec.response.samples));
  return seconds_per_bead * relative_cost(planned.spec) * (left * blocks - planned.blocks_there) / threads;
}

double seconds_for_fits(const EnsembleSpec& spec) {
  constexpr double seconds_per_fitted_bead = 3e-7;  // each bead of a profile, in each block and in all together
  if (!spec.record_profiles) return 0;
  return seconds_per_fitted_bead * static_cast<double>(recorded_layers(spec).size()) * (spec.response.blocks + 1) *
         spec.lattice.columns;
}

std::string RunProgress::line(double done, double total, double seconds) {
  if (!(done > 0) || !(total > done)) return "";
  return fmt::format("whole run: {:.0f} %, about {} left", std::floor(100 * done / total),
                     describe_duration(seconds * (total - done) / done));
}

void RunProgress::finish(double cost) {
  done_ += cost;
  const auto now = Clock::now();
  constexpr auto interval = std::chrono::seconds(10);
  if (now - told_ < interval) return;
  told_ = now;
  const std::string told = line(done_, total_, std::chrono::duration<double>(now - started_).count());
  if (!told.empty()) log_line(style_, told);
}

std::vector<std::string> law_description(const std::string& law) {
  std::istringstream lines{std::string(template_file("law/" + law + ".txt"))};
  std::vector<std::string> sentences;
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty()) sentences.push_back(line);
  }
  return sentences;
}

}  // namespace granuscope
