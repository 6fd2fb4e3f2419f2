#pragma once
#include <fmt/core.h>

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "experiment/experiment_check.h"
#include "model/lattice.h"

namespace granuscope {

// What the parts of the check share.

using Problem = std::optional<ExperimentProblem>;

// Limits that no sensible experiment meets; beyond them a slip of the keyboard is more likely than an intention.
inline constexpr double most_memory = 32e9;  // bytes
inline constexpr std::uint64_t most_samples = 1'000'000'000;
inline constexpr std::size_t most_friction_values = 1000;
inline constexpr int most_blocks = 10'000;
inline constexpr int most_columns = 1'000'000;
inline constexpr int most_layers = 1'000'000;
// The rejection law accepts 4.5 % of the piles of 6 x 6 beads at mu = 0.3 and exponentially fewer of larger ones.
inline constexpr int most_beads_by_rejection = 256;
// Contacts reach the horizontal at mu = sqrt(3): the interval of each bead is then unbounded.
inline constexpr double mu_limit = sqrt3;

template <class... Args>
Problem problem(const char* key, fmt::format_string<Args...> text, Args&&... args) {
  return ExperimentProblem{key, fmt::format(text, std::forward<Args>(args)...)};
}

/// What one pile needs while it is drawn, in bytes.
double pile_memory(double columns, double layers);

/// `memory`: what piles of this size need together with what is measured on them, in bytes.
Problem find_lattice_problem(const char* columns_key, int columns, const char* layers_key, int layers, int least_layers,
                             double memory);

Problem find_mu_problem(const char* key, double mu);

/// The tables [figures.*] that bring ensembles of their own.
Problem find_side_problem(const Experiment& e);

}  // namespace granuscope
