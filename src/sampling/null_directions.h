#pragma once
#include <vector>

#include "sampling/contact_slacks.h"

namespace granuscope {

/// By how much the slacks of one contact change along a direction.
struct SlackChange {
  std::size_t contact;
  double low, high;
};
using NullDirection = std::vector<SlackChange>;

/// Directions in which the slacks of a pile can change so that every balance still holds: together they span all of
/// them, and most are short. They are found region by region, by elimination within each: rhombi of 3 x 3 beads and
/// more along the lines of contacts (the smallest hold the null moves of polytope_chain.h), rings of one and more
/// layers, and at last the whole pile. A region adds what its smaller ones have not found.
std::vector<NullDirection> find_null_directions(const ContactBalances& balances, const OpenedContacts& opened);

}  // namespace granuscope
