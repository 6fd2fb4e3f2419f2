#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "model/pile.h"
#include "sampling/random_key.h"
#include "sampling/sampler.h"

namespace granuscope {
/// Which contacts of a pile are opened, by their numbers: contact k < beads leads from bead k (Lattice::index) to its
/// lower-right neighbour, contact beads + k to its lower-left one. Shape [2 beads].
using OpenedContacts = std::vector<std::uint8_t>;

/// How far each contact is inside its friction cone: low = N + T/mu, high = N - T/mu, in loads of one top bead. Both
/// are at least 0 inside the cone, and in a frictionless pile of uniform load 1/sqrt 3. Shape [2 beads] each; an opened
/// contact has 0.
struct ContactSlacks {
  std::vector<double> low, high;
};

/// What a contact's slacks add to one balance.
struct BalanceTerm {
  std::size_t equation;  ///< 3 bead: vertical, + 1: horizontal, + 2: torque balance
  double of_low, of_high;
};

/// The balances of all beads as linear equations in the slacks: two unknowns for each closed contact, three equations
/// for each bead (model/audit.cc has the same in N and T). The top is loaded vertically through the centres; the bottom
/// rests on a floor that bears everything.
class ContactBalances {
 public:
  /// Throws InputError if mu is 0 or out of range.
  ContactBalances(double mu, const Lattice& lattice);

  const Lattice& lattice() const { return lattice_; }
  double mu() const { return mu_; }
  std::size_t contacts() const { return 2 * lattice_.beads(); }
  std::size_t equations() const { return 3 * lattice_.beads(); }
  /// Of the bead that it leads from, and of the one that it leads to unless that is the floor.
  std::span<const BalanceTerm> terms(std::size_t contact) const {
    return {terms_.data() + first_[contact], first_[contact + 1] - first_[contact]};
  }
  /// What the terms of an equation add up to under a load of shape [columns].
  double right_side(std::size_t equation, std::span<const double> load) const {
    return equation % 3 == 0 && equation / 3 < load.size() ? -load[equation / 3] : 0;
  }
  /// Its forces into a pile of this lattice; the load is the caller's.
  void store(const ContactSlacks& slacks, Pile& pile) const;

 private:
  Lattice lattice_;
  double mu_;
  std::vector<BalanceTerm> terms_;
  std::vector<std::size_t> first_;
};

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

/// By how much the slacks of one contact change along a direction.
struct SlackChange {
  std::size_t contact;
  double low, high;
};
using NullDirection = std::vector<SlackChange>;

/// Directions in which the slacks of a pile can change so that every balance still holds: together they span all of
/// them, and most are short. They are found region by region, by elimination within each: rhombi of 3 x 3 beads and
/// more along the lines of contacts (the smallest hold the null moves of polytope.h), rings of one and more
/// layers, and at last the whole pile. A region adds what its smaller ones have not found.
std::vector<NullDirection> find_null_directions(const ContactBalances& balances, const OpenedContacts& opened);

/// Layers at the top whose contacts are never opened: under a load through its centre a top bead needs both.
inline constexpr int undiluted_layers = 1;

/// Contacts below the undiluted layers in random order, each with its uniform number: a share q of them, each by
/// itself, are those of numbers below q.
struct RandomContact {
  double number;
  std::size_t contact;
};
std::vector<RandomContact> contacts_in_random_order(const Lattice& lattice, RandomKey key);

/// Each contact opened with probability `share`, whether or not a solution is left.
OpenedContacts open_at_random(const Lattice& lattice, double share, RandomKey key);

/// Contacts opened in random order, each only if the pile stays solvable under every one of the loads with all closed
/// contacts at least `least_slack` inside their cones (diluted_beads.h).
struct OpenedStepwise {
  OpenedContacts opened;
  std::size_t count = 0;  ///< how many
  bool complete = false;  ///< as many as asked for; false: every other contact was tried
};
OpenedStepwise open_while_solvable(const ContactBalances& balances, const std::vector<std::vector<double>>& loads,
                                   double share, double least_slack, RandomKey key);

/// Hit-and-run: one after the other, each null direction is followed to a point that is uniform on the segment inside
/// all cones. The law is the flat one on all solutions, that of the law polytope with lambda = 0.
class FlatWalk {
 public:
  /// Starts from slacks that solve the balances. The directions must outlive it.
  FlatWalk(ContactSlacks start, const std::vector<NullDirection>& directions)
      : slacks_(std::move(start)), directions_(directions) {}
  /// One move along each direction; uniform(number of the direction) is in [0, 1).
  template <class Uniform>
  void sweep(const Uniform& uniform) {
    for (std::size_t d = 0; d < directions_.size(); ++d) move(directions_[d], uniform(d));
  }
  const ContactSlacks& slacks() const { return slacks_; }
  std::size_t directions() const { return directions_.size(); }

 private:
  void move(const NullDirection& direction, double uniform);

  ContactSlacks slacks_;
  const std::vector<NullDirection>& directions_;
};

/// The model "diluted-beads": beads of which a share of the contacts is opened and bears no force. Contacts are opened
/// one after the other in random order, each only if the pile stays solvable; the forces are then drawn by a FlatWalk
/// that starts where the largest common slack is. What shapes it:
///
///  1. eight consecutive samples have the same opened contacts, and under one load the same walk;
///  2. a pile must stay solvable under its load and under the opposite one (every overload an underload), so that the
///     sign of a variation does not choose the contacts: what is even in it is no response;
///  3. the walk makes burn_in_sweeps() sweeps before the first of eight piles and thinning_sweeps() between them.
///
/// A pile fails by name where fewer contacts can be opened than asked for.
class DilutedBeadsSampler final : public Sampler {
 public:
  DilutedBeadsSampler(const SamplerSpec& spec, const Lattice& lattice);
  std::optional<SamplingFailure> draw(std::uint64_t sample, std::span<const double> load, Pile& pile) override;

  /// Of the walk of one group under one load, in bytes.
  static double memory(const Lattice& lattice);

 private:
  bool begin_walk(std::uint64_t group, std::span<const double> load);
  void run(std::uint64_t sweeps);
  /// The slowest wave of the weights is forgotten in a sweep per bead or two.
  std::uint64_t thinning_sweeps() const { return lattice_.beads(); }
  std::uint64_t burn_in_sweeps() const { return 8 * lattice_.beads(); }

  SamplerSpec spec_;
  ContactBalances balances_;

  // The contacts opened last: those of a group and a load, or of its opposite.
  std::optional<std::uint64_t> opened_group_;
  std::vector<std::vector<double>> opened_loads_;
  OpenedStepwise opened_;
  // Those that the directions are of: both loads of a group have the same, and so have all without opened contacts.
  OpenedContacts directions_of_;
  std::vector<NullDirection> directions_;

  // Where the walk stands.
  std::optional<std::uint64_t> walk_group_;
  std::vector<double> load_;
  std::optional<FlatWalk> walk_;
  std::uint64_t in_group_ = 0;  ///< number of the group's sample it has reached
  RandomKey key_{0, 0};
  std::uint32_t sweeps_ = 0;
};

}  // namespace granuscope
