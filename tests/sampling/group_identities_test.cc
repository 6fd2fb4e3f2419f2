// Source: the identities of model/audit.h, broken by hand in one pile of a group at a time.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "kit/instruction_sets.h"
#include "sampling/pile_group.h"
#include "sampling/sampler.h"

namespace granuscope {
namespace {

/// Piles side by side whose forces may be changed.
class Forces {
 public:
  explicit Forces(const PileGroup& group)
      : group_(group), loads_(group.loads.begin(), group.loads.end()), size_(group.lattice.beads() * group.stride) {
    for (const double* from : {group.V_R, group.V_L, group.H_R, group.H_L}) arrays_.emplace_back(from, from + size_);
  }
  std::size_t at(int layer, int bead, std::size_t pile) const {
    return group_.lattice.index(layer, bead) * group_.stride + pile;
  }
  std::vector<double>& of(std::size_t array) { return arrays_[array]; }
  /// Of all layers, handed over `together` at a time; with the forces that enter beads instead of H_L or without.
  std::array<IdentityResiduals, group_lanes> residuals(bool totals) const {
    std::vector<double> H(size_);
    for (std::size_t i = 0; i < size_; ++i) H[i] = arrays_[2][i] + arrays_[3][i];
    GroupIdentities identities;
    identities.begin(group_.lattice, group_.stride, loads_, group_.bead_weight);
    const auto row = [&](int layer) {
      const std::size_t from = at(std::max(layer, 0), 0, 0);
      return ForceRow{&arrays_[0][from], &arrays_[1][from], &arrays_[2][from], totals ? &H[from] : &arrays_[3][from],
                      totals};
    };
    for (int layer = 0; layer < group_.lattice.layers(); ++layer) {
      identities.add_layer(row(layer), row(layer - 1), row(layer - 2));
    }
    return identities.residuals();
  }

 private:
  PileGroup group_;
  std::vector<std::span<const double>> loads_;
  std::size_t size_;
  std::vector<std::vector<double>> arrays_;
};

/// Eight piles side by side, and one by itself.
struct Drawn {
  explicit Drawn(int columns) : load(static_cast<std::size_t>(columns), 1.0), loads(8, load) {
    const Lattice lattice({columns, 20});
    SamplerSpec spec;
    spec.mu = 0.4;
    const std::vector<std::uint64_t> samples = {0, 1, 2, 3, 4, 5, 6, 7};
    for (const std::size_t count : {8U, 1U}) {
      samplers.push_back(make_sampler(spec, lattice));
      groups.push_back(samplers.back()
                           ->draw_groups(std::span(samples).first(count), std::span(loads).first(count),
                                         std::span(failures).first(count))
                           .front());
    }
  }
  std::vector<double> load;
  std::vector<std::span<const double>> loads;
  std::vector<std::optional<SamplingFailure>> failures = std::vector<std::optional<SamplingFailure>>(8);
  std::vector<std::unique_ptr<Sampler>> samplers;
  std::vector<PileGroup> groups;
};

TEST_CASE("a broken pile is seen wherever it stands in a group, and the others are not blamed") {
  for_each_instruction_set([] {
    for (const int columns : {4, 9, 64}) {
      const Drawn drawn(columns);
      for (const PileGroup& group : drawn.groups) {
        for (const bool totals : {false, true}) {
          if (totals && group.stride == 1) continue;  // single piles know H_L
          CAPTURE(columns, group.stride, totals);
          for (const IdentityResiduals& whole : Forces(group).residuals(totals)) {
            CHECK(whole.weight_sum < 1e-14);
            CHECK(whole.wave_equation < 1e-14);
          }
          for (std::size_t pile = 0; pile < group.piles; ++pile) {
            for (const int layer : {0, 1, 2, 11, 19}) {
              const int bead = layer % columns, next = (layer + 1) % columns;
              CAPTURE(pile, layer);
              const auto expect_only = [&](const Forces& forces, auto broken) {
                const auto found = forces.residuals(totals);
                for (std::size_t k = 0; k < group.piles; ++k) CHECK(broken(found[k]) == (k == pile));
              };
              Forces heavier(group);
              heavier.of(0)[heavier.at(layer, bead, pile)] += 1e-9;
              expect_only(heavier, [](const IdentityResiduals& r) { return r.weight_sum > 1e-11; });
              // Weight that moves to a neighbour leaves the sum as it is; the layers below see it.
              Forces moved(group);
              moved.of(1)[moved.at(layer, bead, pile)] += 1e-6;
              moved.of(1)[moved.at(layer, next, pile)] -= 1e-6;
              if (layer > 1) expect_only(moved, [](const IdentityResiduals& r) { return r.wave_equation > 1e-8; });
              for (const std::size_t array : {0U, 1U, 2U}) {
                for (const double bad :
                     {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
                  Forces ruined(group);
                  ruined.of(array)[ruined.at(layer, bead, pile)] = bad;
                  expect_only(ruined, [](const IdentityResiduals& r) {
                    return !(std::isfinite(r.weight_sum) && std::isfinite(r.wave_equation));
                  });
                }
              }
            }
          }
        }
      }
    }
  });
}

TEST_CASE("a group with a broken pile is refused, unless that pile has failed anyway") {
  Drawn drawn(8);
  PileGroup& group = drawn.groups.front();
  std::vector<IdentityResiduals> residuals(8);
  group.residuals = residuals;
  CHECK_NOTHROW(assert_identities(group, drawn.failures));
  for (const bool sum : {false, true}) {
    for (std::size_t k = 0; k < 8; ++k) {
      residuals.assign(8, {});
      (sum ? residuals[k].weight_sum : residuals[k].wave_equation) = 1e-9;
      CHECK_THROWS_AS(assert_identities(group, drawn.failures), std::logic_error);
      drawn.failures[k] = SamplingFailure{3};
      CHECK_NOTHROW(assert_identities(group, drawn.failures));
      drawn.failures[k].reset();
    }
  }
  // Found where they were not yet.
  group.residuals = {};
  CHECK_NOTHROW(assert_identities(group, drawn.failures));
  std::vector<double> V_R(group.V_R, group.V_R + group.lattice.beads() * group_lanes);
  V_R[group.row(7) + 5] *= 1 + 1e-8;
  group.V_R = V_R.data();
  CHECK_THROWS_AS(assert_identities(group, drawn.failures), std::logic_error);
}

}  // namespace
}  // namespace granuscope
