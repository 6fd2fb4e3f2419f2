#pragma once
#include <memory>
#include <optional>
#include <span>

#include "sampling/contact_slacks.h"

namespace granuscope {

/// How much room the balances leave a pile inside its friction cones.
enum class Solvability {
  inside,   ///< some solution has every closed contact strictly inside its cone
  edge,     ///< every solution has a contact at the edge of its cone: one that slides, or that bears nothing
  nowhere,  ///< no solution inside the cones
};

struct LargestSlack {
  Solvability solvability = Solvability::nowhere;
  double slack = 0;      ///< the largest that all closed contacts have at once; below 0 if nowhere, NaN if unbalanced
  ContactSlacks slacks;  ///< of a solution that has it, if inside or edge
};

/// By linear programming: the largest s for which all balances hold and each closed contact has N - |T|/mu >= s, in
/// loads of one top bead whatever the size of the pile. (The smallest of more contacts is smaller: s falls with size.)
LargestSlack find_largest_slack(const ContactBalances& balances, const OpenedContacts& opened,
                                std::span<const double> load);

/// Slacks that are 0 but for rounding.
inline constexpr double slack_tolerance = 1e-7;

/// Opens the contacts of one pile one after the other, as long as a solution is left in which every closed contact has
/// at least a certain slack.
class StepwiseOpening {
 public:
  StepwiseOpening(const ContactBalances& balances, std::span<const double> load, double least_slack);
  StepwiseOpening(StepwiseOpening&&) noexcept;
  ~StepwiseOpening();

  /// Whether there is such a solution now.
  bool solvable();
  /// From now on; the latter undoes the former.
  void open(std::size_t contact);
  void close(std::size_t contact);

 private:
  class Programme;
  std::unique_ptr<Programme> programme_;
  double least_slack_;
};

}  // namespace granuscope
