#include "sampling/sampler.h"

#include <fmt/format.h>
#include <cmath>

#include "sampling/frictionless.h"
#include "sampling/granusolve.h"
#include "sampling/random_key.h"
#include "sampling/rejection.h"
#include "support/error.h"

namespace granuscope {
namespace {

/// Solutions per bead beyond which an effort is no bound any more (nor countable in 64 bits for the largest piles).
constexpr double max_effort = 1e9;

/// Every law at mu = 0, where the only solution is the frictionless pile.
class FrictionlessSampler final : public Sampler {
 public:
  explicit FrictionlessSampler(const SamplerSpec& spec) : spec_(spec) {}
  std::optional<SamplingFailure> draw(std::uint64_t sample, std::span<const double> load, Pile& pile) override {
    fill_frictionless(load, pile);
    pile.mu = 0;
    pile.law = name_of(spec_.law);
    pile.seed = spec_.seed;
    pile.sample = sample;
    ++counts_.tries;
    counts_.beads += pile.lattice.beads();
    return std::nullopt;
  }

 private:
  SamplerSpec spec_;
};

/// Guards the contract of draw() once, for every law.
class CheckedSampler final : public Sampler {
 public:
  CheckedSampler(std::unique_ptr<Sampler> inner, const Lattice& lattice)
      : inner_(std::move(inner)), lattice_(lattice) {}
  std::optional<SamplingFailure> draw(std::uint64_t sample, std::span<const double> load, Pile& pile) override {
    check(sample, load, pile);
    auto failure = inner_->draw(sample, load, pile);
    counts_ = inner_->counts();
    return failure;
  }
  std::optional<SamplingFailure> draw_again(std::uint64_t sample, std::span<const double> load, const Pile& first,
                                            Pile& pile) override {
    check(sample, load, pile);
    if (&first == &pile || first.H_R.size() != lattice_.beads()) {
      throw std::logic_error("a sampler was handed a first pile of another lattice, or one and the same pile twice");
    }
    auto failure = inner_->draw_again(sample, load, first, pile);
    counts_ = inner_->counts();
    return failure;
  }

 private:
  void check(std::uint64_t sample, std::span<const double> load, const Pile& pile) const {
    if (sample >= max_samples) {
      throw InputError(
          fmt::format("sample {} is out of range: one seed names {} samples; use another seed", sample, max_samples));
    }
    if (load.size() != static_cast<std::size_t>(lattice_.columns()) || pile.V_R.size() != lattice_.beads()) {
      throw std::logic_error("a sampler was handed a load or a pile of another lattice");
    }
    for (std::size_t i = 0; i < load.size(); ++i) {
      if (!(load[i] > 0) || !std::isfinite(load[i])) {
        throw InputError(
            fmt::format("the load {} on top bead {} is not a positive finite number: a bead without load has "
                        "no solution beside loaded ones at small friction; load every top bead",
                        load[i], i));
      }
    }
  }

  std::unique_ptr<Sampler> inner_;
  Lattice lattice_;
};

}  // namespace

std::string name_of(Law law) { return law == Law::granusolve ? "granusolve" : "rejection"; }

Law law_named(const std::string& name) {
  for (Law law : {Law::granusolve, Law::rejection}) {
    if (name_of(law) == name) return law;
  }
  throw InputError(fmt::format("there is no law \"{}\": known are granusolve and rejection", name));
}

std::string name_of(LayerOrder order) { return order == LayerOrder::random ? "random" : "fixed"; }

LayerOrder layer_order_named(const std::string& name) {
  for (LayerOrder order : {LayerOrder::random, LayerOrder::fixed}) {
    if (name_of(order) == name) return order;
  }
  throw InputError(fmt::format("there is no layer order \"{}\": write \"random\" or \"fixed\"", name));
}

std::unique_ptr<Sampler> make_sampler(const SamplerSpec& spec, const Lattice& lattice) {
  if (!(spec.effort >= 1 && spec.effort <= max_effort)) {
    throw InputError(fmt::format(
        "effort {} is out of range: a pile needs at least one solution per bead, and more than {:g} would never end",
        spec.effort, max_effort));
  }
  if (spec.max_tries < 1 || spec.max_tries > most_tries) {
    throw InputError(fmt::format("max_tries {} is out of range: use 1 to {}", spec.max_tries, most_tries));
  }
  const FrictionCone cone(spec.mu);
  std::unique_ptr<Sampler> sampler;
  if (cone.mu() == 0) {
    sampler = std::make_unique<FrictionlessSampler>(spec);
  } else if (spec.law == Law::granusolve) {
    sampler = std::make_unique<GranusolveSampler>(spec, lattice);
  } else {
    sampler = std::make_unique<RejectionSampler>(spec, lattice);
  }
  return std::make_unique<CheckedSampler>(std::move(sampler), lattice);
}

}  // namespace granuscope
