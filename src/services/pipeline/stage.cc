#include "pipeline/stage.h"

#include "support/error.h"

namespace granuscope {
namespace {

struct StageRule {
  Stage stage;
  const char* name;
  std::vector<Stage> needs;
};

const std::vector<StageRule>& rules() {
  static const std::vector<StageRule> all{{Stage::sample, "sample", {}},
                                          {Stage::analyse, "analyse", {Stage::sample}},
                                          {Stage::render, "render", {}},
                                          {Stage::plot, "plot", {Stage::analyse}},
                                          {Stage::report, "report", {Stage::analyse, Stage::plot, Stage::render}}};
  return all;
}

void add_with_needs(Stage stage, std::set<Stage>& into) {
  for (const StageRule& rule : rules()) {
    if (rule.stage != stage || !into.insert(stage).second) continue;
    for (Stage need : rule.needs) add_with_needs(need, into);
  }
}

}  // namespace

std::string name_of(Stage stage) {
  for (const StageRule& rule : rules()) {
    if (rule.stage == stage) return rule.name;
  }
  return {};
}

std::set<std::string> names_of(const std::set<Stage>& stages) {
  std::set<std::string> names;
  for (const Stage stage : stages) names.insert(name_of(stage));
  return names;
}

Stage stage_named(const std::string& name) {
  for (const StageRule& rule : rules()) {
    if (name == rule.name) return rule.stage;
  }
  throw InputError("there is no stage \"{}\": known are sample, analyse, render, plot and report", name);
}

std::set<Stage> stages_needed(const std::vector<Stage>& asked_for) {
  std::set<Stage> needed;
  for (Stage stage : asked_for) add_with_needs(stage, needed);
  if (asked_for.empty()) add_with_needs(Stage::report, needed);
  return needed;
}

}  // namespace granuscope
