#include "support/problem.h"

#include "support/error.h"

namespace granuscope {

Problem in_table(const std::string& table, Problem found) {
  if (found) found->key.insert(0, table + ".");
  return found;
}

void refuse(const Problem& found) {
  if (found) throw InputError(found->key + ": " + found->message);
}

}  // namespace granuscope
