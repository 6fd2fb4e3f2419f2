#include "ensemble/merge.h"

#include "support/error.h"

namespace granuscope {

void merge_into(EnsembleRecord& to, const EnsembleRecord& more) {
  const auto add = [](auto& numbers, const auto& others) {
    for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] += others[i];
  };
  bool alike = to.sums.layers == more.sums.layers && to.sums.blocks() == more.sums.blocks() &&
               to.sums.quantities.size() == more.sums.quantities.size();
  for (const auto& [name, quantity] : to.sums.quantities) {
    const auto other = more.sums.quantities.find(name);
    alike = alike && other != more.sums.quantities.end() && other->second.width == quantity.width;
  }
  if (!alike) {
    throw InputError(
        "two ensembles of other layers, blocks or quantities cannot be added; draw them with one configuration");
  }
  add(to.sums.count, more.sums.count);
  for (auto& [name, quantity] : to.sums.quantities) {
    const QuantitySums& other = more.sums.quantities.at(name);
    add(quantity.sum, other.sum);
    add(quantity.sum_of_squares, other.sum_of_squares);
  }
  to.counts += more.counts;
  to.failed.insert(to.failed.end(), more.failed.begin(), more.failed.end());
}

}  // namespace granuscope
