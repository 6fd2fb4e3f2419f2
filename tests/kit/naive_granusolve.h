#pragma once
#include <cstdint>
#include <map>
#include <random>
#include <set>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "model/pile.h"

namespace granuscope::test {

/// The law "granusolve" a second time, written from its description and not from the program: forces that leave
/// nothing solvable are redrawn blindly until they do (after many failures from narrower ranges, which is the same
/// law), feasibility is decided by Bellman and Ford's algorithm on the system of difference constraints, bands are
/// found by bisection on Coulomb's cone, and nothing is drawn in bulk. Slow.
class NaiveGranusolve {
 public:
  NaiveGranusolve(Lattice lattice, double mu, std::uint64_t seed, double bead_weight = 0);

  /// Backtracks of the pile drawn last.
  int backtracks() const;
  /// Numbers that its splits took after the first of each bead, as long as nothing is drawn blindly in vain: two for a
  /// pair, one for each parent of an arc, one for each bead solved again when its layer was complete.
  int later_numbers() const { return later_numbers_; }
  /// Draws one pile; false if blind redrawing or backtracking went on for too long.
  bool draw(std::span<const double> load, Pile& pile);

 private:
  struct Bead {
    double V_R = 0, V_L = 0, H = 0, H_R = 0;
    bool solved = false;
  };
  struct Range {
    double low, high;
  };
  /// Thrown when a pile takes too long.
  struct GivenUp {};
  /// Variables x_0 .. x_{n-1} with x_to - x_from <= bound; index n stands for the number 0.
  struct Constraint {
    std::size_t from, to;
    double bound;
  };

  Bead& at(int layer, int bead) { return beads_[static_cast<std::size_t>(layer)][static_cast<std::size_t>(bead)]; }
  int wrapped(int bead) const { return ((bead % columns_) + columns_) % columns_; }
  double uniform(Range range);

  /// What a bead receives: V_UL, V_UR, H.
  std::tuple<double, double, double> received(int layer, int bead);
  Range cone_range(double V_R, double V_L, double H) const;
  bool solvable(int layer, int bead);
  /// H between which a bead that receives V_UL and V_UR is solvable.
  Range solvable_H(double V_UL, double V_UR) const;

  bool place(int layer, int bead);
  void redraw(int layer, int bead);
  void solve_pending();
  bool repair(int layer, int bead);
  bool pair(int layer, int bead);
  /// What became of an arc of parents: changed, too narrow, or infeasible however wide.
  enum class Outcome { repaired, too_narrow, infeasible };
  Outcome arc(int layer, int bead, int count);
  bool ring(int layer, int bead);
  void backtrack(int layer, int bead);
  void unsolve(int layer, int bead);

  /// Constraints on the splits of `parents` (of the layer above): own intervals, and solvability of the failed bead and
  /// of every solved child. Children that share a parent outside count with its split held, unless `free_outside`.
  std::vector<Constraint> constraints(int layer, int failed, const std::vector<int>& parents, bool free_outside);
  static bool feasible(std::size_t variables, const std::vector<Constraint>& constraints);
  /// Smallest and largest value of one variable over all solutions.
  static Range shadow(std::size_t variable, std::size_t variables, const std::vector<Constraint>& constraints);
  /// Draws the parents one after the other in the order given (indices), each uniform on what can be completed.
  void draw_one_by_one(int layer, const std::vector<int>& parents, std::vector<Constraint> constraints,
                       const std::vector<std::size_t>& order);
  void renew_children(int layer, int failed, const std::vector<int>& parents);
  void count_work();

  Lattice lattice_;
  int columns_;
  double mu_, bead_weight_, flat_, steep_;
  std::mt19937_64 engine_;
  std::vector<std::vector<Bead>> beads_;
  std::vector<int> first_, direction_;             // per layer
  std::set<std::tuple<int, int, int>> pending_;    // layer, position in its order, bead
  std::map<std::pair<int, int>, int> backtracks_;  // per bead
  std::vector<double> load_;
  std::int64_t work_ = 0;
  int front_ = 0, later_numbers_ = 0;
};

}  // namespace granuscope::test
