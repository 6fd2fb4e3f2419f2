#include "pipeline/sample_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <sstream>

#include "ensemble/estimator.h"
#include "pipeline/shards.h"
#include "pipeline/stage.h"
#include "storage/ensemble_file.h"
#include "support/plain_text.h"
#include "support/templates.h"

namespace granuscope {
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
    log_line(options_.progress,
             "{}: {} of {} piles could not be completed and enter no average; this command meets the first of these "
             "failures: {}",
             planned.label, failed.size(), planned.spec.response.samples, failed.front().replay);
  }
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
  const PrecisionSpec& asked = experiment_.precision;
  if (planned.grows_from == 0) return {};
  PrecisionOutcome outcome{true, asked.c, asked.D, false, {}};
  bool counted = planned.reusable && !drawn_by_crew_.contains(planned.file);  // as reused
  for (;;) {
    Transport measured;
    timed(data_.timings, "analyse",
          [&] { measured = measure_transport(ensemble, experiment_.fit, {}, options_.threads).transport; });
    const std::uint64_t samples = planned.spec.response.samples;
    const PrecisionLook look = look_at_precision(asked, measured, samples);
    outcome.reached = look.reached;
    outcome.reason = look.reason;
    if (look.reached || look.unattainable) break;
    if (!grow(planned, asked, std::move(ensemble.record), options_.folder)) {
      ensemble.record = open_ensemble(options_.folder / planned.file);
      outcome.reason = fmt::format(
          "{} piles give c ± {} and D ± {}; about {} would be needed, and the next step would be more than "
          "precision.most_samples = {}",
          samples, significant(measured.c.standard_error, 2), significant(measured.D.standard_error, 2),
          significant(look.samples_needed, 2), asked.most_samples);
      break;
    }
    const std::uint64_t stop = expected_samples(planned, asked, look.samples_needed);
    log_line(options_.progress, "{}: c ± {}, D ± {} after {} piles; about {} in all are needed, {} {}{}", planned.label,
             significant(measured.c.standard_error, 2), significant(measured.D.standard_error, 2), samples,
             significant(look.samples_needed, 2), stop,
             static_cast<double>(stop) < look.samples_needed ? "are as many as precision.most_samples allows"
                                                             : "with whole steps",
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
  data_.reuse = fmt::format("{} of {} ensembles were already there and were not drawn again.", reused_, obtained_);
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
