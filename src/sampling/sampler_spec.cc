#include "sampling/sampler_spec.h"

#include <fmt/format.h>

#include <utility>

#include "support/error.h"

namespace granuscope {
namespace {

/// Solutions per bead beyond which an effort is no bound any more (nor countable in 64 bits for the largest piles).
constexpr double max_effort = 1e9;

template <typename Choice, std::size_t count>
using Names = std::array<std::pair<Choice, const char*>, count>;

constexpr Names<Law, all_laws.size()> law_names{{{Law::granusolve, "granusolve"},
                                                 {Law::eloy_clement, "eloy-clement"},
                                                 {Law::rejection, "rejection"},
                                                 {Law::polytope, "polytope"}}};
constexpr Names<LayerOrder, 2> order_names{{{LayerOrder::random, "random"}, {LayerOrder::fixed, "fixed"}}};
constexpr Names<MendingRules, 4> rules_names{{{MendingRules::all, "all"},
                                              {MendingRules::no_pair, "no-pair"},
                                              {MendingRules::no_arcs, "no-arcs"},
                                              {MendingRules::climb_only, "climb-only"}}};

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

}  // namespace

std::string name_of(Law law) { return name_in(law_names, law); }
std::string name_of(LayerOrder order) { return name_in(order_names, order); }
std::string name_of(MendingRules rules) { return name_in(rules_names, rules); }

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

MendingRules mending_rules_named(const std::string& name) {
  return named_in(rules_names, name, "are no mending rules", R"(write "all", "no-pair", "no-arcs" or "climb-only")");
}

void validate(const SamplerSpec& spec) {
  if (!(spec.effort >= 1 && spec.effort <= max_effort)) {
    throw InputError(fmt::format(
        "effort {} is out of range: a pile needs at least one solution per bead, and more than {:g} would never end",
        spec.effort, max_effort));
  }
  if (spec.max_tries < 1 || spec.max_tries > most_tries) {
    throw InputError(fmt::format("max_tries {} is out of range: use 1 to {}", spec.max_tries, most_tries));
  }
  if (!(spec.lambda >= 0 && spec.lambda <= 1)) {
    throw InputError(
        fmt::format("lambda {} is out of range: 0 is the flat measure, 1 the law rejection; use a number from 0 to 1",
                    spec.lambda));
  }
  if (spec.rules != MendingRules::all && spec.law != Law::granusolve) {
    throw InputError(fmt::format(
        "the mending rules \"{}\" belong to the law granusolve and would change nothing under {}; leave them out",
        name_of(spec.rules), name_of(spec.law)));
  }
  if (spec.burn_in > most_sweeps || spec.thinning > most_sweeps) {
    throw InputError(
        fmt::format("burn_in {} or thinning {} is out of range: a chain counts no more than {} sweeps of each; use "
                    "fewer, or 0 to have them measured",
                    spec.burn_in, spec.thinning, most_sweeps));
  }
}

}  // namespace granuscope
