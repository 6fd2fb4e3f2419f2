#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "history/nightly.h"
#include "support/number_format.h"

namespace granuscope {
namespace {

constexpr double edge = 3, edge_width = 1;  // standard errors

template <class Item, class Is>
const Item* find(const std::vector<Item>& items, Is is) {
  const auto found = std::find_if(items.begin(), items.end(), is);
  return found == items.end() ? nullptr : &*found;
}

const NightVerdict* verdict_of(const Night& night, const std::string& claim) {
  return find(night.verdicts, [&](const NightVerdict& one) { return one.claim == claim; });
}

/// A growing pool decides more and more; only from one decision to the other is a change of what was found.
bool decides(const NightVerdict& one) {
  return (one.verdict == "reproduced" || one.verdict == "not reproduced") && !at_the_edge(one.z);
}

/// What the nights before, but for the last `skipped` ones, had decided; null if nothing.
const NightVerdict* last_decided(const std::vector<Night>& before, const std::string& claim, std::size_t skipped) {
  for (std::size_t i = before.size(); i > skipped; --i) {
    const NightVerdict* one = verdict_of(before[i - 1 - skipped], claim);
    if (one != nullptr && decides(*one)) return one;
  }
  return nullptr;
}

}  // namespace

bool at_the_edge(double z) { return std::isfinite(z) && std::abs(std::abs(z) - edge) <= edge_width; }

void add_soft_alarms(Night& tonight, const std::vector<Night>& before) {
  const Night* last = before.empty() ? nullptr : &before.back();
  for (const NightNumber& number : tonight.numbers) {
    if (!number.moved) continue;
    const NightNumber* then =
        last == nullptr ? nullptr
                        : find(last->numbers, [&](const NightNumber& one) { return one.name == number.name; });
    const bool again = then != nullptr && then->moved;
    tonight.alarms.push_back(
        {"number",
         fmt::format("{} of tonight's piles is {}, {} standard errors from the pool's {}{}", number.name,
                     value_with_error(number.piece, number.piece_error), significant(number.z, 2),
                     value_with_error(number.pool.value, number.pool.standard_error),
                     again ? "; it moved the night before, too" : ""),
         again ? "open" : "watched"});
  }
  for (const NightVerdict& now : tonight.verdicts) {
    if (!decides(now)) continue;
    const NightVerdict* then = last == nullptr ? nullptr : verdict_of(*last, now.claim);
    const NightVerdict* settled =
        last_decided(before, now.claim, then == nullptr || then->verdict != now.verdict ? 0 : 1);
    if (settled == nullptr || settled->verdict == now.verdict) continue;
    const bool again = then != nullptr && then->verdict == now.verdict && decides(*then);
    tonight.alarms.push_back({"verdict",
                              fmt::format("{}: {}{} where it was {}", now.claim, now.verdict,
                                          again ? " for two nights now" : "", settled->verdict),
                              again ? "open" : "watched"});
  }
}

}  // namespace granuscope
