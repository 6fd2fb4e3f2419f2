#include "sampling/largest_slack.h"

#include <glpk.h>

#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <vector>

namespace granuscope {
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

}  // namespace granuscope
