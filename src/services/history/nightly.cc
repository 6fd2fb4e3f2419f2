#include "history/nightly.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <stdexcept>
#include <system_error>

#include "analysis/claims.h"
#include "experiment/experiment_file.h"
#include "history/comparison.h"
#include "pipeline/run_folder.h"
#include "pipeline/sample_stage.h"
#include "plot/gnuplot.h"
#include "report/run_files.h"
#include "storage/ensemble_file.h"
#include "support/error.h"
#include "support/files.h"
#include "support/plain_text.h"
#include "support/provenance.h"

namespace granuscope {
namespace {
constexpr std::uint64_t canary_share = 8;
// What the book says of folders, by settle_folders.
constexpr const char *new_reference = "new_reference", *no_reference = "none", *pool_ends = "pool_ends",
                     *made_reference = "made_reference", *begun = "begun";
constexpr const char* counted = "counted";                        // begun: "yes" until samples of a pool are there
constexpr const char *lost_canary = "lost", *lost_pool = "pool";  // kinds of alarms: the reference, the pool is
constexpr const char* frictionless_claim = "frictionless";        // holds exactly, whatever was drawn

std::uint64_t round_of(const Experiment& experiment) {
  return group_size * static_cast<std::uint64_t>(experiment.response.blocks);
}

std::uint64_t whole_rounds(const Experiment& experiment, std::uint64_t samples) {
  const std::uint64_t round = round_of(experiment);
  return std::max<std::uint64_t>(1, (samples + round - 1) / round) * round;
}

/// The main line alone, and nothing shown.
Experiment canary_of(const Experiment& experiment) {
  Experiment canary = experiment;
  canary.response.samples = whole_rounds(experiment, experiment.response.samples / canary_share);
  canary.precision = {};
  canary.studies = Experiment().studies;
  canary.figures.bead_forces = canary.figures.response_profiles = canary.figures.transport_with_depth = false;
  canary.figures.propagation_against_diffusion = canary.figures.scaling_with_friction = false;
  canary.figures.propagation_and_thrust = false;
  canary.force_chains.show = canary.response_field.show = false;
  canary.pictures.clear();
  canary.report.pdf = false;
  return canary;
}

Experiment pool_of(const Experiment& experiment, std::uint64_t samples) {
  Experiment pool = experiment;
  pool.response.samples = samples;
  pool.precision = {};
  return pool;
}

/// A sentence as a part of another one.
std::string as_clause(std::string sentence) {
  while (sentence.ends_with('.')) sentence.pop_back();
  return sentence;
}

/// A history begins in an empty folder, and one that has lost its database is not begun anew. Returns the folder.
const fs::path& require_history(const fs::path& folder) {
  std::error_code none;
  if (const fs::path database = folder / "history.sqlite"; fs::file_size(database, none) > 0 && !none) return folder;
  require_no_lost_history(folder);
  for (const fs::path& entry : entries_of(folder)) {
    const std::string name = entry.filename().string();
    if (name.starts_with("history.sqlite") || name.starts_with(".granuscope-")) continue;
    throw InputError(
        "{}: this folder is neither empty nor a history, and a history would replace and remove files in it; name an "
        "empty folder",
        folder.string());
  }
  return folder;
}

void move_folder(const fs::path& from, const fs::path& to) {
  remove_run(to);
  std::error_code error;
  fs::rename(from, to, error);
  if (error) {
    throw EnvironmentError("cannot move '{}' to '{}': {}; make room or check the permissions", from.string(),
                           to.string(), error.message());
  }
}

/// Files are replaced, never changed: a second name for one is a copy.
void keep_copy(const fs::path& from, const fs::path& to) {
  std::error_code error;
  fs::create_hard_link(from, to, error);
  if (!error) return;
  StreamedFile copy(to);
  read_chunks(from, [&](std::string_view chunk) { copy.append(chunk); });
  copy.commit();
}

/// What came in: the sums with it less the sums before.
EnsembleRecord piece_between(const EnsembleRecord& before, EnsembleRecord after) {
  const auto subtract = [](std::vector<double>& from, const std::vector<double>& what) {
    if (from.size() != what.size()) throw std::logic_error("the pool's ensembles before and after differ in shape");
    std::transform(from.begin(), from.end(), what.begin(), from.begin(), std::minus<>());
  };
  for (std::size_t b = 0; b < after.sums.count.size(); ++b) after.sums.count[b] -= before.sums.count.at(b);
  for (auto& [name, quantity] : after.sums.quantities) {
    const QuantitySums& then = before.sums.quantities.at(name);
    subtract(quantity.sum, then.sum);
    subtract(quantity.sum_of_squares, then.sum_of_squares);
  }
  std::erase_if(after.failed, [&](const FailedSample& failed) {
    return std::ranges::any_of(before.failed, [&](const FailedSample& old) { return old.sample == failed.sample; });
  });
  return after;
}

/// What a claim's verdict goes by, in standard errors: the distance from the paper's number or, where the claim is to
/// exclude another one, from that; NaN where it goes by neither.
double deciding_distance(const Json& claim) {
  if (claim.at("z_score").is_number()) return claim.at("z_score").get<double>();
  const Json& rival = claim.at("rival");
  if (rival.is_object() && rival.at("distance").is_number()) return rival.at("distance").get<double>();
  return std::numeric_limits<double>::quiet_NaN();
}

[[noreturn]] void fail_as_damaged(const fs::path& folder, const char* what) {
  throw InputError("{}: history.sqlite {}, and is damaged; take it from a backup, or begin another --history",
                   folder.string(), what);
}

/// What an accepted night does to the folders. The book says so first: where the process was killed before it was done,
/// the next one does it.
void settle_folders(const fs::path& folder, NightBook& book) {
  const std::string reference = book.state(new_reference), pool = book.state(pool_ends);
  if (reference.empty() && pool.empty()) return;
  if (!pool.empty() && book.state("samples") != "0") fail_as_damaged(folder, "says that a pool of piles ends");
  const bool kept_canary = reference.starts_with("alarm-") && reference.size() > 6 &&
                           reference.find_first_not_of("0123456789", 6) == std::string::npos;
  if (!reference.empty() && reference != no_reference && !kept_canary) {
    throw InputError(
        "{}: the history names '{}' where a canary that it has kept would stand, so that a folder of somebody else "
        "would be moved; take the history from a backup",
        folder.string(), single_line(reference));
  }
  const fs::path canary = folder / "canary";
  if (reference == no_reference) {
    remove_run(canary / "reference");
  } else if (!reference.empty() && fs::exists(canary / reference)) {
    move_folder(canary / reference, canary / "reference");
  }
  if (!pool.empty()) {
    remove_run(folder / "pool");
    remove_run(folder / "before");
    book.keep({{begun, "yes"}});
  }
  book.keep({{new_reference, ""}, {pool_ends, ""}, {made_reference, fs::exists(canary / "reference") ? "yes" : ""}});
}

class NightRun {
 public:
  NightRun(const Experiment& experiment, const NightlyOptions& options)
      : experiment_(experiment), options_(options), lock_(options.folder), book_(require_history(options.folder)) {
    require_pool();
    settle_folders(options.folder, book_);
    night_.date = options.date.empty() ? current_time() : options.date;
    night_.experiment = print_experiment(experiment);
    constexpr std::size_t looked_back = 30;
    before_ = book_.last(looked_back);
    const auto tells_nothing = [](const Night& one) { return one.numbers.empty(); };  // of the pool
    if (std::ranges::all_of(before_, tells_nothing)) before_ = book_.last(0);
    std::erase_if(before_, tells_nothing);
    night_.samples = samples_there();
    const std::uint64_t room = most_samples - std::min(most_samples, night_.samples);
    if (options.grow > room || samples_of_night(experiment, options.grow) > room) {
      throw InputError(
          "the pool has {} samples and would grow beyond {}, the most of one seed; give a smaller --grow, or begin "
          "another --history with another sampling.seed",
          night_.samples, most_samples);
    }
  }

  Night go() {
    const bool same_experiment = !experiment_changed();
    if (same_experiment && canary_is_fine()) grow_pool();
    if (same_experiment && !night_.alarms.empty() && night_.alarms.front().kind == lost_canary)
      (void)keep_pool_before();  // tells at once what else is lost
    add_soft_alarms(night_, before_);
    const bool alarm = std::ranges::any_of(night_.alarms, [](const Alarm& one) { return one.state == "open"; });
    night_.status = alarm ? "alarm" : "fine";
    keep_report();
    std::map<std::string, std::string> state = {{"samples", std::to_string(night_.samples)}};
    if (book_.state("experiment").empty()) state["experiment"] = night_.experiment;
    if (night_.samples > 0) state[begun] = counted;
    night_.number = book_.add(night_, state);
    if (canary_alarmed_) move_folder(tonights_canary(), canary_folder() / fmt::format("alarm-{}", night_.number));
    prune_reports(options_.folder, book_, options_.keep);
    write_pages(options_.folder, book_);
    return night_;
  }

 private:
  fs::path canary_folder() const { return options_.folder / "canary"; }
  fs::path tonights_canary() const { return canary_folder() / "tonight"; }
  fs::path pool_folder() const { return options_.folder / "pool"; }
  fs::path before_folder() const { return options_.folder / "before"; }

  void alarm(const std::string& kind, const std::string& what) { night_.alarms.push_back({kind, what, "open"}); }

  bool experiment_changed() {
    const std::string accepted = book_.state("experiment");
    if (accepted.empty()) return false;
    const auto changed = changed_keys(keys_of_experiment(accepted), keys_of_experiment(night_.experiment));
    if (changed.empty()) return false;
    alarm("experiment",
          fmt::format("the experiment is another one, and nothing was drawn: {}; take the old file again, "
                      "begin another --history, or accept this night to begin the pool anew",
                      in_words(changed)));
    return true;
  }

  void run(const Experiment& experiment, const fs::path& folder, const std::string& what) {
    RunOptions options;
    options.folder = folder;
    options.threads = options_.threads;
    options.keep_going = true;
    options.progress = options_.progress;
    const auto start = std::chrono::steady_clock::now();
    const RunResult result = options_.run(experiment, options);
    night_.seconds[what] = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const RunRecord record = read_run(folder);
    if (record.manifest) night_.environment = environment_of(*record.manifest);
    if (!result.failure.empty()) alarm(result.code == ExitCode::environment ? lacking : "failed pile", result.failure);
  }

  /// A pool that the book does not know of is that of another history, or the book is: the book says so before the
  /// first pile is drawn.
  void require_pool() {
    if (!book_.state(begun).empty()) return;
    if (book_.count() > 0 || path_exists(options_.folder / "pool") || path_exists(options_.folder / "reports")) {
      throw InputError(
          "{}: history.sqlite knows of no pool, and yet there are nights, a pool or reports; put back the one that "
          "belongs to them, or begin another --history",
          options_.folder.string());
    }
    book_.keep({{begun, "yes"}});
  }

  /// 0 before the first night, and where an accepted one has ended the pool.
  std::uint64_t samples_there() const {
    const std::string text = book_.state("samples");
    std::uint64_t samples = 0;
    const bool whole = read_whole(text, samples) || (text.empty() && book_.count() == 0);
    const bool lost = book_.state(begun) == counted && (samples == 0 || book_.state("experiment").empty());
    if (!whole || lost)
      fail_as_damaged(options_.folder, "does not say how many samples the pool has, or of which experiment");
    return samples;
  }

  /// A run that breaks what always holds ends by logic_error, and one that cannot use what earlier nights left by
  /// InputError: those are alarms, not ends of the night.
  template <class Work>
  bool unbroken(const char* what, Work work) {
    try {
      work();
      return true;
    } catch (const std::logic_error& broken) {
      alarm("broken", fmt::format("{}: {}", what, broken.what()));
    } catch (const InputError& damage) {
      alarm("damaged", fmt::format("{}: {}", what, damage.what()));
    }
    return false;
  }

  bool canary_is_fine() {
    make_folder(canary_folder());
    remove_run(tonights_canary());
    if (!unbroken("the canary", [&] { run(canary_of(experiment_), tonights_canary(), "canary"); })) return false;
    const fs::path reference = canary_folder() / "reference";
    if (book_.state("samples").empty()) remove_run(reference);  // of a first night that was killed, and never told
    if (!fs::exists(reference)) {
      if (!book_.state("samples").empty() && book_.state(made_reference) == "yes") {
        alarm(lost_canary, fmt::format("'{}' is missing, which the same samples are held against each night; put it "
                                       "back, or accept this night to take the next one's",
                                       reference.string()));
        return false;
      }
      move_folder(tonights_canary(), reference);
      book_.keep({{made_reference, "yes"}});
      return true;
    }
    Comparison comparison;
    try {
      if (const std::string damaged = changed_since_run(reference, "", "", true); !damaged.empty()) {
        throw InputError("'{}' is missing or not what its night left there; put it back",
                         (reference / damaged).string());
      }
      comparison = compare_runs(reference, tonights_canary());
    } catch (const InputError& damage) {
      alarm(lost_canary, fmt::format("{}, or accept this night to take the next one's canary", damage.what()));
      return false;
    }
    if (comparison.likeness == Likeness::same || comparison.is_rounding() ||
        comparison.where == FirstDifference::plotting) {
      remove_run(tonights_canary());
      return true;
    }
    alarm("canary", fmt::format("the same samples give other numbers: {}", fmt::join(describe(comparison), "; ")));
    canary_alarmed_ = true;
    return false;
  }

  /// The pool's ensembles as they were before tonight, kept so that a night that is killed can be gone on with.
  /// False, with an alarm, if they are not there.
  bool keep_pool_before() {
    const fs::path marker = before_folder() / "samples";
    const bool kept = path_exists(marker) && read_file(marker) == std::to_string(night_.samples);
    // What earlier nights left there goes only once there is something to take its place.
    const std::vector<PlannedEnsemble> plan = night_.samples == 0
                                                  ? std::vector<PlannedEnsemble>()
                                                  : plan_ensembles(pool_of(experiment_, night_.samples), pool_folder());
    for (const PlannedEnsemble& planned : plan) {
      const fs::path file = pool_folder() / planned.file;
      if (planned.reusable || (kept && path_exists(file))) continue;
      alarm(lost_pool, fmt::format("'{}' {}{}{}, and nothing was drawn: put it back, or accept this night to begin the "
                                   "pool anew",
                                   file.string(),
                                   path_exists(file) ? "is not what the last night left there"
                                                     : "is missing, which the last night left there",
                                   planned.replaces.empty() ? "" : ", ", as_clause(planned.replaces)));
      return false;
    }
    if (kept) return true;
    remove_run(before_folder());
    if (night_.samples == 0) return true;
    make_folder(before_folder());
    for (const PlannedEnsemble& planned : plan) {
      try {
        (void)read_ensemble(pool_folder() / planned.file);  // the plan reads no further than the configuration
        keep_copy(pool_folder() / planned.file, before_folder() / planned.file.filename());
      } catch (const InputError& damage) {
        alarm("damaged", fmt::format("{}: its piles are drawn again", as_clause(damage.what())));
      }
    }
    write_file(marker, std::to_string(night_.samples));
    return true;
  }

  void grow_pool() {
    if (!keep_pool_before()) return;
    const std::uint64_t more = samples_of_night(experiment_, options_.grow);
    const Experiment pool = pool_of(experiment_, night_.samples + more);
    keep_last_points();
    if (!unbroken("the pool", [&] { run(pool, pool_folder(), "pool"); })) return;
    std::map<std::string, NightNumber> pieces = measure_pieces(pool);
    const RunRecord record = read_run(pool_folder());
    for (const KnownNumber& known : primary_numbers(record.summary)) {
      constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
      NightNumber number{known.name, known, unknown, unknown, unknown, false};
      if (const auto piece = pieces.find(known.name); piece != pieces.end()) {
        number = piece->second;
        number.pool = known;
      }
      night_.numbers.push_back(number);
    }
    for (const Json& claim : record.summary.at("claims")) {
      const std::string id = claim.at("id"), verdict = claim.at("verdict");
      night_.verdicts.push_back({id, verdict, deciding_distance(claim)});
      if (id == frictionless_claim && verdict == "not reproduced") {
        alarm("identity",
              fmt::format("{}: {}, which holds exactly for any piles", claim.at("statement").get<std::string>(),
                          claim.at("explanation").get<std::string>()));
      }
    }
    add_stage_times();
    night_.samples += more;
    report_made_ = true;
  }

  /// Tonight's figures have the points of the last night behind theirs.
  void keep_last_points() {
    const fs::path figures = pool_folder() / "figures";
    for (const std::string& file : earlier_figure_files(pool_folder())) {
      const std::string name = fs::path(file).filename(), last = figures / ("last-" + name);
      if (!name.ends_with(".csv") || name.starts_with(behind) || !path_exists(figures / name)) continue;
      remove_if_there(last);
      keep_copy(figures / name, last);
    }
  }

  void add_stage_times() {
    const Json timings = Json::parse(read_json(pool_folder() / "timings.json"));
    for (const Json& stage : timings.at("stages")) {
      if (stage.at("seconds").is_number())
        night_.seconds["pool: " + stage.at("stage").get<std::string>()] = stage.at("seconds");
    }
  }

  /// Tonight's piles by themselves, held against the pool before they came in. By name; empty on the first night.
  std::map<std::string, NightNumber> measure_pieces(const Experiment& pool) {
    std::vector<MeasuredTransport> measured;
    for (const PlannedEnsemble& planned : plan_ensembles(pool, pool_folder())) {
      if (planned.spec.sampler.mu == 0) continue;
      EnsembleRecord after = read_ensemble(pool_folder() / planned.file);
      const fs::path before = before_folder() / planned.file.filename();
      if (night_.samples > 0 && !fs::exists(before)) continue;  // it was damaged
      EnsembleRecord piece =
          night_.samples == 0 ? std::move(after) : piece_between(read_ensemble(before), std::move(after));
      if (!piece.failed.empty()) {
        alarm("failed pile",
              fmt::format("{}: {} could not be completed; this command meets the first failure: {}", planned.label,
                          how_many(piece.failed.size(), "pile"), piece.failed.front().replay));
      }
      if (night_.samples == 0) continue;
      EnsembleSpec spec = planned.spec;
      spec.response.samples -= night_.samples;
      measured.push_back(measure_transport({spec, std::move(piece)}, pool.fit, {}, options_.threads));
    }
    std::map<std::string, NightNumber> numbers;
    if (measured.empty() || before_.empty()) return numbers;
    const Analysis analysis = analyse(std::move(measured), pool.fit, pool.claims);
    std::vector<KnownNumber> known;
    for (const NightNumber& number : before_.back().numbers) known.push_back(number.pool);
    const int blocks = experiment_.response.blocks;
    for (const MovedNumber& one : hold_against(known, blocks, primary_numbers_of(analysis), blocks)) {
      numbers[one.name] = {one.name, {}, one.after.value, one.after.standard_error, one.z, one.moved};
    }
    return numbers;
  }

  /// The report of a night, whole or not at all.
  void keep_report() {
    if (!report_made_) return;
    const std::set<std::string> taken = book_.last_reports(std::numeric_limits<std::int32_t>::max());
    const std::string day = night_.date.substr(0, night_.date.find('T'));
    night_.report = day;
    const fs::path reports = options_.folder / "reports";
    for (int n = 2; taken.contains(night_.report) || fs::exists(reports / night_.report); ++n) {
      night_.report = fmt::format("{}-{}", day, n);
    }
    make_folder(reports);
    const fs::path unfinished = reports / ".unfinished";
    remove_run(unfinished);
    make_folder(unfinished);
    for (const char* file : {"summary.json", "summary.md", "claims.xml", "report.html", "report.pdf", "timings.json",
                             "manifest.json", "experiment.toml"}) {
      if (fs::exists(pool_folder() / file)) keep_copy(pool_folder() / file, unfinished / file);
    }
    move_folder(unfinished, reports / night_.report);
  }

  const Experiment& experiment_;
  const NightlyOptions& options_;
  RunFolder lock_;
  NightBook book_;
  Night night_;
  std::vector<Night> before_;
  bool canary_alarmed_ = false, report_made_ = false;
};

}  // namespace

std::uint64_t samples_of_night(const Experiment& experiment, std::uint64_t grow) {
  return whole_rounds(experiment, grow > 0 ? grow : experiment.response.samples);
}

Night run_night(const Experiment& experiment, const NightlyOptions& options) {
  try {
    return NightRun(experiment, options).go();
  } catch (const InputError&) {
    tell_not_run(options.folder);
    throw;
  }
}

void accept_night(const fs::path& folder, std::int64_t number) {
  const RunFolder lock(folder);
  NightBook book(folder, DatabaseUse::change);
  settle_folders(folder, book);
  const Night night = book.night(number);
  const auto has = [&](const char* kind) {
    return std::ranges::any_of(night.alarms,
                               [&](const Alarm& one) { return one.kind == kind && one.state != "accepted"; });
  };
  if (std::ranges::all_of(night.alarms, [](const Alarm& one) { return one.state == "accepted"; })) {
    write_pages(folder, book);  // of one who accepted it and was stopped
    throw InputError("night {} has no alarm that is not accepted yet, so that there is nothing to accept", number);
  }
  std::map<std::string, std::string> state;
  if (has("canary")) {
    const std::string kept = fmt::format("alarm-{}", number);
    const fs::path other = folder / "canary" / kept;
    if (!fs::exists(other)) {
      throw InputError(
          "the canary of night {} is not kept any more, so that nothing could be held against it; accept the last "
          "night that alarmed",
          number);
    }
    state[new_reference] = kept;
    // What was drawn by another law cannot be averaged with what comes.
    if (compare_runs(folder / "canary/reference", other).where == FirstDifference::sampling) state["samples"] = "0";
  }
  if (has(lost_canary)) state[new_reference] = no_reference;
  if (has(lost_pool)) state["samples"] = "0";
  if (has("experiment")) {
    state["experiment"] = night.experiment;
    state["samples"] = "0";
    state[new_reference] = no_reference;
  }
  if (state.contains("samples")) state[pool_ends] = "yes";
  book.accept(number, state);
  settle_folders(folder, book);
  write_pages(folder, book);
}

void forget_night(const fs::path& folder, std::int64_t number) {
  const RunFolder lock(folder);
  NightBook book(folder, DatabaseUse::change);
  const auto others = book.last(0);
  if (std::ranges::none_of(others, [&](const Night& one) { return one.number == number; })) write_pages(folder, book);
  book.forget(number);
  write_pages(folder, book);
}

void require_no_lost_history(const std::filesystem::path& folder) {
  for (const char* part : {"pool", "canary", "reports", "before"}) {
    if (!path_exists(folder / part)) continue;
    throw InputError(
        "{}: history.sqlite is missing or empty, which alone knows of the nights whose pool and reports are there; put "
        "it back, or begin another --history",
        folder.string());
  }
}

}  // namespace granuscope
