#pragma once
#include <nlohmann/json_fwd.hpp>

#include <array>
#include <filesystem>

#include "analysis/jackknife.h"
#include "analysis/mean_response.h"
#include "studies/study.h"

namespace granuscope {
/// The response at one friction coefficient to one kind and size of load, beside the linear response.
struct LoadResponse {
  EnsembleSpec spec;                    ///< under a uniform load there is no response, only the thrust ratio
  bool reference = false;               ///< taken for the linear response
  std::uint64_t samples = 0;            ///< piles that entered
  std::uint64_t failed = 0;             ///< piles that could not be completed
  int first_layer = 0, last_layer = 0;  ///< of the window of the slopes
  bool own_window = false;              ///< shorter than the one common to the other loads at this mu, see LoadComparer
  Estimate c, D, c_thrust;
  Estimate c_shift;         ///< c minus that of the linear response, over the same layers
  Estimate D_shift;         ///< D over that of the linear response, minus 1; likewise
  Estimate c_thrust_shift;  ///< c_thrust minus that of uniformly loaded piles

  bool uniform() const { return spec.load == Load::uniform; }
  double load() const { return uniform() ? 0 : load_size(spec.response); }
};

/// The exponents over the friction coefficients of one load.
struct LoadExponents {
  ResponseSpec response;
  bool reference = false;
  std::array<double, 2> window{};  ///< of mu: the least and largest that took part
  int points = 0;                  ///< friction coefficients that took part
  Estimate beta, gamma;
  Estimate beta_shift, gamma_shift;  ///< minus those of the linear response at the same friction coefficients
};

/// How far the response depends on the size of the load: c, D and the exponents for several loads.
struct LoadComparison {
  std::vector<LoadResponse> responses;   ///< ascending in mu, at each mu in the order of the exponents, then uniform
  std::vector<LoadExponents> exponents;  ///< multiplexed ascending in epsilon, then point ascending in the overload
};

/// A load takes part in the common window if it can be fitted at this share of the depths of the linear response.
inline constexpr double common_share = 0.75;

/// Compares the responses to several loads. Ensembles come friction coefficient by friction coefficient, ascending,
/// each time the same loads; those of one friction coefficient are kept until the next one begins.
///
/// Which layers: the linear response has a window of its own, the deepest unbroken run of identifiable depths. A load
/// whose run holds at least `common_share` of its depths takes part in the common window, where the runs of all these
/// loads overlap, and over which all of them are fitted. A load that can be fitted at fewer depths would cut the window
/// of all others short; it is fitted, and compared with the linear response, over its own part of the common window.
///
/// Every shift is taken with its own error: the ensembles share random numbers, so that block b is left out of all of
/// them at once. Their blocks must hold whole rounds of groups, interleaved (ensemble_spec.h): then block b of one
/// holds no pile of another block of the other.
class LoadComparer {
 public:
  /// `reference_epsilon`: the multiplexed ensemble that is taken for the linear response. `threads` changes no number.
  LoadComparer(const FitSpec& fit, double reference_epsilon, int threads)
      : fit_(fit), reference_epsilon_(reference_epsilon), threads_(threads) {}

  void add(MeasuredEnsemble ensemble);
  LoadComparison finish();

 private:
  struct Slope {
    Estimate estimate;
    Replicated replicates;  ///< empty if unknown
  };
  struct Slopes {
    Slope c, D;
  };
  /// One response with what its shifts and the exponents need.
  struct Measured {
    LoadResponse response;
    int depths = 0;  ///< in its window
    Slopes slopes;
    Slopes linear;  ///< of the linear response over the same layers
  };

  void close_friction();
  FitSpec starting_at(int first_layer) const;
  int first_common_layer(const std::vector<Measured>& measured) const;
  Measured measure(const MeasuredEnsemble& ensemble, const FitSpec& fit) const;
  static bool has_logarithms(const Slopes& slopes);
  LoadExponents measure_exponents(std::size_t k) const;

  FitSpec fit_;
  double reference_epsilon_;
  int threads_;
  std::vector<MeasuredEnsemble> open_;           ///< of one friction coefficient
  std::vector<std::vector<Measured>> measured_;  ///< by friction coefficient
};

/// The response to several kinds and sizes of load, beside the linear response; `measured`: what was found, if that is
/// known already.
std::unique_ptr<Study> nonlinearity_study(LoadComparison measured = {});

/// How far D and c measured with loads of several kinds and sizes lie from those of the linear response, against the
/// size of the load, one pair of curves (point, multiplexed) for each friction coefficient.
/// Writes figures/<study>*.csv, .gp, .svg and .pdf below `run_folder`, from the templates of the study.
/// Throws InputError if nothing could be compared, EnvironmentError if gnuplot is missing or fails.
Figure plot_load_comparison(const LoadComparison& measured, const std::string& study,
                            const std::filesystem::path& run_folder);

/// What the part of the report asks for beside its numbers: which rows say what, and why others are not known.
/// `summary` holds the numbers at `base`, where the part finds them.
Json load_overlay(const Json& summary, const std::string& base);

}  // namespace granuscope
