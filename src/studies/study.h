#pragma once
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "analysis/results.h"
#include "analysis/transport.h"
#include "plot/figure.h"
#include "report/report_part.h"
#include "studies/main_line.h"
#include "support/key.h"

namespace granuscope {

/// One of the small ensembles that a study measures.
struct StudyEnsemble {
  std::string label;  ///< "small friction, mu = 0.1", in messages and timings
  std::string file;   ///< name of its file in ensembles/, without .h5
  EnsembleSpec spec;
  int part = 0;  ///< which of the study's measurements it is for: the study's own numbers
};

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
  /// What the ranges of the keys do not tell: rules across keys, those of the main line included.
  virtual Problem find_problem(const MainLine&) const { return {}; }
  /// What it needs, in the order in which it is drawn.
  virtual std::vector<StudyEnsemble> ensembles(const MainLine&) const { return {}; }
  /// What it draws beside these ensembles in finish(): bytes that this needs at once, and seconds of one core.
  virtual double memory() const { return 0; }
  virtual double seconds() const { return 0; }

  /// Begins to measure; `threads`: 0 for as many as the machine has. No result depends on it.
  virtual void begin(const MainLine&, [[maybe_unused]] int threads) {}
  /// Takes one of its ensembles, each once and in their order.
  virtual void add(const StudyEnsemble&, const MeasuredEnsemble&) {}
  /// All ensembles are there.
  virtual void finish() {}

  /// The claims of the paper that it decides; not tested, with what to ask for, where nothing is measured.
  virtual std::vector<Claim> claims(const ClaimSpec&) const { return {}; }
  /// Its results: what stands at /studies/<id> of summary.json.
  virtual nlohmann::ordered_json json() const = 0;
  /// Its parts of the report, in reading order: templates/studies/<id>.html and its tables.
  /// `results`: what json() has returned.
  virtual std::vector<ReportPart> parts([[maybe_unused]] const nlohmann::ordered_json& results) const { return {}; }
  /// Its figures, in reading order; `main`: what the main line found. The analysis outlives them.
  virtual std::vector<FigurePlot> figures([[maybe_unused]] const Analysis& main) const { return {}; }

 protected:
  Study(const Study&) = default;
  Study& operator=(const Study&) = default;

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
  ReportPart page_1(nlohmann::ordered_json overlay) const {
    return {.page = "studies/" + id() + ".page_1.html",
            .base = "/studies",
            .needs = id(),
            .place = ReportPart::Place::page_1,
            .overlay = std::move(overlay)};
  }
  /// The part templates/studies/<page>.html over the results, left out where these have nothing named `needs`.
  ReportPart part(const std::string& page, const std::string& needs) const {
    return {.page = "studies/" + page + ".html", .base = "/studies/" + id(), .needs = needs};
  }
};

/// A list of results, each as `write` writes it.
template <class Result>
nlohmann::ordered_json list_of(const std::vector<Result>& results, nlohmann::ordered_json (*write)(const Result&)) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Result& one : results) list.push_back(write(one));
  return list;
}

/// Copies of a study are made by its own type.
template <class Derived>
class CopiedStudy : public Study {
 public:
  std::unique_ptr<Study> clone() const override {
    return std::make_unique<Derived>(static_cast<const Derived&>(*this));
  }
};

/// Places of summary.json for an enumeration in a template, each with what to write behind it: "{{joint}}".
nlohmann::ordered_json enumerated(const std::vector<std::string>& pointers);

}  // namespace granuscope
