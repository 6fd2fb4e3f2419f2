#include "sampling/sampler_spec.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/lattice.h"
#include "support/plain_text.h"

namespace granuscope {
namespace {

constexpr Names<Law, all_laws.size()> law_names{{{Law::granusolve, "granusolve"},
                                                 {Law::eloy_clement, "eloy-clement"},
                                                 {Law::rejection, "rejection"},
                                                 {Law::polytope, "polytope"}}};
constexpr Names<LayerOrder, 3> order_names{
    {{LayerOrder::random, "random"}, {LayerOrder::rightwards, "rightwards"}, {LayerOrder::fixed, "fixed"}}};
constexpr Names<DrawnVariable, 3> drawn_names{
    {{DrawnVariable::force, "force"}, {DrawnVariable::angle, "angle"}, {DrawnVariable::ratio, "ratio"}}};
constexpr Names<RepairRules, 4> rules_names{{{RepairRules::all, "all"},
                                             {RepairRules::no_pair, "no-pair"},
                                             {RepairRules::no_arcs, "no-arcs"},
                                             {RepairRules::backtrack_only, "backtrack-only"}}};

/// Whether friction bears loads on this line. Their torque returns in the second layer with the other sign, and what
/// its mean bead cannot bear some bead cannot: admissible forces form a convex cone. Of the loads alone, so that it
/// holds for loads of any size: a bead's own weight acts through its centre and makes it easier.
bool bears(const FrictionCone& cone, const LoadLine& line) {
  if (std::isnan(line.offset)) return false;
  for (const double offset : {line.offset, -line.offset}) {
    const Incoming in = top_load(1, {line.slope, offset});
    const Outgoing out = balance(cone, in);
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
  if ((spec.load_angle != 0 || spec.load_offset != 0) && !spec.model.is_beads()) {
    return problem("load_angle",
                   "the model {} has upright loads through the centres only; leave load_angle and load_offset at 0",
                   name_of(spec.model.name));
  }
  // Without an offset the load is borne at any friction, and rounding has no say in that; mu is checked elsewhere.
  if (spec.lean_excess && spec.load_angle == 0 && spec.load_offset == 0) {
    return problem("lean_excess", "nothing leans; give load_angle or load_offset, too");
  }
  if (spec.load_offset == 0 || spec.lean_excess || !(spec.mu >= 0 && spec.mu < sqrt3)) return {};
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
std::string name_of(DrawnVariable drawn) { return name_in(drawn_names, drawn); }

std::string law_of(const SamplerSpec& spec) { return spec.model.is_beads() ? name_of(spec.law) : law_of(spec.model); }

Law law_named(const std::string& name) { return named_in(law_names, name, "law"); }
RepairRules repair_rules_named(const std::string& name) { return named_in(rules_names, name, "set of repair rules"); }

std::vector<Key> keys_of(SamplerSpec& spec) {
  const std::string table = "sampling";
  const std::string polytope = name_of(Law::polytope);
  return {
      make_name_key(
          table, "law",
          "what a random pile means: granusolve, polytope (small piles), or eloy-clement and rejection (tiny piles)",
          spec.law, law_named),
      make_key(table, "seed", "", "together with the sample's number the key of every random number", spec.seed,
               KeyRange{.least = 0}),
      make_key(table, "load_angle", "degrees",
               "of the load on every top bead from the vertical, to the right > 0: a tilted pile; responses are still "
               "averaged over mirror images",
               spec.load_angle,
               KeyRange{.why = "at 30 degrees a load points along a contact, and the other one bears nothing"}
                   .above(-load_angle_limit)
                   .below(load_angle_limit)),
      make_key(table, "load_offset", "bead radii",
               "how far to the right of their centres the loads act on the top beads: a torque, handed down with "
               "alternating sign",
               spec.load_offset, KeyRange{}.within(-2, 2)),
      make_key(table, "lean_excess", "",
               "load_angle and load_offset are of what each load has beyond 1 alone: responses below upright piles to "
               "a load that leans, or to a torque; how far friction bears that is not checked",
               spec.lean_excess),
      make_key(table, "bead_weight", "loads of one top bead",
               "of every bead by itself: gravity, so that the mean weight grows with depth; responses are those to a "
               "load at the top, as without it",
               spec.bead_weight,
               KeyRange{.why = "gravity points down, and beside beads so heavy the loads would be lost"}.within(
                   0, most_bead_weight)),
      make_key(
          table, "effort", "solutions per bead",
          "granusolve, eloy-clement: a pile counts as failed, by name, after this many bead solutions per bead",
          spec.effort,
          KeyRange{.why = "each bead is solved at least once, and every pile must end (200 is plenty)"}.within(1, 1e9)),
      make_key(table, "max_tries", "piles", "rejection: a pile counts as failed, by name, after this many tries",
               spec.max_tries,
               KeyRange{.why = "every pile needs one, and a key of the random numbers counts no more"}.within(
                   1, most_tries)),
      make_key(
          table, "lambda", "",
          "polytope: piles have the density of the product of length^-lambda over the intervals of all beads; 0 is the "
          "flat measure, 1 the law rejection",
          spec.lambda, KeyRange{.why = "only what lies between these two is a law"}.within(0, 1))
          .only_under("law", {polytope}),
      make_key(
          table, "burn_in", "sweeps",
          "polytope: from the start of a chain to the first of its eight piles; 0: four times the autocorrelation time "
          "that a pilot chain measures",
          spec.burn_in, KeyRange{.why = "a chain counts no more sweeps"}.within(0, most_sweeps))
          .only_under("law", {polytope}),
      make_key(table, "thinning", "sweeps",
               "polytope: from one of the eight piles of a chain to the next; 0: half that time", spec.thinning,
               KeyRange{.why = "a chain counts no more sweeps"}.within(0, most_sweeps))
          .only_under("law", {polytope}),
      make_name_key(
          table, "layer_order",
          "random start and direction in each layer, rightwards from a random start, or fixed (both break the mirror "
          "symmetry: for comparison only)",
          spec.order, order_names, "layer order"),
      make_name_key(
          table, "drawn",
          "granusolve: what each bead draws uniformly: a force, or the angle or T/N (ratio) of one of its two "
          "lower contacts, each half of the time (other laws, several times slower)",
          spec.drawn, drawn_names, "drawn variable")
          .only_under("law", {name_of(Law::granusolve)}),
      make_name_key(table, "repair_rules",
                    "granusolve: all, or without some of the rules that repair a failing bead (no-pair, no-arcs, "
                    "backtrack-only: other laws, for comparison only)",
                    spec.rules, repair_rules_named)
          .only_under("law", {name_of(Law::granusolve)}),
  };
}

Problem find_problem(const SamplerSpec& spec) {
  SamplerSpec copy = spec, usual;  // keys could set what they check
  const std::vector<Key> keys = keys_of(copy);
  if (auto found = find_idle_problem(keys, keys_of(usual))) return found;
  if (auto found = find_range_problem(keys, {"seed"})) return found;
  if (auto found = find_load_problem(spec)) return found;
  if (spec.bead_weight != 0 && !spec.model.is_beads()) {
    return problem("bead_weight", "the beads of the model {} have no weight of their own; leave bead_weight at 0",
                   name_of(spec.model.name));
  }
  return {};
}

LoadLine load_line(const SamplerSpec& spec) {
  return {std::tan(spec.load_angle * std::numbers::pi / 180), spec.load_offset, spec.lean_excess};
}

bool drawn_side_by_side(const SamplerSpec& spec) {
  return spec.law == Law::granusolve && spec.rules == RepairRules::all && spec.drawn == DrawnVariable::force;
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
  throw InputError("piles of the model {} do not depend on \"{}\"; {}", name_of(spec.model.name), name,
                   known.empty() ? "leave it empty" : "choose one of: " + known);
}

namespace {

constexpr int halvings = 3;  // of an angle, to below pi / 16

/// The variable of a contact whose force leans by H over V: its angle from the vertical, or T/N.
double variable_of(DrawnVariable drawn, double leaning) {
  return drawn == DrawnVariable::angle ? portable_arctangent(leaning) : (sqrt3 * leaning - 1) / (leaning + sqrt3);
}

double leaning_of(DrawnVariable drawn, double variable) {
  return drawn == DrawnVariable::angle ? portable_tangent(variable) : (1 + sqrt3 * variable) / (sqrt3 - variable);
}

/// How fast the variable grows with the leaning.
double growth(DrawnVariable drawn, double leaning) {
  const double root = leaning + sqrt3;
  return drawn == DrawnVariable::angle ? 1 / (1 + leaning * leaning) : 4 / (root * root);
}

/// The horizontal force of a contact that carries V, its variable at fraction u of what the interval of that force
/// leaves.
double force_at(DrawnVariable drawn, double V, Interval force, double u) {
  if (!(V > 0)) return force.low;  // which is all of it
  const double low = variable_of(drawn, force.low / V), high = variable_of(drawn, force.high / V);
  return std::clamp(V * leaning_of(drawn, low + u * (high - low)), force.low, force.high);
}

/// The density of that force and the largest that it has.
struct ForceDensity {
  double here = 0, most = 0;
};
ForceDensity density_at(DrawnVariable drawn, double V, Interval force, double H) {
  const double low = force.low / V, high = force.high / V;
  const double per_force = 1 / (V * (variable_of(drawn, high) - variable_of(drawn, low)));
  const double steepest = drawn == DrawnVariable::angle ? std::clamp(0.0, low, high) : low;
  return {growth(drawn, H / V) * per_force, growth(drawn, steepest) * per_force};
}

}  // namespace

double split_at(DrawnVariable drawn, Outgoing out, double H, Interval interval, double uniform) {
  if (drawn == DrawnVariable::force || !(interval.low < interval.high)) return point_at(interval, uniform);
  // The left contact is the mirror image of a right one that carries H_R - H.
  const double split = uniform < 0.5
                           ? force_at(drawn, out.V_R, interval, 2 * uniform)
                           : H + force_at(drawn, out.V_L, {interval.low - H, interval.high - H}, 2 * uniform - 1);
  return std::clamp(split, interval.low, interval.high);
}

double kept_share(DrawnVariable drawn, Outgoing out, double H, Interval interval, double H_R) {
  if (drawn == DrawnVariable::force || !(interval.low < interval.high)) return 1;
  const ForceDensity right = density_at(drawn, out.V_R, interval, H_R);
  const ForceDensity left = density_at(drawn, out.V_L, {interval.low - H, interval.high - H}, H_R - H);
  const double share = (right.here + left.here) / (right.most + left.most);
  return std::isfinite(share) ? share : 1;  // an interval as narrow as rounding
}

double portable_arctangent(double x) {
  for (int k = 0; k < halvings; ++k) x /= 1 + std::sqrt(1 + x * x);
  const double square = x * x;  // below 0.04
  double series = 0;
  for (int power = 23; power >= 1; power -= 2) series = 1.0 / power - square * series;
  return (1 << halvings) * x * series;
}

double portable_tangent(double angle) {
  const double part = angle / (1 << halvings), square = part * part;
  double sine = 1, cosine = 1;  // their series, the former over the angle
  for (int k = 16; k >= 2; k -= 2) {
    sine = 1 - square * sine / (k * (k + 1));
    cosine = 1 - square * cosine / (k * (k - 1));
  }
  double tangent = part * sine / cosine;
  for (int k = 0; k < halvings; ++k) tangent = 2 * tangent / (1 - tangent * tangent);
  return tangent;
}

}  // namespace granuscope
