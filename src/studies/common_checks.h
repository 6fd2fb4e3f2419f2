#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "model/lattice.h"
#include "support/key.h"

namespace granuscope {

// Limits that no sensible experiment meets; beyond them a slip of the keyboard is more likely than an intention.
inline constexpr double most_memory = 32e9;  // bytes
inline constexpr std::size_t most_friction_values = 1000;
inline constexpr int most_columns = 1'000'000;
inline constexpr int most_layers = 1'000'000;
// The rejection law accepts 4.5 % of the piles of 6 x 6 beads at mu = 0.3 and exponentially fewer of larger ones.
inline constexpr int most_beads_by_rejection = 256;
// Contacts reach the horizontal at mu = sqrt(3): the interval of each bead is then unbounded.
inline constexpr double mu_limit = sqrt3;

/// Friction coefficients of a list or a single one: from 0, or above it where nothing can be measured without friction,
/// to below mu_limit.
KeyRange friction_range();
KeyRange friction_range_above_zero();

/// Memory that one pile needs while it is drawn, in bytes.
double pile_memory(double columns, double layers);

/// `memory`: what piles of this size need together with what is measured on them, in bytes.
Problem find_lattice_problem(const std::string& columns_key, int columns, const std::string& layers_key, int layers,
                             int least_layers, double memory);

/// The samples of an ensemble in so many blocks: a whole group of eight in each.
Problem find_samples_problem(const std::string& key, std::uint64_t samples, int blocks);

/// Friction coefficients that are measured once more as a check: each must be among those that are measured.
Problem find_check_problem(const std::string& key, const std::vector<double>& checked, const std::string& measured_key,
                           const std::vector<double>& measured);

}  // namespace granuscope
