#include "sampling/diluted_beads.h"

#include <glpk.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "model/equilibrium.h"
#include "model/lattice.h"
#include "support/error.h"
#include "support/progress.h"

namespace granuscope {
namespace {

constexpr std::uint64_t group_of_samples = 8;

/// The load with every difference from its mean reversed; empty where that would pull or leave a bead without load.
std::vector<double> opposite(std::span<const double> load) {
  const double mean = std::accumulate(load.begin(), load.end(), 0.0) / static_cast<double>(load.size());
  std::vector<double> reversed;
  for (const double force : load) {
    if (!(2 * mean - force > 0)) return {};
    reversed.push_back(2 * mean - force);
  }
  return reversed;
}

/// Loads between which rounding makes the difference.
bool alike(std::span<const double> a, std::span<const double> b) {
  constexpr double rounding = 1e-12;
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](double one, double other) { return std::abs(one - other) <= rounding * one; });
}

}  // namespace

std::vector<RandomContact> contacts_in_random_order(const Lattice& lattice, RandomKey key) {
  std::vector<RandomContact> contacts;
  for (int layer = undiluted_layers; layer < lattice.layers(); ++layer) {
    for (int i = 0; i < lattice.columns(); ++i) {
      const UniformPair numbers = key.attempt(layer, i, 1);
      contacts.push_back({numbers.first, lattice.index(layer, i)});
      contacts.push_back({numbers.second, lattice.beads() + lattice.index(layer, i)});
    }
  }
  std::sort(contacts.begin(), contacts.end(), [](const RandomContact& a, const RandomContact& b) {
    return a.number != b.number ? a.number < b.number : a.contact < b.contact;
  });
  return contacts;
}

OpenedContacts open_at_random(const Lattice& lattice, double share, RandomKey key) {
  OpenedContacts opened(2 * lattice.beads());
  for (const auto& [number, contact] : contacts_in_random_order(lattice, key)) opened[contact] = number < share;
  return opened;
}

OpenedStepwise open_while_solvable(const ContactBalances& balances, const std::vector<std::vector<double>>& loads,
                                   double share, double least_slack, RandomKey key) {
  const std::size_t beads = balances.lattice().beads();
  const std::vector<RandomContact> candidates = contacts_in_random_order(balances.lattice(), key);
  const auto wanted = static_cast<std::size_t>(std::round(share * static_cast<double>(candidates.size())));
  OpenedStepwise result;
  result.opened.assign(balances.contacts(), 0);
  if (wanted == 0) {
    result.complete = true;
    return result;
  }
  std::vector<StepwiseOpening> piles;
  piles.reserve(loads.size());
  for (const std::vector<double>& load : loads) piles.emplace_back(balances, load, least_slack);
  const auto all_solvable = [&] {
    return std::all_of(piles.begin(), piles.end(), [](StepwiseOpening& pile) { return pile.solvable(); });
  };
  if (!all_solvable()) return result;
  for (const RandomContact& candidate : candidates) {
    const std::size_t contact = candidate.contact;
    // Without any lower contact a bead can bear nothing.
    if (result.opened[contact < beads ? contact + beads : contact - beads] != 0) continue;
    throw_if_interrupted();
    for (StepwiseOpening& pile : piles) pile.open(contact);
    if (!all_solvable()) {
      for (StepwiseOpening& pile : piles) pile.close(contact);
      continue;
    }
    result.opened[contact] = 1;
    result.complete = ++result.count == wanted;
    if (result.complete) break;
  }
  return result;
}

void FlatWalk::move(const NullDirection& direction, double uniform) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Interval reach{-infinity, infinity};
  const auto bound = [&reach](double slack, double change) {
    if (change > 0) reach.low = std::max(reach.low, -slack / change);
    if (change < 0) reach.high = std::min(reach.high, -slack / change);
  };
  for (const SlackChange& change : direction) {
    bound(slacks_.low[change.contact], change.low);
    bound(slacks_.high[change.contact], change.high);
  }
  if (!(reach.low < reach.high)) return;  // a corner, or one that rounding has made
  const double t = point_at(reach, uniform);
  for (const SlackChange& change : direction) {
    slacks_.low[change.contact] += t * change.low;
    slacks_.high[change.contact] += t * change.high;
  }
}

DilutedBeadsSampler::DilutedBeadsSampler(const SamplerSpec& spec, const Lattice& lattice)
    : Sampler(lattice), spec_(spec), balances_(spec.mu, lattice) {}

double DilutedBeadsSampler::memory(const Lattice& lattice) {
  // The balances of the whole pile as a full matrix, solved once for each walk.
  const auto beads = static_cast<double>(lattice.beads());
  return 8 * 12 * beads * beads;
}

std::optional<SamplingFailure> DilutedBeadsSampler::draw(std::uint64_t sample, std::span<const double> load,
                                                         Pile& pile) {
  const std::uint64_t group = sample / group_of_samples, wanted = sample % group_of_samples;
  const bool same_load = std::equal(load.begin(), load.end(), load_.begin(), load_.end());
  if (!same_load || walk_group_ != group || in_group_ > wanted) {
    if (!begin_walk(group, load)) return SamplingFailure{0};
  }
  for (; in_group_ < wanted; ++in_group_) run(thinning_sweeps());
  balances_.store(walk_->slacks(), pile);
  pile.load.assign(load.begin(), load.end());
  pile.load_line = {};
  pile.law = name_of(ModelName::diluted_beads);
  pile.seed = spec_.seed;
  pile.sample = sample;
  ++counts_.tries;
  counts_.beads += lattice_.beads();
  return std::nullopt;
}

bool DilutedBeadsSampler::begin_walk(std::uint64_t group, std::span<const double> load) {
  walk_group_.reset();
  key_ = RandomKey(spec_.seed, group * group_of_samples);
  const bool known = opened_group_ == group && std::any_of(opened_loads_.begin(), opened_loads_.end(),
                                                           [&](const auto& one) { return alike(one, load); });
  if (!known) {
    opened_loads_.assign(1, {load.begin(), load.end()});
    std::vector<double> reversed = opposite(load);
    // Both in one order, whichever was asked for, so that the programmes meet the same rounding.
    if (!reversed.empty() && !alike(reversed, load)) opened_loads_.push_back(std::move(reversed));
    std::sort(opened_loads_.begin(), opened_loads_.end());
    opened_ = open_while_solvable(balances_, opened_loads_, spec_.model.diluted_beads.share,
                                  spec_.model.diluted_beads.least_slack, key_);
    opened_group_ = group;
  }
  if (!opened_.complete) return false;
  LargestSlack start = find_largest_slack(balances_, opened_.opened, load);
  if (start.solvability != Solvability::inside) return false;
  if (directions_of_ != opened_.opened) {
    directions_ = find_null_directions(balances_, opened_.opened);
    directions_of_ = opened_.opened;
  }
  walk_.emplace(std::move(start.slacks), directions_);
  ++counts_.chains;
  counts_.burn_in += burn_in_sweeps();
  counts_.thinning += thinning_sweeps();
  load_.assign(load.begin(), load.end());
  sweeps_ = 0;
  run(burn_in_sweeps());
  walk_group_ = group;
  in_group_ = 0;
  return true;
}

void DilutedBeadsSampler::run(std::uint64_t sweeps) {
  for (std::uint64_t k = 0; k < sweeps; ++k) {
    if (sweeps_ % 64 == 0) throw_if_interrupted();
    ++sweeps_;
    walk_->sweep(
        [this](std::size_t direction) { return key_.chain_move(0, static_cast<int>(direction), sweeps_).first; });
  }
  const std::uint64_t moves = sweeps * walk_->directions();
  counts_.moves += moves;
  counts_.uniforms += moves;
}

namespace {

/// V and H of a contact per unit of N and of T; to_right: of one that leads to the lower right.
struct Directions {
  double V_of_N, V_of_T, H_of_N, H_of_T;
};
Directions directions(bool to_right) {
  const double side = to_right ? 0.5 : -0.5;
  return {sqrt3 / 2, -side, side, sqrt3 / 2};
}

}  // namespace

ContactBalances::ContactBalances(double mu, const Lattice& lattice) : lattice_(lattice), mu_(FrictionCone(mu).mu()) {
  if (!(mu > 0)) {
    throw InputError(
        "without friction an opened contact leaves no solution but straight lines of force; give diluted beads a "
        "friction coefficient above 0");
  }
  first_.push_back(0);
  for (std::size_t contact = 0; contact < contacts(); ++contact) {
    const bool to_right = contact < lattice.beads();
    const std::size_t bead = to_right ? contact : contact - lattice.beads();
    const auto columns = static_cast<std::size_t>(lattice.columns());
    const int layer = static_cast<int>(bead / columns), column = static_cast<int>(bead % columns);
    const Directions d = directions(to_right);
    // N = (low + high)/2, T = mu (low - high)/2.
    const auto add = [&](std::size_t equation, double of_N, double of_T) {
      terms_.push_back({equation, (of_N + mu * of_T) / 2, (of_N - mu * of_T) / 2});
    };
    const auto add_bead = [&](std::size_t at, double sign) {
      add(3 * at, sign * d.V_of_N, sign * d.V_of_T);
      add(3 * at + 1, sign * d.H_of_N, sign * d.H_of_T);
      add(3 * at + 2, 0, 1);
    };
    add_bead(bead, -1);
    if (layer + 1 < lattice.layers()) {
      add_bead(
          lattice.index(layer + 1, to_right ? lattice.lower_right(layer, column) : lattice.lower_left(layer, column)),
          1);
    }
    first_.push_back(terms_.size());
  }
}

void ContactBalances::store(const ContactSlacks& slacks, Pile& pile) const {
  for (std::size_t contact = 0; contact < contacts(); ++contact) {
    const bool to_right = contact < lattice_.beads();
    const std::size_t bead = to_right ? contact : contact - lattice_.beads();
    const double N = (slacks.low[contact] + slacks.high[contact]) / 2;
    const double T = mu_ * (slacks.low[contact] - slacks.high[contact]) / 2;
    const Directions d = directions(to_right);
    (to_right ? pile.V_R : pile.V_L)[bead] = d.V_of_N * N + d.V_of_T * T;
    (to_right ? pile.H_R : pile.H_L)[bead] = d.H_of_N * N + d.H_of_T * T;
  }
  pile.mu = mu_;
}

namespace {

enum class Method { primal, dual };

/// The library keeps an environment for each thread that uses it; it is to end with the thread.
struct ThreadEnvironment {
  ~ThreadEnvironment() { glp_free_env(); }
};

glp_prob* make_problem() {
  thread_local const ThreadEnvironment environment;
  return glp_create_prob();
}

/// A linear programme of the library GLPK, whose rows are the balances and whose columns 2 k + 1 and 2 k + 2 the slacks
/// of contact k. Belongs to the thread that made it.
class BalanceProgramme {
 public:
  BalanceProgramme(const ContactBalances& balances, std::span<const double> load) : problem_(make_problem()) {
    glp_term_out(GLP_OFF);
    glp_add_rows(problem_, static_cast<int>(balances.equations()));
    for (std::size_t row = 0; row < balances.equations(); ++row) {
      const double right = balances.right_side(row, load);
      glp_set_row_bnds(problem_, static_cast<int>(row) + 1, GLP_FX, right, right);
    }
    glp_add_cols(problem_, 2 * static_cast<int>(balances.contacts()));
    for (std::size_t contact = 0; contact < balances.contacts(); ++contact) {
      Column low, high;
      for (const BalanceTerm& term : balances.terms(contact)) {
        low.add(term.equation, term.of_low);
        high.add(term.equation, term.of_high);
      }
      low.set(problem_, low_of(contact));
      high.set(problem_, high_of(contact));
    }
  }
  BalanceProgramme(const BalanceProgramme&) = delete;
  BalanceProgramme& operator=(const BalanceProgramme&) = delete;
  ~BalanceProgramme() { glp_delete_prob(problem_); }

  static int low_of(std::size_t contact) { return 2 * static_cast<int>(contact) + 1; }
  static int high_of(std::size_t contact) { return low_of(contact) + 1; }

  void set_least(std::size_t contact, double least) {
    for (const int column : {low_of(contact), high_of(contact)})
      glp_set_col_bnds(problem_, column, GLP_LO, least, least);
  }
  void set_opened(std::size_t contact) {
    for (const int column : {low_of(contact), high_of(contact)}) glp_set_col_bnds(problem_, column, GLP_FX, 0, 0);
  }

  /// One more column: the slack that all contacts but the opened ones have in common, which is to be as large as can
  /// be. Their own columns are then what they have beyond it.
  int add_common_slack(const ContactBalances& balances, const OpenedContacts& opened) {
    std::vector<double> sums(balances.equations());
    for (std::size_t contact = 0; contact < balances.contacts(); ++contact) {
      if (opened[contact] != 0) continue;
      for (const BalanceTerm& term : balances.terms(contact)) sums[term.equation] += term.of_low + term.of_high;
    }
    Column column;
    for (std::size_t row = 0; row < sums.size(); ++row) column.add(row, sums[row]);
    const int number = glp_add_cols(problem_, 1);
    column.set(problem_, number);
    glp_set_col_bnds(problem_, number, GLP_FR, 0, 0);
    glp_set_obj_dir(problem_, GLP_MAX);
    glp_set_obj_coef(problem_, number, 1);
    return number;
  }

  /// Goes on from the last basis. Whether there is a solution; nothing if the library cannot tell.
  std::optional<bool> solve(Method method) {
    glp_smcp parameters;
    glp_init_smcp(&parameters);
    parameters.msg_lev = GLP_MSG_OFF;
    parameters.meth = method == Method::primal ? GLP_PRIMAL : GLP_DUALP;
    parameters.tol_bnd = parameters.tol_dj = 1e-9;
    // Updates of a large basis lose digits, until it is singular or no step goes on: then the next begins anew, the
    // last by another method.
    for (const int begin : {0, 1, 2}) {
      if (begin == 1) glp_std_basis(problem_);
      if (begin == 2) {
        glp_adv_basis(problem_, 0);
        parameters.meth = GLP_PRIMAL;
      }
      if (glp_simplex(problem_, &parameters) != 0) continue;
      const int status = glp_get_status(problem_);
      if (status == GLP_OPT) return true;
      if (status == GLP_NOFEAS) return false;
    }
    glp_std_basis(problem_);
    return std::nullopt;
  }

  /// Solves the balances of the last basis afresh: updates of its factors have lost some digits.
  void refine() {
    if (glp_factorize(problem_) == 0) glp_warm_up(problem_);
  }

  double value(int column) const { return glp_get_col_prim(problem_, column); }

 private:
  /// A column of the matrix; the library counts from 1.
  struct Column {
    std::vector<int> rows{0};
    std::vector<double> values{0};
    void add(std::size_t row, double value) {
      if (value == 0) return;
      rows.push_back(static_cast<int>(row) + 1);
      values.push_back(value);
    }
    void set(glp_prob* problem, int number) const {
      glp_set_mat_col(problem, number, static_cast<int>(rows.size()) - 1, rows.data(), values.data());
    }
  };

  glp_prob* problem_;
};

}  // namespace

LargestSlack find_largest_slack(const ContactBalances& balances, const OpenedContacts& opened,
                                std::span<const double> load) {
  BalanceProgramme programme(balances, load);
  for (std::size_t contact = 0; contact < balances.contacts(); ++contact) {
    if (opened[contact] != 0) {
      programme.set_opened(contact);
    } else {
      programme.set_least(contact, 0);
    }
  }
  const int common = programme.add_common_slack(balances, opened);
  LargestSlack found;
  const std::optional<bool> solved = programme.solve(Method::primal);
  if (!solved)
    throw std::logic_error("the linear programme of a pile with opened contacts was neither solved nor refuted");
  if (!*solved) {
    found.slack = std::numeric_limits<double>::quiet_NaN();
    return found;
  }
  programme.refine();
  found.slack = programme.value(common);
  if (found.slack < -slack_tolerance) return found;
  found.solvability = found.slack > slack_tolerance ? Solvability::inside : Solvability::edge;
  found.slacks.low.resize(balances.contacts());
  found.slacks.high.resize(balances.contacts());
  for (std::size_t contact = 0; contact < balances.contacts(); ++contact) {
    if (opened[contact] != 0) continue;
    found.slacks.low[contact] = found.slack + programme.value(BalanceProgramme::low_of(contact));
    found.slacks.high[contact] = found.slack + programme.value(BalanceProgramme::high_of(contact));
  }
  return found;
}

class StepwiseOpening::Programme : public BalanceProgramme {
  using BalanceProgramme::BalanceProgramme;
};

StepwiseOpening::StepwiseOpening(const ContactBalances& balances, std::span<const double> load, double least_slack)
    : programme_(std::make_unique<Programme>(balances, load)), least_slack_(least_slack) {
  for (std::size_t contact = 0; contact < balances.contacts(); ++contact) close(contact);
}
StepwiseOpening::StepwiseOpening(StepwiseOpening&&) noexcept = default;
StepwiseOpening::~StepwiseOpening() = default;

// Nothing is maximised: the dual simplex method goes on from the last basis, which stays dual feasible.
// What cannot be told counts as no: the contact stays closed.
bool StepwiseOpening::solvable() { return programme_->solve(Method::dual).value_or(false); }
void StepwiseOpening::open(std::size_t contact) { programme_->set_opened(contact); }
void StepwiseOpening::close(std::size_t contact) { programme_->set_least(contact, least_slack_); }

namespace {

constexpr std::size_t nowhere = static_cast<std::size_t>(-1);
/// Coefficients are of order 1; what elimination leaves of a zero is far smaller.
constexpr double elimination_zero = 1e-9;

/// Some beads, and closed contacts that enter the balances of no others. The unknowns are the slacks of the contacts,
/// in their order.
struct Region {
  std::vector<std::size_t> beads, contacts;
};

/// The balances of a region solved for one unknown each (Gauss-Jordan): unknown + sum of the free ones = 0.
class SolvedBalances {
 public:
  SolvedBalances(const ContactBalances& balances, const Region& region, std::vector<std::size_t>& place_of_bead)
      : unknowns_(2 * region.contacts.size()), rows_(3 * region.beads.size()), matrix_(rows_ * unknowns_) {
    for (std::size_t b = 0; b < region.beads.size(); ++b) place_of_bead[region.beads[b]] = b;
    for (std::size_t c = 0; c < region.contacts.size(); ++c) {
      for (const BalanceTerm& term : balances.terms(region.contacts[c])) {
        double* row = row_at(3 * place_of_bead[term.equation / 3] + term.equation % 3);
        row[2 * c] = term.of_low;
        row[2 * c + 1] = term.of_high;
      }
    }
    for (const std::size_t bead : region.beads) place_of_bead[bead] = nowhere;
    solve();
  }

  const std::vector<std::size_t>& free() const { return free_; }
  /// All unknowns where free unknown number `f` is 1 and the others are 0.
  std::vector<double> direction(std::size_t f) const {
    std::vector<double> all(unknowns_);
    all[free_[f]] = 1;
    for (const auto& [row, unknown] : pivots_) all[unknown] = -matrix_[row * unknowns_ + free_[f]];
    return all;
  }

 private:
  double* row_at(std::size_t row) { return matrix_.data() + row * unknowns_; }

  /// Of a row, the last unknown that is not much smaller than the largest: those of the deepest contacts, which later
  /// rows have not met yet. nowhere: the row is 0.
  std::size_t pivot_of(const double* row) const {
    constexpr double not_much_smaller = 0.1;
    double largest = elimination_zero;
    for (std::size_t u = 0; u < unknowns_; ++u) largest = std::max(largest, std::abs(row[u]));
    if (!(largest > elimination_zero)) return nowhere;
    for (std::size_t u = unknowns_; u-- > 0;) {
      if (std::abs(row[u]) >= not_much_smaller * largest) return u;
    }
    return nowhere;
  }

  void solve() {
    std::vector<bool> solved_for(unknowns_);
    for (std::size_t r = 0; r < rows_; ++r) {
      double* row = row_at(r);
      const std::size_t pivot = pivot_of(row);
      if (pivot == nowhere) continue;
      const double scale = 1 / row[pivot];
      for (std::size_t u = 0; u < unknowns_; ++u) row[u] *= scale;
      for (std::size_t other = 0; other < rows_; ++other) {
        double* reduced = row_at(other);
        const double factor = reduced[pivot];
        if (other == r || factor == 0) continue;
        for (std::size_t u = 0; u < unknowns_; ++u) reduced[u] -= factor * row[u];
        reduced[pivot] = 0;
      }
      solved_for[pivot] = true;
      pivots_.emplace_back(r, pivot);
    }
    for (std::size_t u = 0; u < unknowns_; ++u) {
      if (!solved_for[u]) free_.push_back(u);
    }
  }

  std::size_t unknowns_, rows_;
  std::vector<double> matrix_;                               ///< [rows, unknowns]
  std::vector<std::pair<std::size_t, std::size_t>> pivots_;  ///< row, and the unknown that it is solved for
  std::vector<std::size_t> free_;
};

/// Collects directions, region by region.
class Collection {
 public:
  Collection(const ContactBalances& balances, const OpenedContacts& opened)
      : balances_(balances),
        opened_(opened),
        directions_of_(balances.contacts()),
        place_of_bead_(balances.lattice().beads(), nowhere),
        place_of_contact_(balances.contacts(), nowhere) {}

  bool opened(std::size_t contact) const { return opened_[contact] != 0; }
  std::vector<NullDirection>& directions() { return directions_; }

  void add(const Region& region) {
    const SolvedBalances solved(balances_, region, place_of_bead_);
    if (solved.free().empty()) return;
    for (std::size_t c = 0; c < region.contacts.size(); ++c) place_of_contact_[region.contacts[c]] = c;
    const std::vector<bool> found = found_already(region, solved.free());
    for (const std::size_t contact : region.contacts) place_of_contact_[contact] = nowhere;
    for (std::size_t f = 0; f < found.size(); ++f) {
      if (!found[f]) keep(region, solved.direction(f));
    }
  }

 private:
  /// Of the free unknowns, those that the directions found so far inside the region let vary as they like; a direction
  /// is told by its free unknowns alone.
  std::vector<bool> found_already(const Region& region, const std::vector<std::size_t>& free) const {
    std::vector<bool> found(free.size()), met(directions_.size());
    std::vector<std::pair<std::size_t, std::vector<double>>> reduced;  // a free unknown, and the row that has 1 there
    for (const std::size_t contact : region.contacts) {
      for (const std::size_t d : directions_of_[contact]) {
        if (met[d]) continue;
        met[d] = true;
        std::vector<double> row = free_part(directions_[d], free, 2 * region.contacts.size());
        for (const auto& [pivot, other] : reduced) {
          const double factor = row.empty() ? 0 : row[pivot];
          if (factor == 0) continue;
          for (std::size_t f = 0; f < row.size(); ++f) row[f] -= factor * other[f];
        }
        const auto largest =
            std::max_element(row.begin(), row.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
        constexpr double independent = 1e-7;
        if (largest == row.end() || !(std::abs(*largest) > independent)) continue;
        const auto pivot = static_cast<std::size_t>(largest - row.begin());
        const double scale = 1 / *largest;
        for (double& one : row) one *= scale;
        found[pivot] = true;
        reduced.emplace_back(pivot, std::move(row));
      }
    }
    return found;
  }

  /// Empty if the direction leaves the region.
  std::vector<double> free_part(const NullDirection& direction, const std::vector<std::size_t>& free,
                                std::size_t unknowns) const {
    std::vector<double> all(unknowns), part;
    for (const SlackChange& change : direction) {
      const std::size_t place = place_of_contact_[change.contact];
      if (place == nowhere) return {};
      all[2 * place] = change.low;
      all[2 * place + 1] = change.high;
    }
    part.reserve(free.size());
    for (const std::size_t unknown : free) part.push_back(all[unknown]);
    return part;
  }

  void keep(const Region& region, const std::vector<double>& values) {
    NullDirection direction;
    for (std::size_t c = 0; c < region.contacts.size(); ++c) {
      const double low = values[2 * c], high = values[2 * c + 1];
      if (std::abs(low) < elimination_zero && std::abs(high) < elimination_zero) continue;
      directions_of_[region.contacts[c]].push_back(directions_.size());
      direction.push_back({region.contacts[c], low, high});
    }
    directions_.push_back(std::move(direction));
  }

  const ContactBalances& balances_;
  const OpenedContacts& opened_;
  std::vector<NullDirection> directions_;
  std::vector<std::vector<std::size_t>> directions_of_;  ///< those in which each contact changes
  std::vector<std::size_t> place_of_bead_, place_of_contact_;
};

/// The beads that are reached from bead (layer, column) by fewer than `size` steps to the lower left and fewer than
/// `size` to the lower right, as far as they exist, with the contacts among them and those with the floor. `layer` may
/// lie above the top.
Region rhombus(const Collection& collection, const Lattice& lattice, int layer, int column, int size) {
  Region region;
  const int columns = lattice.columns();
  const auto exists = [&](int left, int right) {
    const int at = layer + left + right;
    return left < size && right < size && at >= 0 && at < lattice.layers();
  };
  for (int down = 0; down <= 2 * (size - 1); ++down) {  // layer by layer: the order in which balances are solved
    for (int left = std::max(0, down - size + 1); left <= std::min(down, size - 1); ++left) {
      const int right = down - left;
      if (!exists(left, right)) continue;
      // Twice x, from which the shift of odd layers is taken off.
      const int twice = 2 * column + std::abs(layer % 2) + right - left, shift = (layer + down) % 2;
      const int i = (((twice - shift) / 2) % columns + columns) % columns;
      const std::size_t bead = lattice.index(layer + down, i);
      const bool on_floor = layer + down == lattice.layers() - 1;
      region.beads.push_back(bead);
      for (const bool to_right : {true, false}) {
        const std::size_t contact = to_right ? bead : lattice.beads() + bead;
        if (collection.opened(contact)) continue;
        if (on_floor || exists(left + (to_right ? 0 : 1), right + (to_right ? 1 : 0))) {
          region.contacts.push_back(contact);
        }
      }
    }
  }
  return region;
}

/// All contacts that leave the layers first .. first + layers - 1, with the beads at their ends.
Region ring(const Collection& collection, const Lattice& lattice, int first, int layers) {
  Region region;
  for (int layer = first; layer <= std::min(first + layers, lattice.layers() - 1); ++layer) {
    for (int i = 0; i < lattice.columns(); ++i) {
      const std::size_t bead = lattice.index(layer, i);
      region.beads.push_back(bead);
      for (const std::size_t contact : {bead, lattice.beads() + bead}) {
        if (layer < first + layers && !collection.opened(contact)) region.contacts.push_back(contact);
      }
    }
  }
  return region;
}

}  // namespace

std::vector<NullDirection> find_null_directions(const ContactBalances& balances, const OpenedContacts& opened) {
  const Lattice& lattice = balances.lattice();
  Collection collection(balances, opened);
  const bool diluted = std::any_of(opened.begin(), opened.end(), [](std::uint8_t one) { return one != 0; });
  // Without opened contacts the smallest regions hold all there is.
  const int largest_rhombus = std::min(diluted ? 6 : 3, lattice.columns() - 1), highest_ring = diluted ? 3 : 1;
  for (int size = 3; size <= largest_rhombus; ++size) {
    for (int layer = -2 * (size - 1); layer < lattice.layers(); ++layer) {
      for (int i = 0; i < lattice.columns(); ++i) collection.add(rhombus(collection, lattice, layer, i, size));
    }
  }
  for (int layers = 1; layers <= highest_ring; ++layers) {
    for (int layer = 0; layer < lattice.layers(); ++layer) collection.add(ring(collection, lattice, layer, layers));
  }
  collection.add(ring(collection, lattice, 0, lattice.layers()));
  return std::move(collection.directions());
}

}  // namespace granuscope
