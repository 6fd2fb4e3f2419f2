// Source: what the system's allocator says it has handed out.
#include <malloc.h>

#include <catch2/catch.hpp>
#include <numeric>
#include <vector>

#include "kit/sanitized.h"
#include "sampling/sampler.h"

namespace granuscope {
namespace {

/// In bytes.
double handed_out() {
  const struct mallinfo2 now = ::mallinfo2();
  return static_cast<double>(now.uordblks + now.hblkhd);
}

TEST_CASE("drawing takes no more memory than is estimated, and not much less") {
  if (test::sanitized) return;  // its allocator keeps no such account
  for (const double mu : {0.1, 0.3}) {
    for (const LatticeSpec size : {LatticeSpec{64, 800}, {500, 200}}) {
      CAPTURE(mu, size.columns, size.layers);
      const Lattice lattice(size);
      SamplerSpec spec;
      spec.mu = mu;
      spec.effort = 1000;
      const std::size_t piles = piles_at_once(spec, lattice);
      std::vector<std::vector<double>> loads(piles, std::vector<double>(static_cast<std::size_t>(size.columns), 1.0));
      loads[3][25] = 1e3;  // evicted from its group, and drawn by itself
      const std::vector<std::span<const double>> views(loads.begin(), loads.end());
      std::vector<std::uint64_t> samples(piles);
      std::iota(samples.begin(), samples.end(), std::uint64_t{24});
      KeptLayers all, some{{}, true};
      for (int layer = 0; layer < size.layers; ++layer) {
        all.layers.push_back(layer);
        if (layer % 20 == 0) some.layers.push_back(layer);
      }
      std::vector<std::optional<SamplingFailure>> failures(piles);
      for (const KeptLayers* const kept : {&all, &some}) {
        const double before = handed_out();
        const auto sampler = make_sampler(spec, lattice);
        sampler->keep_layers(*kept);
        sampler->draw_groups(samples, views, failures);
        const double taken = handed_out() - before, estimated = drawing_memory(spec, lattice, kept);
        INFO(taken << " of " << estimated << " for " << kept->layers.size() << " layers");
        CHECK(taken <= 1.02 * estimated);
        CHECK(taken >= (kept == &all ? 0.6 : 0.5) * estimated);
      }
    }
  }
}

}  // namespace
}  // namespace granuscope
