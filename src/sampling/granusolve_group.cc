#include "sampling/granusolve_group.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "sampling/layer_kernels.h"

namespace granuscope {

namespace {

/// The most memory that eight piles side by side may take; beyond it they are drawn one by one.
constexpr double most_memory = 2e9;  // bytes
/// Forces, H, attempts, state and rule of a bead of one pile.
constexpr double bytes_per_bead = 46;

static_assert(std::endian::native == std::endian::little, "a word of failing beads is read byte by byte");

}  // namespace

GranusolveSampler::~GranusolveSampler() = default;

void GranusolveSampler::draw_group(std::uint64_t first_sample, std::span<const std::span<const double>> loads,
                                   std::span<Pile> piles, std::span<std::optional<SamplingFailure>> failures) {
  // Only whole groups share the order of their layers; a part of one is drawn with empty lanes.
  std::size_t done = 0;
  while (done < piles.size()) {
    const std::uint64_t sample = first_sample + done;
    const std::size_t count = std::min<std::size_t>(piles.size() - done, group_lanes - sample % group_lanes);
    if (count < 2 || !GranusolveGroup::fits(lattice_)) {
      for (std::size_t k = done; k < done + count; ++k) failures[k] = draw(first_sample + k, loads[k], piles[k]);
    } else {
      if (!group_) group_ = std::make_unique<GranusolveGroup>(spec_, lattice_);
      group_->draw(sample, loads.subspan(done, count), piles.subspan(done, count), failures.subspan(done, count),
                   counts_);
    }
    done += count;
  }
}

bool GranusolveGroup::fits(const Lattice& lattice) {
  return bytes_per_bead * static_cast<double>(group_lanes * lattice.beads()) <= most_memory;
}

GranusolveGroup::GranusolveGroup(const SamplerSpec& spec, const Lattice& lattice)
    : spec_(spec), lattice_(lattice), cone_(spec.mu) {
  const std::size_t all = lattice.beads() * group_lanes;
  const std::size_t layer = static_cast<std::size_t>(lattice.columns()) * group_lanes;
  for (Array<double>* forces : {&V_R_, &V_L_, &H_, &H_R_, &H_L_}) {
    *forces = hwy::AllocateAligned<double>(all);
    std::fill_n(forces->get(), all, 0.0);  // lanes without a pile are computed with, too
  }
  attempts_ = hwy::AllocateAligned<std::uint32_t>(all);
  unsolved_ = hwy::AllocateAligned<std::uint8_t>(all);
  rule_ = hwy::AllocateAligned<std::uint8_t>(all);
  first_uniform_ = hwy::AllocateAligned<double>(layer + group_lanes);
  slack_ = hwy::AllocateAligned<double>(layer);
  half_load_ = hwy::AllocateAligned<double>(layer);
  no_force_ = hwy::AllocateAligned<double>(layer);
  std::fill_n(no_force_.get(), layer, 0.0);
  failing_ = hwy::AllocateAligned<std::uint64_t>((layer + 63) / 64);
  for (std::size_t k = 0; k < group_lanes; ++k) {
    solvers_[k] = std::make_unique<GranusolveSampler>(spec, lattice);
    solvers_[k]->state_ = {V_R_.get() + k,      V_L_.get() + k,  H_R_.get() + k,
                           H_L_.get() + k,      H_.get() + k,    attempts_.get() + k,
                           unsolved_.get() + k, rule_.get() + k, first_uniform_.get() + k,
                           failing_.get(),      group_lanes,     k};
  }
}

GroupRow GranusolveGroup::row(int layer) const {
  const std::size_t at = lattice_.index(layer, 0) * group_lanes;
  return {V_R_.get() + at, V_L_.get() + at, H_.get() + at, H_R_.get() + at, H_L_.get() + at};
}

void GranusolveGroup::draw(std::uint64_t first_sample, std::span<const std::span<const double>> loads,
                           std::span<Pile> piles, std::span<std::optional<SamplingFailure>> failures,
                           SamplerCounts& counts) {
  begin(first_sample, loads, piles);
  for (auto& failure : failures) failure.reset();
  for (int layer = 0; layer < lattice_.layers() && running_ != 0; ++layer) solve_layer(layer, failures);
  count_piles();
  for (std::size_t k = 0; k < piles.size(); ++k) {
    counts += solvers_[k]->counts_;
    solvers_[k]->counts_ = {};
  }
  unpack(piles);
}

void GranusolveGroup::begin(std::uint64_t first_sample, std::span<const std::span<const double>> loads,
                            std::span<Pile> piles) {
  const std::size_t all = lattice_.beads() * group_lanes, columns = static_cast<std::size_t>(lattice_.columns());
  std::memset(attempts_.get(), 0, all * sizeof attempts_[0]);
  std::memset(unsolved_.get(), 0, all);
  std::memset(rule_.get(), static_cast<int>(GranusolveSampler::Rule::first_draw), all);
  running_ = (1U << piles.size()) - 1;
  front_.keys = PhiloxKeys(spec_.seed);
  front_.mended_rule = static_cast<std::uint8_t>(GranusolveSampler::Rule::pair);
  front_.first_uniform = first_uniform_.get();
  front_.failing = reinterpret_cast<std::uint8_t*>(failing_.get());
  for (std::size_t k = 0; k < group_lanes; ++k) {
    front_.sample[k] = static_cast<std::uint32_t>(first_sample + k);
    front_.met[k] = front_.pairs[k] = front_.renewed[k] = 0;
    const bool used = k < piles.size();
    if (used) solvers_[k]->begin_pile(first_sample + k, loads[k], piles[k]);
    for (std::size_t i = 0; i < columns; ++i) half_load_[i * group_lanes + k] = used ? loads[k][i] / 2 : 0.5;
  }
}

void GranusolveGroup::draw_layer_in_bulk(int layer) {
  const auto columns = static_cast<std::size_t>(lattice_.columns());
  fill_group_uniforms(front_.keys, front_.sample, layer, first_uniform_.get(), columns);
  const auto below = [&](std::size_t bead) {
    const std::size_t at = bead * group_lanes;
    return LowerRow{front_.here.V_R + at, front_.here.V_L + at, front_.here.H + at,
                    front_.here.H_R + at, front_.here.H_L + at, slack_.get() + at};
  };
  if (layer == 0) {
    const double* const half = half_load_.get();
    draw_beads(cone_, {half, half, no_force_.get(), no_force_.get()}, first_uniform_.get(), columns * group_lanes,
               below(0));
  } else {
    const GroupRow& up = front_.above;
    const auto above = [&](std::size_t upper_left, std::size_t upper_right) {
      const std::size_t left = upper_left * group_lanes, right = upper_right * group_lanes;
      return UpperRow{up.V_R + left, up.V_L + right, up.H_R + left, up.H_L + right};
    };
    // As in GranusolveSampler: the seam's bead is a run of its own.
    const std::size_t first = layer % 2 == 0 ? 1 : 0, seam = layer % 2 == 0 ? 0 : columns - 1;
    draw_beads(cone_, above(0, 1), first_uniform_.get() + first * group_lanes, (columns - 1) * group_lanes,
               below(first));
    draw_beads(cone_, above(columns - 1, 0), first_uniform_.get() + seam * group_lanes, group_lanes, below(seam));
  }
  find_failing(slack_.get(), columns * group_lanes, failing_.get());
  for (unsigned rest = running_; rest != 0; rest &= rest - 1) {
    GranusolveSampler& solver = *solvers_[static_cast<std::size_t>(std::countr_zero(rest))];
    solver.solutions_ += columns;
    solver.counts_.uniforms += columns;
  }
}

/// The solver of one pile takes over what was counted for it.
void GranusolveGroup::hand_over_counts(std::size_t lane) {
  GranusolveSampler& solver = *solvers_[lane];
  const std::uint64_t met = front_.met[lane], pairs = front_.pairs[lane], renewed = front_.renewed[lane];
  solver.solutions_ += met + pairs + renewed;
  solver.counts_.uniforms += 2 * pairs + renewed;
  solver.counts_.pairs += pairs;
  front_.met[lane] = front_.pairs[lane] = front_.renewed[lane] = 0;
}

void GranusolveGroup::solve_layer(int layer, std::span<std::optional<SamplingFailure>> failures) {
  const int columns = lattice_.columns();
  const std::size_t here = lattice_.index(layer, 0) * group_lanes;
  front_.layer = layer;
  front_.here = row(layer);
  if (layer > 0) front_.above = row(layer - 1);
  front_.attempts = attempts_.get() + here;
  front_.rule = rule_.get() + here;
  draw_layer_in_bulk(layer);

  const auto give_up = [&](std::size_t lane) {
    failures[lane] = SamplingFailure{layer};
    running_ &= ~(1U << lane);
  };
  const RandomKey::Order order = solvers_[0]->order_[static_cast<std::size_t>(layer)];
  int bead = order.first_bead;
  for (int position = 0; position < columns; ++position) {
    unsigned lanes = front_.failing[bead] & running_;
    if (lanes != 0 && layer > 0) {
      const int A = lattice_.upper_left(layer, bead), B = lattice_.upper_right(layer, bead);
      const int left = lattice_.previous(bead), right = lattice_.next(bead);
      const bool forward = order.direction > 0;
      const auto number = [](int index) { return static_cast<std::size_t>(index); };
      // The neighbour behind is solved unless this is the first bead, the one ahead only if this is the last.
      const bool behind_solved = position > 0, ahead_solved = position == columns - 1;
      lanes = mend_beads(
          cone_, front_,
          {number(lattice_.previous(A)), number(A), number(B), number(lattice_.next(B)), number(left), number(bead),
           number(right), forward ? behind_solved : ahead_solved, forward ? ahead_solved : behind_solved},
          lanes);
    }
    for (; lanes != 0; lanes &= lanes - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(lanes));
      // The solver counts from the beginning what mend_beads has begun to count.
      hand_over_counts(lane);
      GranusolveSampler& solver = *solvers_[lane];
      if (layer > 0) --solver.solutions_;
      --solver.counts_.uniforms;
      solver.front_ = layer;
      solver.cursor_ = position;
      solver.cursor_bead_ = bead;
      if (!solver.solve_failing(bead)) {
        solver.counts_.uniforms -= static_cast<std::uint64_t>(columns - 1 - position);  // beads it does not come to
        give_up(lane);
      }
    }
    bead = order.direction > 0 ? lattice_.next(bead) : lattice_.previous(bead);
  }
  for (unsigned rest = running_; rest != 0; rest &= rest - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(rest));
    hand_over_counts(lane);
    if (solvers_[lane]->solutions_ > solvers_[lane]->max_solutions_) give_up(lane);
  }
}

/// What GranusolveSampler::count_pile does, for the completed piles of the group in one pass.
void GranusolveGroup::count_piles() {
  for (unsigned rest = running_; rest != 0; rest &= rest - 1) {
    GranusolveSampler& solver = *solvers_[static_cast<std::size_t>(std::countr_zero(rest))];
    for (const auto& [bead, times] : solver.climbs_) solver.set_rule(bead, GranusolveSampler::Rule::climb);
  }
  constexpr std::size_t rules = GranusolveSampler::rules, most_in_a_byte = 255;
  std::array<std::array<std::uint64_t, rules>, group_lanes> beads_by{};
  const std::size_t beads = lattice_.beads();
  for (std::size_t begin = 0; begin < beads; begin += most_in_a_byte) {
    std::uint8_t some[rules][group_lanes] = {};  // bytes, so that eight piles are counted at once
    const std::size_t end = std::min(beads, begin + most_in_a_byte);
    for (std::size_t bead = begin; bead < end; ++bead) {
      for (std::size_t rule = 1; rule < rules; ++rule) {
        for (std::size_t k = 0; k < group_lanes; ++k) {
          some[rule][k] = static_cast<std::uint8_t>(some[rule][k] + (rule_[bead * group_lanes + k] == rule));
        }
      }
    }
    for (std::size_t rule = 1; rule < rules; ++rule) {
      for (std::size_t k = 0; k < group_lanes; ++k) beads_by[k][rule] += some[rule][k];
    }
  }
  for (unsigned rest = running_; rest != 0; rest &= rest - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(rest));
    solvers_[lane]->add_pile(beads_by[lane]);
  }
}

/// Every pile out of the interleaved arrays, in pieces that stay in the nearest cache.
void GranusolveGroup::unpack(std::span<Pile> piles) const {
  constexpr std::size_t piece = 64;  // beads
  const std::size_t beads = lattice_.beads();
  const auto copy = [&](const Array<double>& from, std::vector<double> Pile::*to) {
    for (std::size_t begin = 0; begin < beads; begin += piece) {
      const std::size_t end = std::min(beads, begin + piece);
      for (std::size_t k = 0; k < piles.size(); ++k) {
        double* const out = (piles[k].*to).data();
        for (std::size_t i = begin; i < end; ++i) out[i] = from[i * group_lanes + k];
      }
    }
  };
  copy(V_R_, &Pile::V_R);
  copy(V_L_, &Pile::V_L);
  copy(H_R_, &Pile::H_R);
  copy(H_L_, &Pile::H_L);
}

}  // namespace granuscope
