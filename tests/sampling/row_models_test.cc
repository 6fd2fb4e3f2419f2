// Models that hand rows down, and the numbers that their splits stand for.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <numeric>
#include <vector>

#include "kit/instruction_sets.h"
#include "kit/same_bytes.h"
#include "model/audit.h"
#include "sampling/pile_group.h"
#include "sampling/random_key.h"
#include "sampling/row_model.h"
#include "sampling/sampler.h"
#include "support/error.h"

namespace granuscope {

// Source: the definitions of the models, bead by bead, and what is known of them exactly.

namespace {

using Row = std::vector<double>;

constexpr std::uint64_t seed = 20;
constexpr double five_sigma = 5;

ModelSpec q_model(SplitLaw split) {
  ModelSpec model;
  model.name = ModelName::q_model;
  model.q_model.split = split;
  return model;
}

ModelSpec three_leg(MiddleLaw law, double middle = 0.1, double noise = 0.05) {
  ModelSpec model;
  model.name = ModelName::three_leg;
  model.three_leg = {.law = law, .middle = middle, .noise = noise};
  return model;
}

ModelSpec stochastic_osl(double disorder, int grid, NoiseLaw noise = NoiseLaw::uniform) {
  ModelSpec model;
  model.name = ModelName::stochastic_osl;
  model.stochastic_osl = {.disorder = disorder, .grid = grid, .noise = noise};
  return model;
}

std::vector<ModelSpec> every_model() {
  ModelSpec cells = three_leg(MiddleLaw::free, 0.3, 0.2), coarse = stochastic_osl(0.3, 2);
  cells.three_leg.cell_columns = 2;
  cells.three_leg.cell_rows = 3;
  coarse.stochastic_osl.cell_columns = 2;
  coarse.stochastic_osl.cell_rows = 2;
  return {q_model(SplitLaw::uniform),
          q_model(SplitLaw::critical),
          q_model(SplitLaw::beta),
          three_leg(MiddleLaw::free),
          three_leg(MiddleLaw::positive),
          three_leg(MiddleLaw::clipped, 0.3, 0.2),
          cells,
          stochastic_osl(0.4, 1),
          stochastic_osl(0.4, 3),
          stochastic_osl(0.2, 2, NoiseLaw::gaussian),
          coarse};
}

/// Weights of the samples first .. first + count - 1 in `layer`, [count][columns].
std::vector<Row> weights_of(const ModelSpec& model, const Row& load, int layer, std::uint64_t first, std::size_t count,
                            Row* thrust = nullptr, std::vector<Row>* horizontal = nullptr) {
  SamplerSpec spec;
  spec.model = model;
  spec.seed = seed;
  const auto sampler = make_sampler(spec, Lattice({static_cast<int>(load.size()), layer + 1}));
  sampler->keep_layers({{layer}, horizontal != nullptr});
  std::vector<std::uint64_t> samples(count);
  std::iota(samples.begin(), samples.end(), first);
  const std::vector<std::span<const double>> loads(count, load);
  std::vector<std::optional<SamplingFailure>> failures(count);
  std::vector<Row> weights;
  for (const PileGroup& group : sampler->draw_groups(samples, loads, failures)) {
    for (std::size_t k = 0; k < group.piles; ++k) {
      Row& row = weights.emplace_back();
      for (std::size_t i = 0; i < load.size(); ++i)
        row.push_back(group.weight(group.row(layer) + i * group.stride + k));
      if (thrust != nullptr) thrust->push_back(group.moments_of(layer).thrust[k]);
      if (horizontal == nullptr) continue;
      Row& H = horizontal->emplace_back();
      for (std::size_t i = 0; i < load.size(); ++i) H.push_back(group.H(group.row(layer) + i * group.stride + k));
    }
  }
  return weights;
}

double share_of_middle(const ThreeLegSpec& legs, double u, double F_t, double F_x) {
  const double p_max = 1 - std::abs(F_x) / F_t;
  if (legs.law == MiddleLaw::positive) return u * legs.share * p_max;
  if (legs.law == MiddleLaw::free) return legs.middle + legs.noise * (2 * u - 1);
  const double low = legs.middle - legs.noise, high = std::min(legs.middle + legs.noise, p_max);
  return high < low ? std::max(p_max, 0.0) : low + u * (high - low);
}

double q_of(SplitLaw split, double a, double b, double c) {
  if (split == SplitLaw::uniform) return a;
  if (split == SplitLaw::critical) return a < 0.5 ? 0 : 1;
  return a + b + c - std::min({a, b, c}) - std::max({a, b, c});
}

/// The number that is v = x in a Gaussian distribution of standard deviation 1 cut at |v| = 1, by bisection.
double gaussian_number(double u, double disorder) {
  const auto below = [](double x) { return std::erfc(-x / std::sqrt(2.0)) / 2; };
  const double least = below(-1 / disorder);
  double low = -1 / disorder, high = -low;
  for (int step = 0; step < 100; ++step) {
    const double middle = (low + high) / 2;
    (below(middle) < least + (1 - 2 * least) * u ? low : high) = middle;
  }
  return disorder * low;
}

/// The uniform number of a bead where noise is the same within cells.
double number_in_cell(std::uint64_t sample, int row, int bead, int columns, int width, int height) {
  const auto offset = [&](int band, int which) {
    return noise_number(seed, sample, band, which, 0, NoiseStream::offset);
  };
  const int band = (row + static_cast<int>(height * offset(0, 0))) / height;
  const int cell = (bead + static_cast<int>(width * offset(band, 1))) % columns / width;
  return noise_number(seed, sample, band, cell, 0, NoiseStream::cell);
}

/// One pile by the definition of its model, weights of `layer`, and what horizontal force enters its beads.
Row naive(const ModelSpec& model, Row w, int layer, std::uint64_t sample, Row* horizontal = nullptr) {
  const int columns = static_cast<int>(w.size());
  const auto ring = [&](int i) { return static_cast<std::size_t>((i % columns + columns) % columns); };
  const bool osl = model.name == ModelName::stochastic_osl;
  const int cell_columns = osl ? model.stochastic_osl.cell_columns : model.three_leg.cell_columns;
  const int cell_rows = osl ? model.stochastic_osl.cell_rows : model.three_leg.cell_rows;
  const auto u = [&](int row, int i, std::uint32_t number) {
    return cell_columns == 1 && cell_rows == 1 ? noise_number(seed, sample, row, i, number, NoiseStream::row)
                                               : number_in_cell(sample, row, i, columns, cell_columns, cell_rows);
  };
  const int grid = model.stochastic_osl.grid;
  Row F_x(w.size());
  if (model.name == ModelName::stochastic_osl) {
    Row nodes, h(w.size() * static_cast<std::size_t>(grid));
    for (const double load : w) nodes.insert(nodes.end(), static_cast<std::size_t>(grid), load);
    const int all = columns * grid;
    const auto node = [&](int j) { return static_cast<std::size_t>((j % all + all) % all); };
    const double courant = std::sqrt(3.0) / 2, disorder = model.stochastic_osl.disorder;
    const auto deviation = [&](double number) {
      return model.stochastic_osl.noise == NoiseLaw::gaussian ? gaussian_number(number, disorder)
                                                              : std::sqrt(3.0) * disorder * (2 * number - 1);
    };
    for (int n = 0; n < layer; ++n) {
      for (int step = 0; step < grid; ++step) {
        const auto stress = [&](int j) {
          return (1 + deviation(u(n, static_cast<int>(node(j)) / grid, 0))) / 3 * nodes[node(j)];
        };
        for (int j = 0; j < all; ++j) h[node(j)] -= courant * (stress(j + 1) - stress(j));
        for (int j = 0; j < all; ++j) nodes[node(j)] -= courant * (h[node(j)] - h[node(j - 1)]);
      }
    }
    for (std::size_t i = 0; i < w.size(); ++i) {
      const auto first = nodes.begin() + static_cast<std::ptrdiff_t>(i) * grid;
      w[i] = std::accumulate(first, first + grid, 0.0) / grid;
      // A node bears the mean of the fluxes beside it.
      for (int j = static_cast<int>(i) * grid; j < (static_cast<int>(i) + 1) * grid; ++j) {
        F_x[i] += (h[node(j - 1)] + h[node(j)]) / (2 * grid);
      }
    }
    if (horizontal != nullptr) *horizontal = F_x;
    return w;
  }
  for (int n = 0; n < layer; ++n) {
    Row below(w.size()), F_x_below(w.size());
    for (int i = 0; i < columns; ++i) {
      const double F_t = w[ring(i)], push = F_x[ring(i)];
      if (model.name == ModelName::q_model) {
        const double q = q_of(model.q_model.split, u(n, i, 0), u(n, i, 1), u(n, i, 2));
        below[ring(n % 2 == 0 ? i - 1 : i)] += q * F_t;
        below[ring(n % 2 == 0 ? i : i + 1)] += (1 - q) * F_t;
      } else {
        // F_x in units of tan psi.
        const double p = share_of_middle(model.three_leg, u(n, i, 0), F_t, push);
        const double right = ((1 - p) * F_t + push) / 2, left = ((1 - p) * F_t - push) / 2;
        below[ring(i)] += p * F_t;
        below[ring(i + 1)] += right;
        below[ring(i - 1)] += left;
        F_x_below[ring(i + 1)] += right;
        F_x_below[ring(i - 1)] -= left;
      }
    }
    w = below;
    F_x = F_x_below;
  }
  if (horizontal != nullptr) *horizontal = F_x;
  return w;
}

Row uneven_load(std::size_t columns) {
  Row load(columns, 1.0);
  load[columns / 2] = 2;
  load[1] = 0.25;
  return load;
}

}  // namespace

TEST_CASE("every model hands down what its definition says, bead by bead") {
  constexpr double rounding = 1e-12;
  for (const ModelSpec& model : every_model()) {
    const bool cells = model.three_leg.cell_columns > 1 || model.stochastic_osl.cell_columns > 1;
    for (const std::size_t columns : {cells ? 12U : 5U, 8U}) {
      const Row load = uneven_load(columns);
      std::vector<Row> horizontal;
      const auto weights = weights_of(model, load, 13, 3, 11, nullptr, &horizontal);
      for (std::size_t k = 0; k < weights.size(); ++k) {
        Row expected_horizontal;
        const Row expected = naive(model, load, 13, 3 + k, &expected_horizontal);
        for (std::size_t i = 0; i < columns; ++i) {
          CHECK(std::abs(weights[k][i] - expected[i]) < rounding);
          CHECK(std::abs(horizontal[k][i] - expected_horizontal[i]) < rounding);
        }
      }
    }
  }
}

TEST_CASE("piles of every model are the same bytes on every instruction set and in whatever company they are drawn") {
  for (const ModelSpec& model : every_model()) {
    const Row load = uneven_load(12);
    const auto reference = weights_of(model, load, 20, 0, 16);
    for_each_instruction_set([&] { CHECK(weights_of(model, load, 20, 0, 16) == reference); });
    for (std::uint64_t sample : {0U, 5U, 15U}) {
      CHECK(weights_of(model, load, 20, sample, 1).front() == reference[sample]);
    }
    CHECK(reference[0] != reference[1]);
  }
}

TEST_CASE("every model conserves weight to rounding, and left and right are alike") {
  constexpr double rounding = 1e-12;
  for (const ModelSpec& model : every_model()) {
    constexpr std::size_t columns = 24, piles = 512;
    constexpr int layer = 9;  // nothing has come around the ring yet
    Row load(columns, 1.0);
    load[columns / 2] = 2;
    double first = 0, square = 0;
    for (const Row& w : weights_of(model, load, layer, 0, piles)) {
      CHECK(std::abs(std::accumulate(w.begin(), w.end(), 0.0) / (columns + 1) - 1) < rounding);
      double moment = 0;
      for (std::size_t i = 0; i < columns; ++i) {
        const double shift = rows_of(model).shifted(layer) ? 0.5 : 0;
        moment += (static_cast<double>(i) - columns / 2 + shift) * (w[i] - 1);
      }
      first += moment;
      square += moment * moment;
    }
    // Of odd rows the bead farthest left is left over: its background is no part of the response.
    const double mean = first / piles, error = std::sqrt((square / piles - mean * mean) / piles);
    INFO(configuration_text(model));
    CHECK(error > 0);
    CHECK(std::abs(mean) < five_sigma * error);
  }
}

namespace {

/// Chance that a weight of mean 1 on a ring of N is at most w where all are jointly Dirichlet's of parameter a: that of
/// a beta distribution of parameters a and a (N - 1), by the binomial sum.
double dirichlet_weight(int a, int N, double w) {
  const int b = a * (N - 1), n = a + b - 1;
  const double x = std::min(1.0, w / N);
  double above = 0, term = std::pow(1 - x, n);
  for (int j = 0; j < a; ++j) {
    above += term;
    term *= x / (1 - x) * (n - j) / (j + 1);
  }
  return 1 - above;
}

/// Largest distance of the two distribution functions times the root of the number of weights.
double kolmogorov_distance(Row weights, const std::function<double(double)>& distribution) {
  std::sort(weights.begin(), weights.end());
  const auto n = static_cast<double>(weights.size());
  double largest = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const double expected = distribution(weights[i]), at = static_cast<double>(i);
    largest = std::max({largest, (at + 1) / n - expected, expected - at / n});
  }
  return largest * std::sqrt(n);
}

/// Of 5 standard deviations: 2 exp(-2 K^2) = 5.7e-7.
constexpr double largest_distance = 2.74;

Row deep_weights(SplitLaw split, int columns, int layer, std::size_t piles) {
  Row all;
  for (const Row& row : weights_of(q_model(split), Row(static_cast<std::size_t>(columns), 1.0), layer, 0, piles)) {
    all.insert(all.end(), row.begin(), row.end());
  }
  return all;
}

}  // namespace

TEST_CASE("weights deep in the q-model have their exact distribution: on a wide ring 4 w exp(-2 w)") {
  constexpr int columns = 32, layer = 800;  // relaxes within columns^2/10 layers
  for (const auto& [split, a] : {std::pair{SplitLaw::uniform, 2}, {SplitLaw::beta, 4}}) {
    const Row weights = deep_weights(split, columns, layer, 256);
    CHECK(kolmogorov_distance(weights, [a = a](double w) { return dirichlet_weight(a, columns, w); }) <
          largest_distance);
    // The test tells the two laws apart.
    CHECK(kolmogorov_distance(weights, [a = a](double w) { return dirichlet_weight(6 - a, columns, w); }) >
          2 * largest_distance);
  }
  // The limit of the wide ring.
  const auto limit = [](double w) { return 1 - (1 + 2 * w) * std::exp(-2 * w); };
  for (const double w : {0.1, 0.5, 1.0, 2.0, 4.0})
    CHECK(dirichlet_weight(2, 100'000, w) == Approx(limit(w)).epsilon(1e-3));
}

TEST_CASE("the mean response of the q-model is binomial under every law of q") {
  constexpr int columns = 24, layer = 12;
  constexpr std::size_t piles = 4096;
  Row load(columns, 1e-9);
  load[columns / 2] = 1;
  for (const SplitLaw split : {SplitLaw::uniform, SplitLaw::critical, SplitLaw::beta}) {
    Row sum(columns), square(columns);
    for (const Row& w : weights_of(q_model(split), load, layer, 0, piles)) {
      for (std::size_t i = 0; i < columns; ++i) sum[i] += w[i], square[i] += w[i] * w[i];
    }
    double binomial = std::pow(0.5, layer), variance = 0, expected_variance = 0;
    for (int right = 0; right <= layer; ++right) {
      const double x = right - layer / 2.0;
      const auto i = static_cast<std::size_t>(columns / 2 + right - layer / 2);
      const double mean = sum[i] / piles, error = std::sqrt((square[i] / piles - mean * mean) / piles);
      CHECK(std::abs(mean - binomial) < five_sigma * error + 1e-7);
      variance += x * x * mean;
      expected_variance += x * x * binomial;
      binomial *= static_cast<double>(layer - right) / (right + 1);
    }
    CHECK(expected_variance == Approx(layer / 4.0));
    CHECK(variance == Approx(layer / 4.0).epsilon(0.1));
  }
}

TEST_CASE("independent noise leaves the mean response of the free three-leg model as it is, exactly") {
  constexpr int columns = 32, layer = 14;
  constexpr std::size_t piles = 4096;
  Row load(columns, 1.0);
  load[columns / 2] = 2;
  const Row expected = naive(three_leg(MiddleLaw::free, 0.3, 0.0), load, layer, 0);
  Row sum(columns), square(columns);
  for (const Row& w : weights_of(three_leg(MiddleLaw::free, 0.3, 0.3), load, layer, 0, piles)) {
    for (std::size_t i = 0; i < columns; ++i) sum[i] += w[i], square[i] += w[i] * w[i];
  }
  for (std::size_t i = 0; i < columns; ++i) {
    const double mean = sum[i] / piles, error = std::sqrt((square[i] / piles - mean * mean) / piles);
    CHECK(error < 0.02);
    CHECK(std::abs(mean - expected[i]) < five_sigma * error);
  }
}

TEST_CASE("legs of the positive and the clipped model push, and a fast one carries what a throw-away code found") {
  // Guidance: <p> = 0.337, thrust 0.8129(1)^2, variance of F_t 0.32, deep down.
  constexpr int columns = 64, layer = 150;
  constexpr std::size_t piles = 128;
  Row thrust;
  double variance = 0;
  for (const Row& w : weights_of(three_leg(MiddleLaw::positive), Row(columns, 1.0), layer, 0, piles, &thrust)) {
    for (const double one : w) {
      CHECK(one >= 0);
      variance += (one - 1) * (one - 1) / (columns * piles);
    }
  }
  double alpha = 0;
  for (const double one : thrust) alpha += sqrt3 * one / (columns * piles);
  CHECK(std::sqrt(alpha) == Approx(0.8129).margin(0.004));
  CHECK(variance == Approx(0.32).margin(0.02));
}

TEST_CASE("a model refuses what it cannot be") {
  const LatticeSpec lattice{20, 10};
  const auto key_of = [&](const ModelSpec& model) {
    const Problem found = find_problem(model, lattice);
    return found ? found->key : std::string();
  };
  for (const ModelSpec& model : every_model()) CHECK(key_of(model).empty());
  CHECK(key_of(three_leg(MiddleLaw::free, 1.0, 0)) == "three_leg.middle");
  CHECK(key_of(three_leg(MiddleLaw::free, 0.1, 0.2)) == "three_leg.noise");
  CHECK(key_of(stochastic_osl(0.6, 1)) == "stochastic_osl.disorder");
  CHECK(key_of(stochastic_osl(0.3, 1, NoiseLaw::gaussian)) == "stochastic_osl.disorder");
  CHECK(key_of(stochastic_osl(0.1, 0)) == "stochastic_osl.grid");
  ModelSpec cells = three_leg(MiddleLaw::free);
  cells.three_leg.cell_columns = 3;
  CHECK(key_of(cells) == "three_leg.cell_columns");
  cells = three_leg(MiddleLaw::positive);
  cells.three_leg.cell_rows = 2;
  CHECK(key_of(cells) == "three_leg.cell_columns");
  SamplerSpec spec;
  spec.model = q_model(SplitLaw::uniform);
  Pile pile{Lattice(lattice)};
  CHECK_THROWS_AS(make_sampler(spec, Lattice(lattice))->draw(0, Row(20, 1.0), pile), InputError);
}

namespace {

struct DrawnModel {
  Pile pile;
  std::unique_ptr<Sampler> sampler;
};

DrawnModel draw(Law law, double mu, LatticeSpec size, std::uint64_t sample, const std::vector<double>& load) {
  const Lattice lattice(size);
  SamplerSpec spec;
  spec.law = law;
  spec.mu = mu;
  spec.seed = 31;
  DrawnModel drawn{Pile(lattice), make_sampler(spec, lattice)};
  REQUIRE_FALSE(drawn.sampler->draw(sample, load, drawn.pile).has_value());
  return drawn;
}

std::size_t count_redrawn(const Pile& first, const Pile& again) {
  std::vector<unsigned char> redrawn;
  find_redrawn(first, again, redrawn);
  return std::accumulate(redrawn.begin(), redrawn.end(), std::size_t{0});
}

constexpr LatticeSpec small{.columns = 40, .layers = 50}, tiny{.columns = 4, .layers = 4};

}  // namespace

TEST_CASE("numbers are the places of the splits in their intervals") {
  const DrawnModel first = draw(Law::rejection, 0.3, tiny, 2, std::vector<double>(4, 1.0));
  std::vector<double> numbers;
  read_split_uniforms(first.pile, numbers);
  const RandomKey key(31, 2);
  // The try that was accepted is the last one; every number is then the one it drew.
  const auto attempt = static_cast<std::uint32_t>(first.sampler->counts().tries);
  for (int n = 0; n < 4; ++n) {
    for (int i = 0; i < 4; ++i) {
      CHECK(numbers[first.pile.lattice.index(n, i)] == Approx(key.attempt(n, i, attempt).first).margin(1e-12));
    }
  }
}

TEST_CASE("solved again under the same load a pile is the same, byte for byte") {
  // Byte for byte: forces as a function of the numbers are chaotic, and at mu = 1 rounding alone would change every
  // force below 50 layers.
  for (const double mu : {0.0, 0.02, 0.1, 0.5, 1.0, 1.7}) {
    const std::vector<double> load(40, 1.0);
    DrawnModel first = draw(Law::granusolve, mu, {.columns = 40, .layers = 400}, 3, load);
    Pile again(first.pile.lattice);
    const auto uniforms_before = first.sampler->counts().uniforms;
    REQUIRE_FALSE(first.sampler->draw_again(3, load, first.pile, again).has_value());
    INFO("mu " << mu);
    CHECK(count_redrawn(first.pile, again) == 0);
    CHECK(first.sampler->counts().uniforms == uniforms_before);  // nothing was drawn
    CHECK(again.H_R == first.pile.H_R);
    CHECK(again.V_L == first.pile.V_L);
  }
}

TEST_CASE("a load multiplied by a power of two redraws nothing and scales the pile") {
  const std::vector<double> load(40, 1.0), quadrupled(40, 4.0);
  DrawnModel first = draw(Law::granusolve, 0.3, small, 5, load);
  Pile again(first.pile.lattice);
  REQUIRE_FALSE(first.sampler->draw_again(5, quadrupled, first.pile, again).has_value());
  CHECK(count_redrawn(first.pile, again) == 0);
  for (std::size_t at = 0; at < again.V_R.size(); ++at) {
    CHECK(again.V_R[at] == Approx(4 * first.pile.V_R[at]).epsilon(1e-9));
  }
}

TEST_CASE("an overload redraws beads inside its light cone only, and the piles stay solutions") {
  // A failing bead makes its parents change, and those their children: the disturbance spreads by a column or so per
  // layer, whatever the friction; on the far side of the ring the two piles are the same.
  const LatticeSpec wide{.columns = 300, .layers = 40};
  std::vector<double> load(300, 1.0);
  for (const double mu : {0.1, 0.3, 1.0}) {
    std::size_t redrawn_beads = 0;
    for (std::uint64_t sample = 0; sample < 20; ++sample) {
      load[150] = 1;
      DrawnModel first = draw(Law::granusolve, mu, wide, sample, load);
      load[150] = 2;
      Pile again(first.pile.lattice);
      REQUIRE_FALSE(first.sampler->draw_again(sample, load, first.pile, again).has_value());
      const AuditResult residuals = granuscope::audit(again);
      CHECK(residuals.max_balance_residual < 1e-10);
      CHECK(residuals.max_cone_violation < 1e-10);
      std::vector<unsigned char> redrawn;
      find_redrawn(first.pile, again, redrawn);
      for (int n = 0; n < 40; ++n) {
        for (int i = 0; i < 300; ++i) {
          const std::size_t at = again.lattice.index(n, i);
          redrawn_beads += redrawn[at];
          if (std::abs(again.lattice.x(n, i)) > 120) {
            CHECK(redrawn[at] == 0);
            CHECK(again.V_R[at] == first.pile.V_R[at]);
          }
        }
      }
    }
    INFO("mu " << mu);
    CHECK(redrawn_beads > 0);
  }
}

// A pair draws two numbers and the three ancestors at the top of a first backtrack (four where the backtrack ends at
// the top of the pile) one each. Nothing else does: beads that draw again because a neighbour was repaired or a
// backtrack has unsolved them, and beads that had no solution themselves, keep their numbers.
TEST_CASE("solved again, only repaired parents and the top of a backtrack draw numbers") {
  const LatticeSpec size{.columns = 60, .layers = 40};
  std::vector<double> load(60, 1.0), overloaded = load;
  overloaded[30] = 2;
  int pairs_alone = 0, one_backtrack = 0;
  std::uint64_t redrawn_beads = 0, numbers = 0;
  for (const double mu : {0.1, 0.3, 0.8}) {
    SamplerSpec spec;
    spec.mu = mu;
    spec.seed = 31;
    const Lattice lattice(size);
    const auto sampler = make_sampler(spec, lattice);
    Pile first(lattice), again(lattice);
    for (std::uint64_t sample = 0; sample < 100; ++sample) {
      REQUIRE_FALSE(sampler->draw(sample, load, first));
      const SamplerCounts before = sampler->counts();
      REQUIRE_FALSE(sampler->draw_again(sample, overloaded, first, again));
      const SamplerCounts after = sampler->counts();
      if (after.arcs + after.rings > before.arcs + before.rings) continue;
      const std::uint64_t drawn = after.uniforms - before.uniforms, of_pairs = 2 * (after.pairs - before.pairs),
                          backtracks = after.backtracks - before.backtracks;
      CAPTURE(mu, sample, drawn, of_pairs, backtracks);
      if (backtracks == 0) {
        CHECK(drawn == of_pairs);
        pairs_alone += drawn > 0 ? 1 : 0;
        redrawn_beads += count_redrawn(first, again);
        numbers += drawn;
      } else if (backtracks == 1) {
        CHECK(drawn >= of_pairs + 3);
        CHECK(drawn <= of_pairs + 4);
        ++one_backtrack;
      }
    }
  }
  CAPTURE(pairs_alone, one_backtrack, redrawn_beads, numbers);
  CHECK(pairs_alone >= 50);
  CHECK(one_backtrack >= 10);
  // A parent that was repaired stands elsewhere than its number would put it, unless it was repaired more than once.
  CHECK(redrawn_beads <= numbers);
  CHECK(10 * redrawn_beads > 7 * numbers);
}

// What is drawn when a pile is solved again is independent of the numbers it keeps, of which some are later attempts of
// the first solution. The numbers of both are told apart by their attempts.
TEST_CASE("numbers drawn when a pile is solved again are none of the first solution") {
  const LatticeSpec size{.columns = 60, .layers = 40};
  const Lattice lattice(size);
  std::vector<double> load(60, 1.0), overloaded = load;
  overloaded[30] = 2;
  constexpr std::uint32_t tries = 16, again_after = std::uint32_t{1} << 23;
  std::vector<unsigned char> redrawn;
  std::vector<double> numbers;
  int of_first = 0, of_again = 0;
  for (std::uint64_t sample = 0; sample < 100; ++sample) {
    DrawnModel first = draw(Law::granusolve, 0.1, size, sample, load);
    Pile again(lattice);
    REQUIRE_FALSE(first.sampler->draw_again(sample, overloaded, first.pile, again));
    find_redrawn(first.pile, again, redrawn);
    read_split_uniforms(again, numbers);
    const RandomKey key(31, sample);
    for (int n = 0; n < size.layers; ++n) {
      for (int i = 0; i < size.columns; ++i) {
        const std::size_t at = lattice.index(n, i);
        if (redrawn[at] == 0) continue;
        for (std::uint32_t k = 1; k <= tries; ++k) {
          of_first += std::abs(key.attempt(n, i, k).first - numbers[at]) < 1e-9 ? 1 : 0;
          of_again += std::abs(key.attempt(n, i, again_after + k).first - numbers[at]) < 1e-9 ? 1 : 0;
        }
      }
    }
  }
  CHECK(of_first == 0);
  CHECK(of_again >= 20);  // beads at the top of a backtrack stand where their number says
}

TEST_CASE(
    "the law rejection, solved again, keeps every number, or draws a pile anew from tries that are not the first's") {
  const std::vector<double> load(4, 1.0), other = {1, 1, 1.6, 1};
  const Lattice lattice(tiny);
  int kept = 0, drawn_anew = 0;
  std::vector<double> numbers;
  for (std::uint64_t sample = 0; sample < 300; ++sample) {
    DrawnModel first = draw(Law::rejection, 0.3, tiny, sample, load);
    const auto tries = static_cast<std::uint32_t>(first.sampler->counts().tries);
    const auto uniforms = first.sampler->counts().uniforms;
    CAPTURE(sample, tries);
    Pile again(lattice);
    REQUIRE_FALSE(first.sampler->draw_again(sample, load, first.pile, again));
    CHECK(again.H_R == first.pile.H_R);
    CHECK(again.V_L == first.pile.V_L);
    CHECK(first.sampler->counts().tries == tries + 1);
    REQUIRE_FALSE(first.sampler->draw_again(sample, other, first.pile, again));
    if (first.sampler->counts().tries == tries + 2) {
      CHECK(first.sampler->counts().uniforms == uniforms);
      CHECK(count_redrawn(first.pile, again) == 0);
      ++kept;
      continue;
    }
    ++drawn_anew;
    read_split_uniforms(again, numbers);
    const RandomKey key(31, sample);
    int of_first = 0;
    for (std::uint32_t attempt = 1; attempt <= tries; ++attempt) {
      of_first += std::abs(key.attempt(0, 0, attempt).first - numbers[0]) < 1e-12 ? 1 : 0;
    }
    CHECK(of_first == 0);
  }
  CHECK(kept > 20);
  CHECK(drawn_anew > 20);
}

TEST_CASE("solving again depends on its arguments only, for every law") {
  for (const Law law : {Law::granusolve, Law::rejection}) {
    std::vector<double> load(4, 1.0);
    DrawnModel first = draw(law, 0.3, tiny, 9, load);
    load[2] = 2;
    Pile again(first.pile.lattice), once_more(first.pile.lattice), other(first.pile.lattice);
    REQUIRE_FALSE(first.sampler->draw_again(9, load, first.pile, again).has_value());
    REQUIRE_FALSE(first.sampler->draw(17, load, other).has_value());
    REQUIRE_FALSE(first.sampler->draw_again(9, load, first.pile, once_more).has_value());
    CHECK(again.H_R == once_more.H_R);
    // After solving again, an ordinary pile is an ordinary pile.
    Pile plain(first.pile.lattice);
    REQUIRE_FALSE(first.sampler->draw(9, std::vector<double>(4, 1.0), plain).has_value());
    CHECK(plain.H_R == first.pile.H_R);
  }
}

TEST_CASE("a first pile of another lattice, or the same pile twice, is refused") {
  const std::vector<double> load(4, 1.0);
  DrawnModel first = draw(Law::granusolve, 0.3, tiny, 9, load);
  CHECK_THROWS_AS(first.sampler->draw_again(9, load, first.pile, first.pile), std::logic_error);
  Pile again(first.pile.lattice);
  CHECK_THROWS_AS(first.sampler->draw_again(9, load, Pile(Lattice(small)), again), std::logic_error);
}

}  // namespace granuscope
