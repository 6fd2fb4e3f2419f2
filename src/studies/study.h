#pragma once
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "analysis/precision.h"
#include "analysis/results.h"
#include "analysis/shape_fit.h"
#include "analysis/transport.h"
#include "ensemble/ensemble_spec.h"
#include "model/lattice.h"
#include "plot/figure_captions.h"
#include "render/scene.h"
#include "report/clean_json.h"
#include "report/report_data.h"
#include "sampling/sampler_spec.h"
#include "support/error.h"
#include "support/key.h"
#include "support/plain_text.h"

// What every study includes.
namespace granuscope {
/// The rendered force network of one named pile (the paper's Fig. 1, right): never a chosen sample.
struct ForceChainSpec {
  bool show = true;
  int columns = 70;  ///< of the pile, periodic; all are shown
  int layers = 60;   ///< shown; bottom_margin more are computed, so that the shown ones follow the bulk law
  double mu = 0.1;
  std::uint64_t sample = 0;  ///< of the experiment's seed
  /// 134 mm wide, with text of 8 pt. Its window is ignored: columns and layers above say what is shown.
  SceneSpec scene{.width_px = 1580, .dpi = 300, .window = {}, .range = {}};
  bool weight = false;    ///< also the weights of the same pile's beads
  bool friction = false;  ///< also how much of its friction each contact uses
  bool response = true;   ///< also how they change with the overload, every bead keeping its random number

  /// Of the other pictures of that pile: at most 57 mm wide, since two share a row of the printed report.
  SceneSpec scene_beside() const {
    SceneSpec beside = scene;
    beside.width_px = std::min(scene.width_px, static_cast<int>(2.25 * scene.dpi));
    return beside;
  }

  /// Saturates: what is absurd is refused, but only after it has been looked at.
  int computed_layers() const {
    return std::min(layers, std::numeric_limits<int>::max() - bottom_margin) + bottom_margin;
  }
};

/// What differs from main ensemble to main ensemble.
struct ScanSpec {
  std::string parameter;  ///< ScanParameter::name; empty: the usual one of the model
  std::vector<double>
      values;  ///< ascending, no duplicates; none: MainLine::mu of beads, else what the model itself says
};

/// What every experiment measures, and what a study may go by: the main ensembles, their fits and claims, and the pile
/// that is shown. The defaults are the paper's numbers.
struct MainLine {
  LatticeSpec lattice;
  std::vector<double> mu{0.0, 0.1, 0.2, 0.3};  ///< friction coefficients, ascending, no duplicates
  SamplerSpec sampling;                        ///< its mu is ignored: see sampler_at
  ScanSpec scan;                               ///< of friction it is empty: mu has its values
  ResponseSpec response;
  FitSpec fit;
  PrecisionSpec precision;
  ClaimSpec claims;
  ForceChainSpec force_chains;

  /// Throws InputError if the scan names a parameter on which the piles do not depend.
  const ScanParameter& scanned() const;
  /// Of each main ensemble, ascending.
  std::vector<double> scan_values() const;
  /// The value that figures of a single one show: the nearest to `wanted`, but the last of another parameter than
  /// friction that does not have it.
  double shown_value(double wanted) const;
  /// The sampler's parameters at one value of what is scanned.
  SamplerSpec sampler_at(double value) const;

  /// Those of beads at one friction coefficient, whatever the model is.
  SamplerSpec sampler_for(double friction) const {
    SamplerSpec spec = sampling;
    spec.model = {};
    spec.mu = friction;
    return spec;
  }

  /// An ensemble of the main line's sampler, overload and blocks.
  EnsembleSpec ensemble_at(double friction, LatticeSpec size, std::uint64_t samples) const;

  /// Uniformly loaded piles of a law as it is by default, whatever the main ensembles are drawn by; every layer
  /// recorded.
  EnsembleSpec uniform_piles(Law law, double friction, LatticeSpec size, std::uint64_t samples) const;
};

/// One of the small ensembles that a study measures.
struct StudyEnsemble {
  std::string label;  ///< "small friction, mu = 0.1", in messages and timings
  std::string file;   ///< name of its file in ensembles/, without .h5
  EnsembleSpec spec;
  int part = 0;          ///< which of the study's measurements it is for: the study's own numbers
  double effective = 0;  ///< not 0: drawn until it is worth so many independent piles, the samples of spec at most
};

/// Whether the experiment says nothing of the key of this path, so that its value follows from others.
using IsOpen = std::function<bool(const std::string&)>;

/// What an experiment measures beside its main line, all of it in one place: the keys that ask for it, the ensembles it
/// needs, the numbers, and how the report tells them. Sampling, resuming, memory and time are left to the pipeline,
/// which sees the ensembles only. A study holds its settings and, once it is measured, its results.
class Study {
 public:
  Study() = default;
  virtual ~Study() = default;
  virtual std::unique_ptr<Study> clone() const = 0;

  virtual std::string id() const = 0;  ///< "some_words": the name of its table of keys and of its templates
  /// Its keys, bound to this object.
  virtual std::vector<Key> keys() = 0;
  /// Whether the experiment asks for it. What is not asked for is checked for its ranges only.
  virtual bool asked() const = 0;
  /// Whether it is made for contacts at any angle; others are refused beside a main line at another than 30 degrees.
  virtual bool suits_any_angle() const { return false; }
  /// Gives its open keys, and those of the main line that it depends on, what follows from the others: by itself as
  /// many samples as there are blocks to fill, and no more blocks than its samples fill.
  virtual void derive(MainLine&, const IsOpen&);
  /// What the ranges of the keys do not tell: rules across keys, those of the main line included.
  virtual Problem find_problem(const MainLine&) const { return {}; }
  /// What it needs, in the order in which it is drawn.
  virtual std::vector<StudyEnsemble> ensembles(const MainLine&) const { return {}; }
  /// What it draws beside these ensembles in finish(): bytes that this needs at once, and seconds of one core.
  virtual double memory() const { return 0; }
  virtual double seconds() const { return 0; }

  /// Looks at one of the main ensembles, each once and in their order, before begin(). Not called where it is not asked
  /// for.
  virtual void add_main(const MainLine&, const MeasuredEnsemble&) {}
  /// Begins to measure; `threads`: 0 for as many as the machine has. No result depends on it.
  void begin(const MainLine& main, int threads) {
    main_ = main;
    threads_ = threads;
    prepare();
  }
  /// Takes one of its ensembles, each once and in their order.
  virtual void add(const StudyEnsemble&, const MeasuredEnsemble&) {}
  /// All ensembles are there.
  virtual void finish() {}

  /// c and D as it reads them, beside the slopes of the main line, in figures and on page 1.
  virtual std::vector<OtherReading> readings() const { return {}; }
  /// The claims of the paper that it decides; not tested, with what to ask for, where nothing is measured.
  virtual std::vector<Claim> claims(const ClaimSpec&) const { return {}; }
  /// Its results: what stands at /studies/<id> of summary.json.
  virtual Json json() const = 0;
  /// Its parts of the report, in reading order: templates/studies/<id>.html and its tables.
  virtual std::vector<ReportPart> parts() const { return {}; }
  /// Its figures, in reading order; `main`: what the main line found. The analysis outlives them.
  virtual std::vector<FigurePlot> figures([[maybe_unused]] const Analysis& main) const { return {}; }

 protected:
  Study(const Study&) = default;
  Study& operator=(const Study&) = default;

  /// What it does in begin(), from where on main_ and threads_ are those of the run.
  virtual void prepare() {}

  /// The table of its keys: "studies.<id>".
  std::string table() const { return "studies." + id(); }
  /// "studies.<id>.<name>".
  std::string key(const std::string& name) const { return table() + "." + name; }
  /// The part templates/studies/<id>.html of a study whose results are a list; left out where that is empty.
  ReportPart part(ReportPart::Place place = ReportPart::Place::numbers) const {
    return {.page = "studies/" + id() + ".html", .base = "/studies", .needs = id(), .place = place};
  }
  /// The same where it is nothing but the table templates/studies/<id>.table.
  ReportPart table_part() const { return {.page = "studies/" + id() + ".table", .base = "/studies", .needs = id()}; }
  /// The sentences templates/studies/<id>.page_1.html of page 1, over all studies.
  ReportPart page_1(Json overlay) const {
    return {.page = "studies/" + id() + ".page_1.html",
            .base = "/studies",
            .needs = id(),
            .place = ReportPart::Place::page_1,
            .overlay = std::move(overlay)};
  }
  /// Figures of results, each by a function of them and of the run's folder; none where there are none.
  template <class Results, class... Plots>
  static std::vector<FigurePlot> figures_of(const Results& results, Plots... plots) {
    if (results.empty()) return {};
    return {[&results, plots](const fs::path& folder) { return plots(results, folder); }...};
  }
  /// The part templates/studies/<page>.html over the results, left out where these have nothing named `needs`.
  ReportPart part(const std::string& page, const std::string& needs) const {
    return {.page = "studies/" + page + ".html", .base = "/studies/" + id(), .needs = needs};
  }

  MainLine main_;
  int threads_ = 0;
};

/// Copies of a study are made by its own type.
template <class Derived>
class CopiedStudy : public Study {
 public:
  std::unique_ptr<Study> clone() const override {
    return std::make_unique<Derived>(static_cast<const Derived&>(*this));
  }
};

/// Places of summary.json for an enumeration in a template, each with what to write behind it: "{{joint}}".
Json enumerated(const std::vector<std::string>& pointers);

/// All studies that there are, in the order of the report, with their settings: a value, which copies what it holds.
class Studies {
 public:
  Studies();
  Studies(const Studies& other);
  Studies& operator=(const Studies& other);
  Studies(Studies&&) = default;
  Studies& operator=(Studies&&) = default;

  auto begin() { return all_.begin(); }
  auto end() { return all_.end(); }
  auto begin() const { return all_.begin(); }
  auto end() const { return all_.end(); }

  /// The ensembles of all that are asked for, in their order.
  std::vector<StudyEnsemble> ensembles(const MainLine& main) const;

 private:
  std::vector<std::unique_ptr<Study>> all_;
};

// Limits that no sensible experiment meets; beyond them a slip of the keyboard is more likely than an intention.
inline constexpr double most_memory = 32e9;  // bytes
inline constexpr std::size_t most_friction_values = 1000;
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
