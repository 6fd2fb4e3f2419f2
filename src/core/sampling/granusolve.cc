#include "sampling/granusolve.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <functional>
#include <numeric>
#include <utility>

#include "sampling/layer_kernels.h"
#include "support/progress.h"

namespace granuscope {

GranusolveArrays GranusolveMemory::arrays(Pile& pile) {
  const std::size_t beads = pile.lattice.beads(), columns = static_cast<std::size_t>(pile.lattice.columns());
  H_.resize(beads);
  first_uniform_.resize(columns + uniform_padding);
  failing_.resize((columns + 63) / 64);
  attempts_.resize(beads);
  unsolved_.resize(beads);
  rule_.resize(beads);
  backtracks_.resize(beads);
  return {.V_R = pile.V_R.data(),
          .V_L = pile.V_L.data(),
          .H_R = pile.H_R.data(),
          .H_L = pile.H_L.data(),
          .H = H_.data(),
          .attempts = attempts_.data(),
          .unsolved = unsolved_.data(),
          .rule = rule_.data(),
          .backtracks = backtracks_.data(),
          .first_uniform = first_uniform_.data(),
          .failing = failing_.data()};
}

std::array<std::uint64_t, granusolve_rules> GranusolveMemory::beads_by() const {
  std::array<std::uint64_t, granusolve_rules> beads_by{};
  for (std::size_t bead = 0; bead < rule_.size(); ++bead) {
    ++beads_by[backtracks_[bead] != 0 ? static_cast<std::size_t>(GranusolveRule::backtrack) : rule_[bead]];
  }
  return beads_by;
}

GranusolveSampler::GranusolveSampler(const SamplerSpec& spec, const Lattice& lattice)
    : Sampler(lattice), spec_(spec), solver_(spec, lattice) {}

GranusolveSampler::~GranusolveSampler() = default;

std::optional<SamplingFailure> GranusolveSampler::draw(std::uint64_t sample, std::span<const double> load, Pile& pile) {
  return solve_pile(sample, load, nullptr, pile);
}

std::optional<SamplingFailure> GranusolveSampler::draw_again(std::uint64_t sample, std::span<const double> load,
                                                             const Pile& first, Pile& pile) {
  return solve_pile(sample, load, &first, pile);
}

std::optional<SamplingFailure> GranusolveSampler::solve_pile(std::uint64_t sample, std::span<const double> load,
                                                             const Pile* first, Pile& pile) {
  begin_pile(spec_, Law::granusolve, sample, load, pile);
  solver_.use(memory_.arrays(pile));
  solver_.begin_pile(sample, load, first);
  SolveResult result = SolveResult::solved;
  int layer = 0;
  for (; layer < lattice_.layers() && result == SolveResult::solved; ++layer) {
    throw_if_interrupted();
    result = solver_.solve_layer(layer);
  }
  if (result == SolveResult::solved) solver_.count_pile(memory_.beads_by());
  counts_ += solver_.take_counts();
  if (result != SolveResult::solved) return SamplingFailure{layer - 1};
  return std::nullopt;
}

Pile& GranusolveSampler::spare_pile() {
  if (!spare_pile_) spare_pile_.emplace(lattice_);
  return *spare_pile_;
}

void GranusolveSampler::keep_layers(const KeptLayers& kept) {
  kept_layers_ = kept;
  groups_.clear();
  together_.clear();
}

std::span<const PileGroup> GranusolveSampler::draw_groups(std::span<const std::uint64_t> samples,
                                                          std::span<const std::span<const double>> loads,
                                                          std::span<std::optional<SamplingFailure>> failures) {
  groups_.clear();
  drawn_alone_ = 0;
  // Only eight samples from a multiple of eight on share the order of their layers, or the same sample under several
  // loads; a part of them is drawn with empty lanes, a single one by itself.
  struct Part {
    std::size_t begin, count;
    GranusolveGroup* together;
  };
  const KeptLayers* const kept = kept_layers_ ? &*kept_layers_ : nullptr;
  std::vector<Part> parts;
  std::vector<GranusolveGroup*> together;
  for (std::size_t done = 0; done < loads.size(); done += parts.back().count) {
    const std::uint64_t sample = samples[done];
    std::size_t count = 1;
    const bool same = done + 1 < samples.size() && samples[done + 1] == sample;
    while (done + count < samples.size() && samples[done + count] == (same ? sample : sample + count) &&
           (same ? count < group_lanes : (sample + count) % group_lanes != 0)) {
      ++count;
    }
    parts.push_back({done, count, nullptr});
    if (count < 2 || !drawn_side_by_side(spec_) || !GranusolveGroup::fits(lattice_, kept)) continue;
    if (together.size() == together_.size()) {
      together_.push_back(std::make_unique<GranusolveGroup>(spec_, lattice_, kept_layers_, *this));
    }
    parts.back().together = together_[together.size()].get();
    parts.back().together->prepare(sample, same, loads.subspan(done, count), failures.subspan(done, count));
    together.push_back(parts.back().together);
  }
  for (std::size_t g = 0; g < together.size(); g += 2) {
    if (g + 1 < together.size()) {
      GranusolveGroup::draw(*together[g], *together[g + 1]);
    } else {
      together[g]->draw();
    }
  }
  for (const Part& part : parts) {
    if (part.together != nullptr) {
      groups_.push_back(part.together->piles());
      counts_ += part.together->take_counts();
    } else {
      for (std::size_t k = part.begin; k < part.begin + part.count; ++k) {
        draw_alone(samples[k], loads[k], failures[k]);
      }
    }
  }
  return groups_;
}

namespace {

/// The most memory that eight piles side by side may take; beyond it they are drawn one by one.
constexpr double most_memory = 2e9;  // bytes
/// Of one pile: the weight (or horizontal force) of a kept bead; forces, H, attempts, state and rule of one in the
/// window; what its solver holds for each column and each layer.
constexpr double bytes_kept = 8, bytes_in_window = 39, bytes_of_column = 112, bytes_of_layer = 48;
/// Layers of the window, a power of two. A backtrack of 29 layers takes 27 backtracks of one bead before it.
constexpr int window = 32;

/// Words of padding before the first bead's bits.
constexpr std::size_t words_before = row_padding / sizeof(std::uint64_t);

static_assert(std::endian::native == std::endian::little, "a word of failing beads is read byte by byte");

}  // namespace

bool GranusolveGroup::fits(const Lattice& lattice, const KeptLayers* kept) {
  return memory(lattice, kept) <= most_memory;
}

double GranusolveGroup::memory(const Lattice& lattice, const KeptLayers* kept) {
  const double rows = kept == nullptr ? lattice.layers()
                                      : static_cast<double>(kept->layers.size()) * (kept->forces       ? 4
                                                                                    : kept->horizontal ? 2
                                                                                                       : 1);
  return static_cast<double>(group_lanes) *
         ((bytes_kept * rows + bytes_in_window * window + bytes_of_column) * static_cast<double>(lattice.columns()) +
          bytes_of_layer * static_cast<double>(lattice.layers()));
}

GranusolveGroup::GranusolveGroup(const SamplerSpec& spec, const Lattice& lattice, const std::optional<KeptLayers>& kept,
                                 GranusolveSampler& alone)
    : alone_(alone),
      keeps_forces_(!kept || kept->forces),
      kept_(static_cast<std::size_t>(lattice.layers()), -1),
      cone_(spec.mu, lattice.geometry()),
      spec_(spec),
      lattice_(lattice) {
  const std::size_t layer = static_cast<std::size_t>(lattice.columns()) * group_lanes, all = window * layer;
  for (AlignedArray<double>* forces : {&V_R_, &V_L_, &H_, &H_R_}) {
    *forces = aligned_array<double>(all);
    std::fill_n(forces->get(), all, 0.0);  // lanes without a pile are computed with, too
  }
  attempts_ = aligned_array<std::uint32_t>(all);
  unsolved_ = aligned_array<std::uint8_t>(all);
  rule_ = aligned_array<std::uint8_t>(all);
  backtracks_ = aligned_array<std::uint8_t>(all);
  if (kept) {
    const std::vector<int>& layers = kept->layers;
    for (std::size_t l = 0; l < layers.size(); ++l) kept_[static_cast<std::size_t>(layers[l])] = static_cast<int>(l);
    if (!keeps_forces_) kept_weights_ = aligned_array<double>(layers.size() * layer);
    if (!keeps_forces_ && kept->horizontal) kept_H_ = aligned_array<double>(layers.size() * layer);
  } else {
    std::iota(kept_.begin(), kept_.end(), 0);
  }
  moments_.resize(kept ? kept->layers.size() : kept_.size());
  if (keeps_forces_) {
    for (AlignedArray<double>* forces : {&kept_V_R_, &kept_V_L_, &kept_H_R_, &kept_H_L_}) {
      *forces = aligned_array<double>(moments_.size() * layer);
    }
  }
  first_uniform_ = aligned_array<double>(layer + group_lanes);
  half_load_ = aligned_array<double>(layer);
  const std::size_t words = (static_cast<std::size_t>(lattice.columns()) + 7) / 8 + 2 * words_before;
  for (AlignedArray<std::uint64_t>* bits : {&failing_, &changed_}) {
    *bits = aligned_array<std::uint64_t>(words);
    std::fill_n(bits->get(), words, 0);
  }
  for (std::size_t k = 0; k < group_lanes; ++k) {
    solvers_[k] = std::make_unique<GranusolveSolver>(spec, lattice);
    solvers_[k]->use({.V_R = V_R_.get() + k,
                      .V_L = V_L_.get() + k,
                      .H_R = H_R_.get() + k,
                      .H = H_.get() + k,
                      .attempts = attempts_.get() + k,
                      .unsolved = unsolved_.get() + k,
                      .rule = rule_.get() + k,
                      .backtracks = backtracks_.get() + k,
                      .first_uniform = first_uniform_.get() + k,
                      .failing = failing_.get() + words_before,
                      .changed = changed_.get() + words_before,
                      .stride = group_lanes,
                      .lane = k,
                      .window = window});
  }
}

GroupRow GranusolveGroup::row(int layer) const {
  const std::size_t at = lattice_.index(layer % window, 0) * group_lanes;
  return {V_R_.get() + at, V_L_.get() + at, H_.get() + at, H_R_.get() + at};
}

void GranusolveGroup::prepare(std::uint64_t first_sample, bool same_sample,
                              std::span<const std::span<const double>> loads,
                              std::span<std::optional<SamplingFailure>> failures) {
  const auto columns = static_cast<std::size_t>(lattice_.columns());
  front_.times = PhaseTimes::current();
  if (front_.times != nullptr) front_.times->begin();
  finished_ = 0;
  evicted_ = 0;
  beads_by_ = {};
  identities_.begin(lattice_, group_lanes, loads, spec_.bead_weight);
  loads_ = loads;
  failures_ = failures;
  std::fill(failures.begin(), failures.end(), std::nullopt);
  front_.running = (1U << loads.size()) - 1;
  front_.keys = PhiloxKeys(spec_.seed);
  front_.half_weight = spec_.bead_weight / 2;
  front_.columns = lattice_.columns();
  front_.repair_rule = static_cast<std::uint8_t>(GranusolveRule::pair);
  front_.first_uniform = first_uniform_.get();
  front_.failing = reinterpret_cast<std::uint8_t*>(failing_.get() + words_before);
  front_.changed = reinterpret_cast<std::uint8_t*>(changed_.get() + words_before);
  for (std::size_t k = 0; k < group_lanes; ++k) {
    front_.sample[k] = static_cast<std::uint32_t>(same_sample ? first_sample : first_sample + k);
    front_.pairs[k] = 0;
    const bool used = k < loads.size();
    solvers_[k]->take_counts();
    if (used) solvers_[k]->begin_pile(front_.sample[k], loads[k]);
    for (std::size_t i = 0; i < columns; ++i) half_load_[i * group_lanes + k] = used ? loads[k][i] / 2 : 0.5;
  }
}

void GranusolveGroup::draw() {
  for (int layer = 0; layer < lattice_.layers() && front_.running != 0; ++layer) {
    begin_layer(layer);
    solve_rest_of_layer();
    end_layer();
  }
  finish();
}

void GranusolveGroup::draw(GranusolveGroup& a, GranusolveGroup& b) {
  for (int layer = 0; layer < a.lattice_.layers() && (a.front_.running | b.front_.running) != 0; ++layer) {
    a.begin_layer(layer);
    b.begin_layer(layer);
    while (!a.layer_is_solved() && !b.layer_is_solved()) {
      repair_along(a.cone_, a.front_, b.front_);
      a.solve_singly();
      b.solve_singly();
    }
    a.solve_rest_of_layer();
    b.solve_rest_of_layer();
    a.end_layer();
    b.end_layer();
  }
  a.finish();
  b.finish();
}

void GranusolveGroup::solve_rest_of_layer() {
  while (!layer_is_solved()) {
    repair_along(cone_, front_);
    solve_singly();
  }
}

PileGroup GranusolveGroup::piles() const {
  return {.lattice = lattice_,
          .stride = group_lanes,
          .piles = loads_.size(),
          .V_R = kept_V_R_.get(),
          .V_L = kept_V_L_.get(),
          .H_R = kept_H_R_.get(),
          .H_L = kept_H_L_.get(),
          .weights = kept_weights_.get(),
          .horizontal = kept_H_.get(),
          .moments = moments_,
          .kept = kept_,
          .loads = loads_,
          .load_line = load_line(spec_),
          .bead_weight = spec_.bead_weight,
          .residuals = {residuals_.data(), loads_.size()},
          .mu = spec_.mu,
          .law = name_of(Law::granusolve),
          .seed = spec_.seed,
          .first_sample = front_.sample[0],
          .sample_step = loads_.size() > 1 ? front_.sample[1] - front_.sample[0] : 1U};
}

SamplerCounts GranusolveGroup::take_counts() {
  SamplerCounts sum;
  for (std::size_t k = 0; k < loads_.size(); ++k) sum += solvers_[k]->take_counts();
  return sum;
}

void GranusolveGroup::draw_layer_in_bulk() {
  const auto columns = static_cast<std::size_t>(lattice_.columns());
  std::memset(front_.changed, 0, columns);
  draw_layer(cone_, {half_load_.get(), load_line(spec_)}, front_);
  for (unsigned rest = front_.running; rest != 0; rest &= rest - 1) {
    solvers_[static_cast<std::size_t>(std::countr_zero(rest))]->count_bulk_draw();
  }
}

/// The solver of one pile takes over what was counted for it.
void GranusolveGroup::hand_over_counts(std::size_t lane) {
  solvers_[lane]->count_pairs(std::exchange(front_.pairs[lane], 0));
}

void GranusolveGroup::begin_layer(int layer) {
  throw_if_interrupted();
  // The layer that stood in this one's place leaves the window; the next two go on serving its identities.
  if (layer >= window - 2) finish_layer(layer - window + 2);
  lap(Phase::finishing);
  const std::size_t columns = static_cast<std::size_t>(lattice_.columns());
  const std::size_t here = lattice_.index(layer % window, 0) * group_lanes;
  std::memset(attempts_.get() + here, 0, columns * group_lanes * sizeof attempts_[0]);
  std::memset(unsolved_.get() + here, 0, columns * group_lanes);
  std::memset(backtracks_.get() + here, 0, columns * group_lanes);
  std::memset(rule_.get() + here, static_cast<int>(GranusolveRule::first_draw), columns * group_lanes);
  const RandomKey::Order order = solvers_[0]->order(layer);
  front_.layer = layer;
  front_.forward = order.direction > 0;
  front_.here = row(layer);
  if (layer > 0) front_.above = row(layer - 1);
  front_.attempts = attempts_.get() + here;
  front_.rule = rule_.get() + here;
  front_.position = 0;
  front_.bead = order.first_bead;
  draw_layer_in_bulk();
  lap(Phase::first_draws);
}

/// What the pair rule has left over, pile by pile, whatever it takes; then goes on to the next bead.
void GranusolveGroup::solve_singly() {
  if (front_.to_solve_singly == 0) return;
  for (; front_.to_solve_singly != 0; front_.to_solve_singly &= front_.to_solve_singly - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(front_.to_solve_singly));
    hand_over_counts(lane);
    const bool no_pair = (front_.no_pair >> lane & 1) != 0;
    note(lane, solvers_[lane]->solve_at(front_.layer, front_.position, front_.bead, no_pair));
  }
  front_.step();
  lap(Phase::one_by_one);
}

/// A pile that is not solved is given up.
void GranusolveGroup::note(std::size_t lane, SolveResult result) {
  if (result == SolveResult::solved) return;
  front_.running &= ~(1U << lane);
  if (result == SolveResult::beyond_window) {
    evicted_ |= 1U << lane;
  } else {
    failures_[lane] = SamplingFailure{front_.layer};
  }
}

void GranusolveGroup::end_layer() {
  for (unsigned rest = front_.running; rest != 0; rest &= rest - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(rest));
    hand_over_counts(lane);
    note(lane, solvers_[lane]->end_layer(front_.layer));
  }
}

/// Those in the window; of the top layer if there is none so high.
ForceRow GranusolveGroup::forces(int layer) const {
  const GroupRow from = row(std::max(layer, 0));
  return {from.V_R, from.V_L, from.H_R, from.H, true};
}

/// Nothing in the layer changes any more: its identities, its rules, and what is kept of it.
void GranusolveGroup::finish_layer(int layer) {
  identities_.add_layer(forces(layer), forces(layer - 1), forces(layer - 2));
  const std::size_t columns = static_cast<std::size_t>(lattice_.columns());
  static_assert(granusolve_rules == last_rule + 1);
  static_assert(static_cast<std::uint8_t>(GranusolveRule::backtrack) == last_rule);
  const std::size_t in_window = lattice_.index(layer % window, 0) * group_lanes;
  count_rules(rule_.get() + in_window, backtracks_.get() + in_window, columns, beads_by_);
  finished_ = layer + 1;
  const int place = kept_[static_cast<std::size_t>(layer)];
  if (place < 0) return;
  const std::size_t size = columns * group_lanes, to = static_cast<std::size_t>(place) * size;
  const ForceRow from = forces(layer);
  moments_[static_cast<std::size_t>(place)] = measure_row(
      from, columns, group_lanes, mean_weight(spec_.bead_weight, layer), keeps_forces_ ? nullptr : &kept_weights_[to]);
  if (kept_H_ != nullptr) {
    // Rounded as it is where H_L is kept by itself.
    for (std::size_t i = 0; i < size; ++i) kept_H_[to + i] = from.H_R[i] + (from.H_L[i] - from.H_R[i]);
  }
  if (!keeps_forces_) return;
  std::copy_n(from.V_R, size, kept_V_R_.get() + to);
  std::copy_n(from.V_L, size, kept_V_L_.get() + to);
  std::copy_n(from.H_R, size, kept_H_R_.get() + to);
  std::transform(from.H_L, from.H_L + size, from.H_R, kept_H_L_.get() + to, std::minus<>());
}

/// What is left when all layers have been drawn.
void GranusolveGroup::finish() {
  if ((front_.running | evicted_) == 0) return;
  if (front_.running != 0) {
    for (int layer = finished_; layer < lattice_.layers(); ++layer) finish_layer(layer);
  }
  residuals_ = identities_.residuals();
  for (unsigned rest = front_.running; rest != 0; rest &= rest - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(rest));
    solvers_[lane]->count_pile(beads_by_[lane]);
  }
  lap(Phase::finishing);
  draw_evicted_piles();
  lap(Phase::one_by_one);
}

void GranusolveGroup::draw_evicted_piles() {
  if (evicted_ == 0) return;
  Pile& pile = alone_.spare_pile();
  for (unsigned rest = evicted_; rest != 0; rest &= rest - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(rest));
    solvers_[lane]->take_counts();
    failures_[lane] = alone_.draw(front_.sample[lane], loads_[lane], pile);
    if (failures_[lane]) continue;
    residuals_[lane] = identity_residuals(pile);
    for (int layer = 0; layer < lattice_.layers(); ++layer) keep_evicted_layer(pile, layer, lane);
  }
}

void GranusolveGroup::keep_evicted_layer(const Pile& pile, int layer, std::size_t lane) {
  const int place = kept_[static_cast<std::size_t>(layer)];
  if (place < 0) return;
  const std::size_t columns = static_cast<std::size_t>(lattice_.columns()), from = lattice_.index(layer, 0);
  const std::size_t to = static_cast<std::size_t>(place) * columns * group_lanes + lane;
  std::vector<double> weights(columns);
  const LayerMoments moments = measure_row({&pile.V_R[from], &pile.V_L[from], &pile.H_R[from], &pile.H_L[from]},
                                           columns, 1, mean_weight(spec_.bead_weight, layer), weights.data());
  moments_[static_cast<std::size_t>(place)].thrust[lane] = moments.thrust[0];
  moments_[static_cast<std::size_t>(place)].variance[lane] = moments.variance[0];
  const auto keep = [&](const double* row, AlignedArray<double>& kept) {
    for (std::size_t i = 0; i < columns; ++i) kept[to + i * group_lanes] = row[i];
  };
  if (!keeps_forces_) {
    keep(weights.data(), kept_weights_);
    if (kept_H_ == nullptr) return;
    std::vector<double> horizontal(columns);
    for (std::size_t i = 0; i < columns; ++i) horizontal[i] = pile.H_R[from + i] + pile.H_L[from + i];
    return keep(horizontal.data(), kept_H_);
  }
  keep(&pile.V_R[from], kept_V_R_);
  keep(&pile.V_L[from], kept_V_L_);
  keep(&pile.H_R[from], kept_H_R_);
  keep(&pile.H_L[from], kept_H_L_);
}

}  // namespace granuscope
