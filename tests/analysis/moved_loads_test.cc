// Several overloads in a pile, and piles of a group that share their random numbers (estimator point).
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>
#include <vector>

#include "analysis/mean_response.h"
#include "ensemble/ensemble_runner.h"
#include "ensemble/small_ensemble.h"
#include "sampling/random_key.h"

using namespace granuscope;

namespace {

EnsembleSpec moved(int columns, int overloads, bool coupled) {
  ResponseSpec response = ResponseSpec{.overload = 0.5};
  response.overloads = overloads;
  response.coupled = coupled;
  EnsembleSpec spec = test::small_ensemble(response, columns);
  spec.layers = {3, 8};  // layer 0 comes along
  return spec;
}

/// w - 1 of a layer of a pile drawn by itself, from the numbers of one sample and with its first overload on `bead`.
std::vector<double> variation(const EnsembleSpec& spec, std::uint64_t numbers, int bead, int layer) {
  const Lattice lattice(spec.lattice);
  std::vector<double> load(static_cast<std::size_t>(lattice.columns()), 1.0);
  for (int n = 0; n < spec.response.overloads; ++n) {
    load[static_cast<std::size_t>((bead + n * lattice.columns() / spec.response.overloads) % lattice.columns())] +=
        spec.response.overload;
  }
  Pile pile(lattice);
  REQUIRE_FALSE(make_sampler(spec.sampler, lattice)->draw(numbers, load, pile));
  std::vector<double> w;
  for (int i = 0; i < lattice.columns(); ++i) {
    const std::size_t at = lattice.index(layer, i);
    w.push_back(pile.V_R[at] + pile.V_L[at] - 1);
  }
  return w;
}

}  // namespace

TEST_CASE("moved loads: sums are those of piles drawn by themselves, moved to their loads") {
  for (const auto& [columns, overloads, coupled] :
       {std::tuple{80, 1, true}, {160, 2, true}, {161, 1, true}, {160, 2, false}}) {
    const EnsembleSpec spec = moved(columns, overloads, coupled);
    const EnsembleRecord record = run_ensemble(spec, 2, nullptr);
    REQUIRE(record.sums.layers == std::vector<int>{0, 3, 8});
    const int part = columns / overloads;
    const std::size_t block = 3, width = static_cast<std::size_t>(part);
    for (std::size_t l = 0; l < 3; ++l) {
      std::vector<double> expected(width), shared(static_cast<std::size_t>(columns));
      std::vector<std::vector<double>> piles;
      std::vector<int> beads;
      for (std::uint64_t sample = 24; sample < 32; ++sample) {
        beads.push_back(coupled ? RandomKey(spec.sampler.seed, sample).loaded_bead(part) : columns / 2);
        piles.push_back(variation(spec, coupled ? 24 : sample, beads.back(), record.sums.layers[l]));
        for (std::size_t i = 0; coupled && i < shared.size(); ++i) shared[i] += piles.back()[i] / 8;
      }
      for (std::size_t k = 0; k < 8; ++k) {
        for (int d = 0; d < part; ++d) {
          for (int n = 0; n < overloads; ++n) {
            const auto bead = static_cast<std::size_t>((beads[k] + n * part + d) % columns);
            expected[static_cast<std::size_t>((d + part / 2) % part)] += piles[k][bead] - shared[bead];
          }
        }
      }
      const double* const sums = &record.sums.quantities.at("moved_weight").sum[(block * 3 + l) * width];
      for (std::size_t i = 0; i < width; ++i) CHECK(sums[i] == Approx(expected[i]).margin(1e-11));
    }
  }
}

TEST_CASE("moved loads: a linear model has the same response under one overload, coupled or not") {
  // Legs that share alike: the response is that of the geometry, to rounding, since noise is what is shared.
  const auto response = [](bool coupled) {
    EnsembleSpec spec = moved(240, 1, coupled);
    spec.sampler.model.name = ModelName::q_model;
    spec.sampler.model.q_model.disorder = 0;
    const EnsembleRecord record = run_ensemble(spec, 1, nullptr);
    const std::size_t last = record.sums.layers.size() - 1;
    return mean_response(record.sums, last, spec.response.overload).whole;
  };
  const std::vector<double> one = response(false), alone = response(true);
  REQUIRE(one.size() == 240);
  for (std::size_t i = 0; i < one.size(); ++i) CHECK(alone[i] == Approx(one[i]).margin(1e-12));
  CHECK(std::accumulate(alone.begin(), alone.end(), 0.0) == Approx(1).margin(1e-12));
}

TEST_CASE("moved loads: responses that are known exactly come out exactly, whatever the piles have in common") {
  // Piles w_k(x) = noise(x) + P(x - s_k) + P(x - s_k - part): the P of one overload is what the analysis finds.
  const int part = 30, blocks = 8;
  const std::vector<double> P = [&] {
    std::vector<double> of(part, 0.0);
    of[12] = 0.3, of[13] = 0.25, of[15] = 0.1, of[17] = 0.35;  // the loaded bead is 15
    return of;
  }();
  for (const bool weighed_wrongly : {false, true}) {
    BlockSums sums;
    sums.layers = {0, 4};
    sums.count.assign(blocks, 8);
    QuantitySums& moved = sums.quantities["moved_weight"];
    moved.width = part;
    moved.sum.assign(static_cast<std::size_t>(blocks * 2 * part), 0.0);
    for (int block = 0; block < blocks; ++block) {
      std::vector<int> beads;
      for (int k = 0; k < 8; ++k)
        beads.push_back(RandomKey(3, static_cast<std::uint64_t>(8 * block + k)).loaded_bead(part));
      for (int layer = 0; layer < 2; ++layer) {
        std::vector<std::vector<double>> piles(8, std::vector<double>(part));
        std::vector<double> shared(part);
        for (int k = 0; k < 8; ++k) {
          for (int x = 0; x < part; ++x) {
            const int d = ((x - beads[static_cast<std::size_t>(k)] + part / 2) % part + part) % part;
            const double noise = layer == 0 ? 0 : std::sin(7.0 * x + block);
            const double response = layer == 0 ? (d == part / 2 ? 1.0 : 0.0) : P[static_cast<std::size_t>(d)];
            piles[static_cast<std::size_t>(k)][static_cast<std::size_t>(x)] = noise + 2 * 0.5 * response;
            shared[static_cast<std::size_t>(x)] += piles[static_cast<std::size_t>(k)][static_cast<std::size_t>(x)] / 8;
          }
        }
        for (int k = 0; k < 8; ++k) {
          // Broken on purpose: a pile moved by a bead too many.
          const int bead = beads[static_cast<std::size_t>(k)] + (weighed_wrongly && layer == 1 && k == 0 ? 1 : 0);
          for (int x = 0; x < part; ++x) {
            const int to = ((x - bead + part / 2) % part + part) % part;
            moved.sum[static_cast<std::size_t>((block * 2 + layer) * part + to)] +=
                piles[static_cast<std::size_t>(k)][static_cast<std::size_t>(x)] - shared[static_cast<std::size_t>(x)];
          }
        }
      }
    }
    const BlockMeans found = mean_response(sums, 1, 0.5);
    double worst = 0;
    for (std::size_t i = 0; i < P.size(); ++i) worst = std::max(worst, std::abs(found.whole[i] - P[i]));
    CHECK((worst < 1e-12) == !weighed_wrongly);
    const LayerSpectrum spectrum = layer_spectrum(sums, 1, 0.5);
    CHECK(spectrum.columns == part);
    const Lattice lattice({part, 2});
    for (int m = 1; m <= 14; ++m) {
      double expected = 0;
      for (int i = 0; i < part; ++i) {
        expected += P[static_cast<std::size_t>(i)] *
                    std::cos(2 * std::acos(-1.0) * m * lattice.x(sums.rows.shifted(4) ? 1 : 0, i) / part);
      }
      if (!weighed_wrongly) CHECK(spectrum.whole[static_cast<std::size_t>(m - 1)] == Approx(expected).margin(1e-12));
    }
  }
}

TEST_CASE("moved loads: as many overloads as fit, and a refusal that says why where they do not") {
  EnsembleSpec spec;
  spec.lattice = {500, 200};
  spec.sampler.law = Law::granusolve;
  spec.sampler.mu = 0.3;
  spec.response.samples = 256;
  spec.response.overloads = 0;
  CHECK(overloads_of(spec) == 2);
  CHECK(response_columns(spec) == 250);
  CHECK(moves_loads(spec));
  const auto at = [&](double mu) {
    spec.sampler.mu = mu;
    return overloads_of(spec);
  };
  CHECK(at(0.1) == 2);
  CHECK(at(0.6) == 1);
  CHECK_FALSE(moves_loads(spec));
  spec.response.overloads = 2;
  REQUIRE(find_problem(spec));
  CHECK(find_problem(spec)->message.find("0.5") != std::string::npos);
  spec.sampler.mu = 0.3;
  CHECK_FALSE(find_problem(spec));
  spec.response.overloads = 3;
  CHECK(find_problem(spec)->message.find("evenly") != std::string::npos);
  spec.response.overloads = 4;
  CHECK(find_problem(spec)->message.find("lattice.columns = 976") != std::string::npos);
  spec.lattice = {501, 200};  // 3 * 167
  spec.response.overloads = 0;
  CHECK(overloads_of(spec) == 1);
  spec.response.overloads = 1;
  spec.response.coupled = true;
  spec.sampler.law = Law::polytope;
  CHECK(find_problem(spec)->key == "coupled");
  // What changes no number is not in the configuration, and 0 is the number that it stands for.
  EnsembleSpec plain = test::small_ensemble(ResponseSpec{.overload = 1}, 24), none = plain;
  none.response.overloads = 0;
  CHECK(configuration_text(none) == configuration_text(plain));
  CHECK(configuration_text(plain).find("overloads") == std::string::npos);
  spec = moved(160, 0, true);
  CHECK(configuration_text(spec).find("overloads=2\ncoupled=true\n") != std::string::npos);
  CHECK(configuration_text(ensemble_configured(configuration_text(spec))) == configuration_text(spec));
}

TEST_CASE("moved loads: a sample drawn again is the pile that its group had") {
  const EnsembleSpec spec = moved(160, 2, true);
  const std::uint64_t sample = 29;
  Pile pile{Lattice(spec.lattice)};
  REQUIRE_FALSE(replay(spec, sample, pile));
  const int bead = RandomKey(spec.sampler.seed, sample).loaded_bead(80);
  const std::vector<double> again = variation(spec, 24, bead, 8);
  for (int i = 0; i < 160; ++i) {
    const std::size_t at = pile.lattice.index(8, i);
    CHECK(pile.V_R[at] + pile.V_L[at] - 1 == again[static_cast<std::size_t>(i)]);
  }
  const std::string command = replay_command(spec, sample);
  CHECK(command.find("--overloads 2 --coupled") != std::string::npos);
}
