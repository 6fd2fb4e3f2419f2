#include "sampling/sampler_spec.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "model/equilibrium.h"
#include "model/lattice.h"
#include "support/error.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

template <typename Choice, std::size_t count>
using Names = std::array<std::pair<Choice, const char*>, count>;

constexpr Names<Law, all_laws.size()> law_names{{{Law::granusolve, "granusolve"},
                                                 {Law::eloy_clement, "eloy-clement"},
                                                 {Law::rejection, "rejection"},
                                                 {Law::polytope, "polytope"}}};
constexpr Names<LayerOrder, 2> order_names{{{LayerOrder::random, "random"}, {LayerOrder::fixed, "fixed"}}};
constexpr Names<RepairRules, 4> rules_names{{{RepairRules::all, "all"},
                                             {RepairRules::no_pair, "no-pair"},
                                             {RepairRules::no_arcs, "no-arcs"},
                                             {RepairRules::backtrack_only, "backtrack-only"}}};

template <typename Choice, std::size_t count>
std::string name_in(const Names<Choice, count>& names, Choice choice) {
  for (const auto& [one, name] : names) {
    if (one == choice) return name;
  }
  return {};
}

/// Throws InputError if there is none of that name; `what` and `known` say of what, and which there are.
template <typename Choice, std::size_t count>
Choice named_in(const Names<Choice, count>& names, const std::string& wanted, const char* what,
                const std::string& known) {
  for (const auto& [one, name] : names) {
    if (name == wanted) return one;
  }
  throw InputError(fmt::format("there {} \"{}\": {}", what, wanted, known));
}

/// Whether friction bears loads on this line. Their torque returns in the second layer with the other sign, and what
/// its mean bead cannot bear some bead cannot: admissible forces form a convex cone. Of the loads alone, so that it
/// holds for loads of any size: a bead's own weight acts through its centre and makes it easier.
bool bears(const FrictionCone& cone, const LoadLine& line) {
  if (std::isnan(line.offset)) return false;
  for (const double offset : {line.offset, -line.offset}) {
    const Incoming in = top_load(1, {line.slope, offset});
    const Outgoing out = balance(in);
    if (unsolvable(out, split_interval(cone, out, in.H))) return false;
  }
  return true;
}

/// The largest offset of loads of this slope; 0 is borne at any.
double largest_offset(const FrictionCone& cone, double slope) {
  double borne = 0, refused = 1;
  for (int halving = 0; halving < 50; ++halving) {
    const double middle = (borne + refused) / 2;
    (bears(cone, {slope, middle}) ? borne : refused) = middle;
  }
  return borne;
}

Problem find_load_problem(const SamplerSpec& spec) {
  if (!(std::abs(spec.load_angle) < load_angle_limit)) {
    return problem(
        "load_angle",
        "a load {} degrees from the vertical cannot be borne: at {} it points along a contact, and the other "
        "one bears nothing; give an angle between -{} and {}",
        spec.load_angle, load_angle_limit, load_angle_limit, load_angle_limit);
  }
  if ((spec.load_angle != 0 || spec.load_offset != 0) && !spec.model.is_beads()) {
    return problem("load_angle",
                   "the model {} has upright loads through the centres only; leave load_angle and load_offset at 0",
                   name_of(spec.model.name));
  }
  // Without an offset the load is borne at any friction, and rounding has no say in that; mu is checked elsewhere.
  if (spec.load_offset == 0 || !(spec.mu >= 0 && spec.mu < sqrt3)) return {};
  const FrictionCone cone(spec.mu);
  const LoadLine line = load_line(spec);
  if (bears(cone, line)) return {};
  constexpr double rounded_down = 1 - 5e-4;  // to four digits
  return problem("load_offset",
                 "a load that acts {} bead radii beside the centres, {} degrees from the vertical, cannot be borne: "
                 "friction holds beads only up to {:.4g} to either side at mu = {} and this angle, since the torque "
                 "changes its sign from layer to layer; give less",
                 spec.load_offset, spec.load_angle, rounded_down * largest_offset(cone, line.slope), spec.mu);
}

}  // namespace

std::string name_of(Law law) { return name_in(law_names, law); }
std::string name_of(LayerOrder order) { return name_in(order_names, order); }
std::string name_of(RepairRules rules) { return name_in(rules_names, rules); }

std::string law_of(const SamplerSpec& spec) { return spec.model.is_beads() ? name_of(spec.law) : law_of(spec.model); }

std::string names_of_laws() {
  std::string names;
  for (std::size_t k = 0; k < all_laws.size(); ++k) {
    names += (k == 0 ? "" : k + 1 == all_laws.size() ? " and " : ", ") + name_of(all_laws[k]);
  }
  return names;
}

Law law_named(const std::string& name) {
  return named_in(law_names, name, "is no law", "known are " + names_of_laws());
}

LayerOrder layer_order_named(const std::string& name) {
  return named_in(order_names, name, "is no layer order", R"(write "random" or "fixed")");
}

RepairRules repair_rules_named(const std::string& name) {
  return named_in(rules_names, name, "are no repair rules", R"(write "all", "no-pair", "no-arcs" or "backtrack-only")");
}

Problem find_problem(const SamplerSpec& spec) {
  if (!(spec.effort >= least_effort && spec.effort <= most_effort)) {
    return problem("effort",
                   "{} solutions per bead cannot work: each bead is solved at least once, and "
                   "every pile must end; give {} to {} (200 is plenty)",
                   spec.effort, least_effort, most_effort);
  }
  if (spec.max_tries < 1 || spec.max_tries > most_tries) {
    return problem(
        "max_tries",
        "{} tries cannot work: every pile needs one, and a key of the random numbers counts no more than {}; "
        "give 1 to {}",
        spec.max_tries, most_tries, most_tries);
  }
  if (!(spec.lambda >= 0 && spec.lambda <= 1)) {
    return problem("lambda",
                   "{} is no exponent of the law polytope: 0 is the flat measure, 1 the law rejection, and only "
                   "what lies between is a law; give 0 to 1",
                   spec.lambda);
  }
  if (auto found = find_load_problem(spec)) return found;
  if (!(spec.bead_weight >= 0 && spec.bead_weight <= most_bead_weight)) {
    return problem("bead_weight",
                   "beads cannot weigh {} loads of one top bead: gravity points down, and beside so much the loads "
                   "would be lost; give 0 to {}",
                   spec.bead_weight, most_bead_weight);
  }
  if (spec.bead_weight != 0 && !spec.model.is_beads()) {
    return problem("bead_weight", "the beads of the model {} have no weight of their own; leave bead_weight at 0",
                   name_of(spec.model.name));
  }
  const SamplerSpec usual;
  if (spec.law != Law::polytope &&
      (spec.lambda != usual.lambda || spec.burn_in != usual.burn_in || spec.thinning != usual.thinning)) {
    return problem("law",
                   "lambda, burn_in and thinning belong to the law polytope and would change nothing under {}; "
                   "leave them out, or choose that law",
                   name_of(spec.law));
  }
  if (spec.law != Law::granusolve && spec.rules != usual.rules) {
    return problem("repair_rules",
                   "the repair rules {} belong to the law granusolve and would change nothing under {}; leave "
                   "them out, or choose that law",
                   name_of(spec.rules), name_of(spec.law));
  }
  if (spec.burn_in > most_sweeps || spec.thinning > most_sweeps) {
    return problem(spec.burn_in > most_sweeps ? "burn_in" : "thinning",
                   "a chain counts no more than {} sweeps; give fewer, or 0 to have them measured", most_sweeps);
  }
  return {};
}

LoadLine load_line(const SamplerSpec& spec) {
  return {std::tan(spec.load_angle * std::numbers::pi / 180), spec.load_offset};
}

void validate(const SamplerSpec& spec) { refuse(find_problem(spec)); }

namespace {

std::vector<ScanParameter> all_parameters() {
  std::vector<ScanParameter> all = {
      {"mu", "μ", "friction coefficient", [](const SamplerSpec& spec) { return spec.model.has_contacts(); },
       [](SamplerSpec& spec) -> double& { return spec.mu; }},
      {"lambda", "λ", "power of the intervals",
       [](const SamplerSpec& spec) { return spec.model.is_beads() && spec.law == Law::polytope; },
       [](SamplerSpec& spec) -> double& { return spec.lambda; }},
      {"bead_weight", "g", "weight of a bead", [](const SamplerSpec& spec) { return spec.model.is_beads(); },
       [](SamplerSpec& spec) -> double& { return spec.bead_weight; }}};
  for (const ModelParameter& one : model_parameters()) {
    all.push_back({one.name, one.symbol, one.meaning,
                   [&one](const SamplerSpec& spec) { return one.belongs_to(spec.model); },
                   [&one](SamplerSpec& spec) -> double& { return one.in(spec.model); }});
  }
  return all;
}

/// Those of beads first.
const std::vector<ScanParameter>& parameters() {
  static const std::vector<ScanParameter> all = all_parameters();
  return all;
}

}  // namespace

std::string ScanParameter::at(const SamplerSpec& spec) const {
  return fmt::format("{} = {}", symbol, exact(value(spec)));
}

std::string ScanParameter::file_part(const SamplerSpec& spec) const {
  return fmt::format("{}-{}", name, exact(value(spec)));
}

const ScanParameter& friction_parameter() { return parameters().front(); }

const ScanParameter& usual_parameter(const SamplerSpec& spec) {
  const auto of_model = std::find_if(parameters().begin(), parameters().end(), [&](const ScanParameter& one) {
    return &one != &friction_parameter() && one.belongs_to(spec);
  });
  return spec.model.is_beads() || of_model == parameters().end() ? friction_parameter() : *of_model;
}

const ScanParameter& scan_parameter_named(const std::string& name, const SamplerSpec& spec) {
  std::string known;
  for (const ScanParameter& one : parameters()) {
    if (!one.belongs_to(spec)) continue;
    if (one.name == name) return one;
    known += (known.empty() ? "" : ", ") + one.name;
  }
  throw InputError(fmt::format("piles of the model {} do not depend on \"{}\"; {}", name_of(spec.model.name), name,
                               known.empty() ? "leave it empty" : "choose one of: " + known));
}

std::vector<std::string> names_of_scan_parameters() {
  std::vector<std::string> names;
  for (const ScanParameter& one : parameters()) names.push_back(fmt::format("{} ({})", one.name, one.meaning));
  return names;
}

}  // namespace granuscope
