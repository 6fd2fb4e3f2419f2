#pragma once
#include "sampling/row_model.h"
#include "sampling/sampler.h"

namespace granuscope {

/// Draws piles of any RowModel, eight side by side. No such pile fails. Its groups hold weights and moments, no forces
/// of contacts.
class RowModelSampler final : public Sampler {
 public:
  RowModelSampler(const SamplerSpec& spec, const Lattice& lattice);

  /// Throws InputError: a Pile holds contacts of beads, which these models have none of.
  std::optional<SamplingFailure> draw(std::uint64_t sample, std::span<const double> load, Pile& pile) override;
  std::span<const PileGroup> draw_groups(std::span<const std::uint64_t> samples,
                                         std::span<const std::span<const double>> loads,
                                         std::span<std::optional<SamplingFailure>> failures) override;
  void keep_layers(const KeptLayers& kept) override;

  /// Of eight piles that keep these layers, or all of them, in bytes.
  static double memory(const Lattice& lattice, const KeptLayers* kept = nullptr);

 private:
  /// What a group's piles are measured by.
  struct Kept {
    AlignedArray<double> weights, horizontal;
    std::vector<LayerMoments> moments;
    std::vector<double> extras;
    std::array<IdentityResiduals, group_lanes> residuals{};
  };
  Kept& room(std::size_t group);
  void draw_group(const LaneSamples& samples, std::span<const std::span<const double>> loads, Kept& kept);
  void keep_row(int layer, const RowSums& sums, const std::array<double, group_lanes>& total, Kept& kept) const;

  SamplerSpec spec_;
  std::unique_ptr<RowModel> model_;
  std::vector<int> layers_;  ///< kept, ascending
  std::vector<int> place_;   ///< of each layer among them, -1: none
  bool horizontal_ = false;
  AlignedArray<double> load_;
  std::deque<Kept> kept_;  ///< of the groups of the last call
};

}  // namespace granuscope
