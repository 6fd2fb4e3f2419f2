#include "sampling/polytope.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <mutex>
#include <numeric>
#include <string>

#include "model/equilibrium.h"
#include "sampling/granusolve.h"
#include "support/error.h"
#include "support/progress.h"

namespace granuscope {
PolytopeSampler::PolytopeSampler(const SamplerSpec& spec, const Lattice& lattice)
    : Sampler(lattice),
      spec_(spec),
      measured_(spec),
      start_(std::make_unique<GranusolveSampler>(start_of_chain(spec), lattice)),
      chain_(FrictionCone(spec.mu, lattice.geometry()), lattice, spec.lambda) {}

std::optional<SamplingFailure> PolytopeSampler::draw(std::uint64_t sample, std::span<const double> load, Pile& pile) {
  const bool same_load = std::equal(load.begin(), load.end(), load_.begin(), load_.end());
  if (!same_load || chain_group_ != sample / group || in_group_ > sample % group) {
    if (!same_load) measured_ = with_measured_chain(spec_, lattice_, load);
    load_.assign(load.begin(), load.end());
    if (auto failure = begin_chain(sample, load)) return failure;
  }
  for (; in_group_ < sample % group; ++in_group_) {
    run(measured_.thinning);
    chain_.store(pile);  // at every sample, asked for or not, so that the chain does not depend on it
  }
  chain_.store(pile);
  pile.law = name_of(Law::polytope);
  pile.sample = sample;
  ++counts_.tries;
  counts_.beads += lattice_.beads();
  return std::nullopt;
}

std::optional<SamplingFailure> PolytopeSampler::begin_chain(std::uint64_t sample, std::span<const double> load) {
  chain_group_.reset();
  const std::uint64_t first = sample - sample % group;
  Pile start(lattice_);
  const std::uint64_t uniforms = start_->counts().uniforms;
  const auto failure = start_->draw(first, load, start);
  counts_.uniforms += start_->counts().uniforms - uniforms;
  if (failure) return failure;
  ++counts_.chains;
  counts_.burn_in += measured_.burn_in;
  counts_.thinning += measured_.thinning;
  chain_.set(start);
  key_ = RandomKey(spec_.seed, first);
  sweeps_ = 0;
  chain_.set_lambda(0);
  run(flat_sweeps);
  chain_.set_lambda(spec_.lambda);
  run(measured_.burn_in);
  Pile unused(lattice_);
  chain_.store(unused);
  chain_group_ = sample / group;
  in_group_ = 0;
  return std::nullopt;
}

void PolytopeSampler::run(std::uint64_t sweeps) {
  const std::uint64_t moves = chain_.moves(), accepted = chain_.accepted_moves();
  for (std::uint64_t k = 0; k < sweeps; ++k) {
    if (sweeps_ % 64 == 0) throw_if_interrupted();
    ++sweeps_;
    chain_.sweep([this](int layer, int bead) { return key_.chain_move(layer, bead, sweeps_); });
  }
  counts_.moves += chain_.moves() - moves;
  counts_.accepted_moves += chain_.accepted_moves() - accepted;
  counts_.uniforms += 2 * (chain_.moves() - moves);
}

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

}  // namespace

PolytopeChain::PolytopeChain(const FrictionCone& cone, const Lattice& lattice, double lambda)
    : cone_(cone),
      lattice_(lattice),
      lambda_(lambda),
      pile_(lattice),
      H_(lattice.beads()),
      length_(lattice.beads()),
      per_V_low_(1 / (cone.cotangent() * cone.t_minus())),
      per_V_high_(1 / (cone.cotangent() * cone.t_plus())),
      per_both_low_(1 / (1 - cone.cotangent() * cone.t_minus())),
      per_both_high_(1 / (cone.cotangent() * cone.t_plus() - 1)) {
  if (lambda == 0 && cone.mu() > 0 && BumpMoves::fit(lattice)) bumps_.emplace(cone, lattice);
}

double PolytopeChain::length(double V_R, double V_L, double H) const {
  const Interval interval = split_interval(cone_, {V_R, V_L}, H);
  return interval.high - interval.low;
}

void PolytopeChain::set(const Pile& pile) {
  pile_ = pile;
  for (std::size_t k = 0; k < lattice_.beads(); ++k) H_[k] = pile_.H_R[k] + pile_.H_L[k];
  set_lambda(lambda_);
}

void PolytopeChain::set_lambda(double lambda) {
  lambda_ = lambda;
  if (lambda_ == 0) return;
  for (std::size_t k = 0; k < lattice_.beads(); ++k) length_[k] = length(pile_.V_R[k], pile_.V_L[k], H_[k]);
}

void PolytopeChain::store(Pile& pile) {
  for (int n = 0; n < lattice_.layers(); ++n) {
    for (int i = 0; i < lattice_.columns(); ++i) {
      const std::size_t here = lattice_.index(n, i);
      const Incoming in = incoming(pile_, n, i);
      const Outgoing out = balance(cone_, in);
      pile_.V_R[here] = out.V_R;
      pile_.V_L[here] = out.V_L;
      H_[here] = in.H;
      pile_.H_L[here] = in.H - pile_.H_R[here];
      length_[here] = length(out.V_R, out.V_L, in.H);
    }
  }
  pile = pile_;
}

// Three kinds of contact bound t. With h the outward horizontal force, t- V <= h <= t+ V:
//   h += t                  (o, llr, lrr)        -(h - t- V) <= t <= t+ V - h
//   V += cot t            (outer ones of l, r, ll, rr)
//                                    -(t+ V - h)/(cot t+) <= t, and t <= (h - t- V)/(cot t-) or, where t- < 0, >=
//   h -= t, V -= cot t    (inner ones of l, r; lr)  t <= (h - t- V)/(1 - cot t-), t <= (t+ V - h)/(cot t+ - 1)
void PolytopeChain::null_move(int layer, int bead, UniformPair u) {
  ++moves_;
  const NullMove at(lattice_, layer, bead);
  struct Slack {
    double low, high;
  };
  const auto slack = [this](Contact contact) {
    return Slack{contact.h - cone_.t_minus() * contact.V, cone_.t_plus() * contact.V - contact.h};
  };
  const auto smaller = [](Slack a, Slack b) { return Slack{std::min(a.low, b.low), std::min(a.high, b.high)}; };
  Slack of_h = smaller(slack(right(at.o)), slack(left(at.o)));
  Slack of_V{infinity, infinity}, of_both{infinity, infinity};
  if (at.layers_below >= 1) {
    of_V = smaller(slack(left(at.l)), slack(right(at.r)));
    of_both = smaller(slack(right(at.l)), slack(left(at.r)));
  }
  if (at.layers_below >= 2) {
    of_V = smaller(of_V, smaller(slack(right(at.ll)), slack(left(at.rr))));
    of_both = smaller(of_both, smaller(slack(right(at.lr)), slack(left(at.lr))));
  }
  if (at.layers_below == 3) of_h = smaller(of_h, smaller(slack(right(at.llr)), slack(left(at.lrr))));
  double low = -of_h.low, high = of_h.high;
  if (at.layers_below >= 1) {
    low = std::max(low, -of_V.high * per_V_high_);
    high = std::min(high, std::min(of_both.low * per_both_low_, of_both.high * per_both_high_));
    if (cone_.t_minus() > 0) high = std::min(high, of_V.low * per_V_low_);
    if (cone_.t_minus() < 0) low = std::max(low, of_V.low * per_V_low_);
  }
  if (!(low < high)) return;  // a corner of the set, or one that rounding has made
  const double t = point_at({low, high}, u.first), shift = cone_.cotangent() * t;

  if (lambda_ > 0 && !accept_lengths(at, t, shift, u.second)) return;
  ++accepted_;
  at.add_to(pile_, t, shift);
  if (at.layers_below >= 1) {
    H_[at.l] -= t;
    H_[at.r] += t;
  }
  if (at.layers_below == 3) {
    H_[at.llr] += t;
    H_[at.lrr] -= t;
  }
}

// Accepts by the lengths of the seven beads, and keeps the new ones.
bool PolytopeChain::accept_lengths(const NullMove& at, double t, double shift, double u) {
  std::array<double, 7> lengths;
  double ratio = 1;
  std::size_t changed = 0;
  const auto change = [&](std::size_t k, double V_R, double V_L, double H) {
    const double now = length(pile_.V_R[k] + V_R, pile_.V_L[k] + V_L, H_[k] + H);
    lengths[changed++] = now;
    ratio *= length_[k] / now;
  };
  if (at.layers_below >= 1) {
    change(at.l, -shift, shift, -t);
    change(at.r, shift, -shift, t);
  }
  if (at.layers_below >= 2) {
    change(at.ll, shift, 0, 0);
    change(at.lr, -shift, -shift, 0);
    change(at.rr, 0, shift, 0);
  }
  if (at.layers_below == 3) {
    change(at.llr, 0, 0, t);
    change(at.lrr, 0, 0, -t);
  }
  if (std::any_of(lengths.data(), lengths.data() + changed, [](double one) { return !(one > 0); })) return false;
  // A length that rounding has made vanish (ratio 0 or less) is left at once.
  if (ratio > 0 && ratio < 1 && !(u < portable_power(ratio, lambda_))) return false;
  const std::array<std::size_t, 7> beads = {at.l, at.r, at.ll, at.lr, at.rr, at.llr, at.lrr};
  for (std::size_t k = 0; k < changed; ++k) length_[beads[k]] = lengths[k];
  return true;
}

void PolytopeChain::ring_move(int layer, double u) {
  ++moves_;
  Interval reach{-infinity, infinity};
  for (int i = 0; i < lattice_.columns(); ++i) {
    for (const Contact& contact : {right(lattice_.index(layer, i)), left(lattice_.index(layer, i))}) {
      reach = intersection(reach, {cone_.t_minus() * contact.V - contact.h, cone_.t_plus() * contact.V - contact.h});
    }
  }
  if (!(reach.low < reach.high)) return;
  ++accepted_;
  const double t = point_at(reach, u);
  for (int i = 0; i < lattice_.columns(); ++i) {
    pile_.H_R[lattice_.index(layer, i)] += t;
    pile_.H_L[lattice_.index(layer, i)] -= t;
  }
}

namespace {

constexpr std::uint64_t fewest_sweeps = 4096, most_pilot_sweeps = std::uint64_t{1} << 22;
/// Length of the pilot in autocorrelation times. The time is then known to about a third.
constexpr double pilot_times = 100;
/// The same for a forecast of how long chains will run, which is content with a factor of two.
constexpr double times_of_estimates = 20;

/// Below which the autocorrelation time hardly is, for telling a pilot that is too short to have seen the slow waves of
/// weight around the ring from one that has: within a factor of two of what pilots measured at lambda = 0 on 12 x 10 to
/// 72 x 56 beads with bumps and on fewer beads without; a third of it at lambda = 1. It grows with the length of the
/// wave, without bumps with its fourth power; the wave is not longer than the pile is deep.
double shortest_time_expected(const SamplerSpec& spec, const Lattice& lattice) {
  const double wave = std::min(lattice.columns(), lattice.layers());
  if (spec.lambda == 0 && BumpMoves::fit(lattice)) return 1.5 * wave;
  return 0.02 * wave * wave * wave * wave * (1 + 15 * spec.lambda * spec.mu);
}
constexpr int observed_layers = 8;
/// The pile starts from another law: this share of the pilot is burn-in.
constexpr double discarded_share = 0.25;

/// Series of slow observables, one entry every `stride` sweeps. When it is full, every second entry goes and the
/// stride doubles.
class SlowObservables {
 public:
  SlowObservables(const Lattice& lattice, double total_load) : lattice_(lattice), total_load_(total_load) {
    const int layers = lattice.layers(), step = std::max(1, (layers + observed_layers - 1) / observed_layers);
    // From the bottom, whose neighbours press from one side only, upwards.
    for (int n = layers - 1; n >= 0; n -= step) layers_.push_back(n);
    series_.resize(3 * layers_.size());
  }

  void record(const Pile& pile, std::uint64_t sweep) {
    if (sweep % stride_ != 0) return;
    const int columns = lattice_.columns();
    std::size_t at = 0;
    for (const int n : layers_) {
      double thrust = 0, halves = 0, shifted_halves = 0;
      for (int i = 0; i < columns; ++i) {
        const std::size_t here = lattice_.index(n, i);
        const double weight = pile.V_R[here] + pile.V_L[here];
        thrust += pile.H_R[here] - pile.H_L[here];
        halves += 2 * i < columns ? weight : -weight;
        shifted_halves += 4 * i >= columns && 4 * i < 3 * columns ? weight : -weight;
      }
      series_[at++].push_back(thrust / total_load_);
      series_[at++].push_back(halves / total_load_);
      series_[at++].push_back(shifted_halves / total_load_);
    }
    if (series_[0].size() == 2 * fewest_sweeps) halve();
  }

  /// Sweeps, of the slowest series.
  double autocorrelation_time() const {
    double longest = 1;
    for (const auto& series : series_) {
      const auto first = static_cast<std::ptrdiff_t>(discarded_share * static_cast<double>(series.size()));
      longest = std::max(longest, granuscope::autocorrelation_time({series.begin() + first, series.end()}, 1));
    }
    return longest * static_cast<double>(stride_);
  }

 private:
  void halve() {
    for (auto& series : series_) {
      for (std::size_t k = 0; 2 * k < series.size(); ++k) series[k] = series[2 * k];
      series.resize(series.size() / 2);
    }
    stride_ *= 2;
  }

  Lattice lattice_;
  double total_load_;
  std::vector<int> layers_;
  std::vector<std::vector<double>> series_;
  std::uint64_t stride_ = 1;
};

/// The chain over which the autocorrelation time is measured.
class Pilot {
 public:
  Pilot(const SamplerSpec& spec, const Lattice& lattice, std::span<const double> load)
      : spec_(spec),
        chain_(FrictionCone(spec.mu, lattice.geometry()), lattice, spec.lambda),
        observables_(lattice, std::accumulate(load.begin(), load.end(), 0.0)),
        key_(spec.seed, 0) {
    Pile start(lattice);
    if (const auto failure = GranusolveSampler(start_of_chain(spec), lattice).draw(0, load, start)) {
      throw InputError(
          "the chain of the law polytope starts from a pile of the law granusolve, but none could be "
          "completed under this load (it got stuck in layer {}); raise the effort or take a more even load",
          failure->layer);
    }
    chain_.set_lambda(0);
    chain_.set(start);
  }

  void run_to(std::uint64_t end) {
    for (; sweeps_ < end; ++sweeps_) {
      if (sweeps_ % 64 == 0) throw_if_interrupted();
      if (sweeps_ == flat_sweeps) chain_.set_lambda(spec_.lambda);
      chain_.sweep(
          [&](int layer, int bead) { return key_.pilot_move(layer, bead, static_cast<std::uint32_t>(sweeps_ + 1)); });
      observables_.record(chain_.pile(), sweeps_);
    }
  }

  std::uint64_t sweeps() const { return sweeps_; }
  double autocorrelation_time() const { return observables_.autocorrelation_time(); }

 private:
  SamplerSpec spec_;
  PolytopeChain chain_;
  SlowObservables observables_;
  RandomKey key_;
  std::uint64_t sweeps_ = 0;
};

/// Whether a pilot of so many sweeps holds the time so many times.
bool long_enough(std::uint64_t sweeps, double times, double time) {
  return (1 - discarded_share) * static_cast<double>(sweeps) >= times * time;
}

ChainPlan plan_for(double time, std::uint64_t pilot_sweeps) {
  const auto whole = [](double sweeps) { return static_cast<std::uint64_t>(std::ceil(sweeps)); };
  return {whole(burn_in_times * time), whole(thinning_times * time), time, pilot_sweeps};
}

}  // namespace

ChainPlan plan_chain(const SamplerSpec& spec, const Lattice& lattice, std::span<const double> load) {
  const auto too_slow = [&](const std::string& how) {
    return InputError(
        "the chain of the law polytope forgets its past too slowly on {} x {} beads ({}), so that its piles would not "
        "be independent; take a smaller pile, or state burn-in and thinning",
        lattice.columns(), lattice.layers(), how);
  };
  if (lattice.beads() > most_polytope_beads) throw too_slow(fmt::format("more than {} beads", most_polytope_beads));
  Pilot pilot(spec, lattice, load);
  for (std::uint64_t end = fewest_sweeps; end <= most_pilot_sweeps; end *= 2) {
    pilot.run_to(end);
    const double time = pilot.autocorrelation_time();
    if (long_enough(end, pilot_times, time)) return plan_for(time, end);
  }
  throw too_slow(fmt::format("not a hundred times in {} sweeps", most_pilot_sweeps));
}

ChainForecast estimate_chain_time(const SamplerSpec& spec, const Lattice& lattice, std::span<const double> load,
                                  double seconds) {
  constexpr std::uint64_t at_once = 16;  // sweeps between two looks at the clock
  ChainForecast forecast;
  Pilot pilot(spec, lattice, load);
  const double start = processor_seconds();
  double sweeping = 0;
  const auto run_to = [&](std::uint64_t end) {
    const double before = processor_seconds();
    do {
      pilot.run_to(std::min(end, pilot.sweeps() + at_once));
    } while (pilot.sweeps() < end && processor_seconds() - start < seconds);
    sweeping += processor_seconds() - before;
  };
  const bool measured = spec.burn_in == 0 || spec.thinning == 0;
  const double expected = shortest_time_expected(spec, lattice);
  // What a pilot has seen often enough stands, even below what is expected.
  const auto expected_at = [&](std::uint64_t sweeps) {
    return long_enough(sweeps, times_of_estimates, expected) ? 0 : expected;
  };
  double time = 0;
  for (std::uint64_t end = fewest_sweeps; end <= most_pilot_sweeps && !forecast.known; end *= 2) {
    run_to(end);
    if (!measured) break;
    time = std::max(pilot.autocorrelation_time(), expected_at(pilot.sweeps()));
    forecast.known = long_enough(pilot.sweeps(), times_of_estimates, time);
    if (processor_seconds() - start >= seconds) break;
  }
  forecast.seconds_per_sweep = sweeping / static_cast<double>(pilot.sweeps());
  forecast.plan = plan_for(time, 0);
  if (measured) {
    std::uint64_t end = fewest_sweeps;
    while (end < most_pilot_sweeps && !long_enough(end, pilot_times, time)) end *= 2;
    forecast.plan.pilot_sweeps = end;
  } else {
    forecast.known = true;
  }
  if (spec.burn_in > 0) forecast.plan.burn_in = spec.burn_in;
  if (spec.thinning > 0) forecast.plan.thinning = spec.thinning;
  return forecast;
}

namespace {

/// The plans of this process. A pilot may take minutes, and the same chain is asked for by an ensemble that grows in
/// steps, by the pictures and by the figures.
class KnownPlans {
 public:
  ChainPlan get(const SamplerSpec& spec, const Lattice& lattice, std::span<const double> load) {
    const std::vector<double> key = key_of(spec, lattice, load);
    {
      const std::lock_guard lock(mutex_);
      if (const auto known = outcomes_.find(key); known != outcomes_.end()) return known->second.get();
    }
    Outcome outcome;  // others may go on meanwhile
    try {
      outcome.plan = plan_chain(spec, lattice, load);
    } catch (const InputError& refused) {
      outcome.refusal = refused.what();
    }
    const std::lock_guard lock(mutex_);
    return outcomes_.emplace(key, outcome).first->second.get();
  }

 private:
  /// A plan, or the message of the InputError that stands for none.
  struct Outcome {
    ChainPlan plan;
    std::string refusal;
    const ChainPlan& get() const {
      if (!refusal.empty()) throw InputError(refusal);
      return plan;
    }
  };

  /// All that plan_chain depends on.
  static std::vector<double> key_of(const SamplerSpec& spec, const Lattice& lattice, std::span<const double> load) {
    std::vector<double> key = {spec.mu,
                               spec.lambda,
                               spec.effort,
                               static_cast<double>(spec.seed >> 32U),
                               static_cast<double>(spec.seed & 0xffffffffU),
                               static_cast<double>(spec.order),
                               static_cast<double>(lattice.columns()),
                               static_cast<double>(lattice.layers()),
                               spec.load_angle,
                               spec.load_offset,
                               spec.lean_excess ? 1.0 : 0.0,
                               spec.bead_weight};
    key.insert(key.end(), load.begin(), load.end());
    return key;
  }

  std::mutex mutex_;
  std::map<std::vector<double>, Outcome> outcomes_;
};

}  // namespace

SamplerSpec with_measured_chain(SamplerSpec spec, const Lattice& lattice, std::span<const double> load) {
  validate(spec);
  if (spec.law != Law::polytope || spec.mu == 0 || (spec.burn_in > 0 && spec.thinning > 0)) return spec;
  static KnownPlans known;
  const ChainPlan plan = known.get(spec, lattice, load);
  if (spec.burn_in == 0) spec.burn_in = plan.burn_in;
  if (spec.thinning == 0) spec.thinning = plan.thinning;
  return spec;
}

SamplerSpec start_of_chain(const SamplerSpec& spec) {
  const SamplerSpec usual;
  SamplerSpec start = spec;
  start.law = Law::granusolve;
  start.lambda = usual.lambda;
  start.burn_in = usual.burn_in;
  start.thinning = usual.thinning;
  return start;
}

namespace {

constexpr double windows = 6;       ///< beyond it noise exceeds what is left of the correlation, e^-6
constexpr double rounding = 1e-10;  ///< of many sums of rounded numbers, with room

}  // namespace

double autocorrelation_time(const std::vector<double>& series, double scale) {
  const std::size_t count = series.size();
  double mean = 0;
  for (double x : series) mean += x / static_cast<double>(count);
  std::vector<double> centred;
  centred.reserve(count);
  for (double x : series) centred.push_back(x - mean);
  const auto covariance = [&](std::size_t lag) {
    double sum = 0;
    for (std::size_t k = lag; k < count; ++k) sum += centred[k] * centred[k - lag];
    return sum;
  };
  const double variance = covariance(0);
  if (!(variance > rounding * scale * rounding * scale * static_cast<double>(count))) return 1;
  double time = 1;
  for (std::size_t lag = 1; lag < count; ++lag) {
    time += 2 * covariance(lag) / variance;
    if (static_cast<double>(lag) >= windows * time / 2) break;
  }
  return std::max(1.0, time);
}

NullMove::NullMove(const Lattice& lattice, int layer, int bead)
    : layers_below(std::min(3, lattice.layers() - 1 - layer)) {
  const int left = lattice.lower_left(layer, bead), right = lattice.lower_right(layer, bead);
  const auto at = [&](int down, int column) {
    return lattice.index(layer + (down <= layers_below ? down : 0), column);
  };
  o = at(0, bead);
  l = at(1, left);
  r = at(1, right);
  ll = at(2, lattice.previous(bead));
  lr = at(2, bead);
  rr = at(2, lattice.next(bead));
  llr = at(3, left);
  lrr = at(3, right);
}

void NullMove::add_to(Pile& forces, double t, double shift) const {
  forces.H_R[o] += t;
  forces.H_L[o] -= t;
  if (layers_below == 0) return;
  forces.H_R[l] -= t;
  forces.V_R[l] -= shift;
  forces.V_L[l] += shift;
  forces.H_L[r] += t;
  forces.V_L[r] -= shift;
  forces.V_R[r] += shift;
  if (layers_below == 1) return;
  forces.H_R[lr] -= t;
  forces.H_L[lr] += t;
  forces.V_R[lr] -= shift;
  forces.V_L[lr] -= shift;
  forces.V_R[ll] += shift;
  forces.V_L[rr] += shift;
  if (layers_below == 2) return;
  forces.H_R[llr] += t;
  forces.H_L[lrr] -= t;
}

std::array<double, flat_tests.size()> measure_flatness(const PileGroup& pile, int layer) {
  if (pile.piles != 1 || pile.stride != 1 || pile.V_R == nullptr || !pile.kept.empty()) {
    throw std::logic_error("flatness is measured of a single pile of which all forces are kept");
  }
  const Lattice& lattice = pile.lattice;
  const FrictionCone cone(pile.mu, lattice.geometry());
  const double columns = lattice.columns(), cotangent = cone.cotangent();
  double position = 0, squared = 0, thrust = 0, variance = 0, halves = 0, shifted = 0;
  for (int i = 0; i < lattice.columns(); ++i) {
    const NullMove at(lattice, layer, i);
    double low = -infinity, high = infinity;
    const auto bound = [&](double slack, double growth) {
      if (growth < 0) high = std::min(high, -slack / growth);
      if (growth > 0) low = std::max(low, -slack / growth);
    };
    // V in shifts, h outwards.
    const auto bound_contact = [&](double V, double h, double of_V, double of_h) {
      bound(h - cone.t_minus() * V, of_h - cone.t_minus() * cotangent * of_V);
      bound(cone.t_plus() * V - h, cone.t_plus() * cotangent * of_V - of_h);
    };
    const auto right = [&](std::size_t k, double V, double h) { bound_contact(pile.V_R[k], pile.H_R[k], V, h); };
    const auto left = [&](std::size_t k, double V, double h) { bound_contact(pile.V_L[k], -pile.H_L[k], V, h); };
    right(at.o, 0, 1), left(at.o, 0, 1);
    if (at.layers_below >= 1) right(at.l, -1, -1), left(at.l, 1, 0), right(at.r, 1, 0), left(at.r, -1, -1);
    if (at.layers_below >= 2) right(at.ll, 1, 0), right(at.lr, -1, -1), left(at.lr, -1, -1), left(at.rr, 1, 0);
    if (at.layers_below == 3) right(at.llr, 0, 1), left(at.lrr, 0, 1);
    if (low < high) {  // no corner
      const double x = -(low + high) / (high - low);
      position += x / columns, squared += (1.5 * x * x - 0.5) / columns;
    }
    const double w = pile.weight(at.o), beside = w - mean_weight(pile.bead_weight, layer);
    variance += beside * beside / columns;
    thrust += (pile.H_R[at.o] - pile.H_L[at.o]) / columns;
    halves += (2 * i < lattice.columns() ? w : -w) / columns;
    shifted += (4 * i >= lattice.columns() && 4 * i < 3 * lattice.columns() ? w : -w) / columns;
  }
  const double rank = 2.0 / 7 * static_cast<double>(pile.first_sample % PolytopeSampler::group) - 1;
  return {position, squared, rank * thrust, rank * variance, rank * (halves * halves + shifted * shifted)};
}

namespace {

/// A slack that grows by less than this part of the forces does so by rounding only.
constexpr double rounding_of_slacks = 1e-13;

}  // namespace

BumpMoves::BumpMoves(const FrictionCone& cone, const Lattice& lattice) : cone_(cone), lattice_(lattice) {
  for (int r = largest_radius(lattice); r >= least_radius; r /= 2) {
    const int step = static_cast<int>(std::sqrt(r));
    scales_.push_back(
        {{shape(r, 0), shape(r, 1)}, r - 1, lattice.layers() - 1 + r - 1, step, lattice.columns() / step});
  }
}

BumpMoves::Shape BumpMoves::shape(int radius, int parity) const {
  const int centre = radius + (radius + parity) % 2, middle = lattice_.columns() / 2;
  const Lattice around({.columns = lattice_.columns(), .layers = centre + radius + 3});
  Pile growth(around);  // in whole numbers, V without its factor cot(angle): exactly 0 wherever it is
  for (int n = centre - radius + 1; n < centre + radius; ++n) {
    for (int i = 0; i < around.columns(); ++i) {
      const int rows = std::abs(n - centre), twice_right = std::abs(2 * (i - middle) + n % 2 - parity);
      const int amount = radius - std::max(rows, (twice_right + rows) / 2);
      if (amount > 0) NullMove(around, n, i).add_to(growth, amount, amount);
    }
  }
  const auto per_slack = [](double grows, double size) {
    return std::abs(grows) < rounding_of_slacks * size ? 0 : 1 / grows;
  };
  Shape shape;
  const auto add = [&](bool right, double V, double H, Place place) {
    if (V == 0 && H == 0) return;
    V *= cone_.cotangent();
    auto edge =
        std::ranges::find_if(shape, [&](const Edge& one) { return one.right == right && one.V == V && one.H == H; });
    if (edge == shape.end()) {
      const double h = right ? H : -H, size = std::abs(V) + std::abs(H);
      edge = shape.insert(
          edge, {right, V, H, per_slack(h - cone_.t_minus() * V, size), per_slack(cone_.t_plus() * V - h, size), {}});
    }
    edge->places.push_back(place);
  };
  for (int n = 0; n < around.layers(); ++n) {
    for (int i = 0; i < around.columns(); ++i) {
      const std::size_t k = around.index(n, i);
      const int right = (i - middle + around.columns()) % around.columns();
      const Place place{(n - centre) * around.columns() + right, right};
      add(true, growth.V_R[k], growth.H_R[k], place);
      add(false, growth.V_L[k], growth.H_L[k], place);
    }
  }
  return shape;
}

bool BumpMoves::move(Pile& pile, const Shape& shape, int layer, int column, double u) const {
  const int columns = lattice_.columns(), wraps = columns - column, below = (lattice_.layers() - layer) * columns;
  const std::ptrdiff_t centre = static_cast<std::ptrdiff_t>(layer) * columns + column;
  const auto for_each_bead = [&](const Edge& edge, const auto& f) {
    for (const Place& place : edge.places) {
      if (place.index >= below) break;
      f(centre + place.index - (place.right < wraps ? 0 : columns));
    }
  };
  const double t_minus = cone_.t_minus(), t_plus = cone_.t_plus();
  double up = infinity, down = infinity;
  const auto bound = [&](double slack, double per_slack) {
    if (per_slack < 0) up = std::min(up, -per_slack * slack);
    if (per_slack > 0) down = std::min(down, per_slack * slack);
  };
  for (const Edge& edge : shape) {
    const double *const V = (edge.right ? pile.V_R : pile.V_L).data(), *const H =
                                                                           (edge.right ? pile.H_R : pile.H_L).data();
    const double outwards = edge.right ? 1 : -1;
    double low = infinity, high = infinity;
    for_each_bead(edge, [&](std::ptrdiff_t k) {
      const double h = outwards * H[k];
      low = std::min(low, h - t_minus * V[k]);
      high = std::min(high, t_plus * V[k] - h);
    });
    bound(low, edge.per_low);
    bound(high, edge.per_high);
  }
  if (!(-down < up)) return false;  // as in a corner of the set
  const double t = point_at({-down, up}, u);
  for (const Edge& edge : shape) {
    double *const V = (edge.right ? pile.V_R : pile.V_L).data(), *const H = (edge.right ? pile.H_R : pile.H_L).data();
    const double of_V = t * edge.V, of_H = t * edge.H;
    for_each_bead(edge, [&](std::ptrdiff_t k) {
      V[k] += of_V;
      H[k] += of_H;
    });
  }
  return true;
}

}  // namespace granuscope
