#pragma once
#include <optional>
#include <vector>

#include "sampling/largest_slack.h"
#include "sampling/null_directions.h"
#include "sampling/random_key.h"
#include "sampling/sampler.h"

namespace granuscope {

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
/// contacts at least `least_slack` inside their cones (largest_slack.h).
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
