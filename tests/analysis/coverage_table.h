#pragma once
#include <string>
#include <vector>

#include "analysis/scaling.h"

namespace granuscope::test {

/// How a number of the report's page, measured on many ensembles under other seeds, scatters about its mean over them,
/// and what its errors said about that. Numbers of one name (the same one at several depths or friction coefficients)
/// share a row; every error is taken from the scatter over ensembles, so that it knows what they have in common.
struct CoverageRow {
  std::string name;
  double known = 0;                       ///< share of ensembles that tell it
  double in_one = 0, in_one_error = 0;    ///< share within one standard error of the mean
  double in_two = 0, in_two_error = 0;    ///< and within two
  double log_ratio = 0, ratio_error = 0;  ///< ln of stated over true error
  double bias = 0;  ///< distance of the mean from what all piles together give, in true errors of one ensemble
};

class CoverageTable {
 public:
  /// One number of all ensembles, and what all their piles together give; NaN if that is not to be compared.
  void add(const std::string& name, const std::vector<Estimate>& by_ensemble, double together);

  std::vector<CoverageRow> rows() const;
  std::string text() const;
  /// Holds every row against what errors from 32 blocks promise; prints the table.
  void check() const;

 private:
  struct Number {
    std::vector<Estimate> by_ensemble;
    double together;
  };
  struct Numbers {
    std::string name;
    std::vector<Number> all;
  };
  std::vector<Numbers> numbers_;
};

/// `usual`, or what the variable GRANUSCOPE_COVERAGE_ENSEMBLES asks for.
int coverage_ensembles(int usual);

/// Ensembles that differ in the seed and in mu, and their table.
struct PageOfNumbers {
  EnsembleSpec spec;
  FitSpec fit;
  std::vector<double> friction;
  std::uint64_t first_seed = 0;
};

/// Every number with an error that a page shows of these ensembles: their slopes, depths and powers, and from three
/// friction coefficients on the exponents of mu.
CoverageTable measure_coverage(PageOfNumbers page, int ensembles);

}  // namespace granuscope::test
