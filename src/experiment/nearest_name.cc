#include "experiment/nearest_name.h"

#include <algorithm>
#include <utility>

namespace granuscope {

int edit_distance(std::string_view a, std::string_view b) {
  // Rows of the usual table: distance[i][j] for the first i letters of a and the first j of b; only three are kept.
  std::vector<int> before_last(b.size() + 1);
  std::vector<int> last(b.size() + 1);
  std::vector<int> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = static_cast<int>(j);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = static_cast<int>(i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const int replaced = last[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({replaced, last[j] + 1, row[j - 1] + 1});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped) row[j] = std::min(row[j], before_last[j - 2] + 1);
    }
    before_last = std::exchange(last, std::exchange(row, before_last));
  }
  return last[b.size()];
}

std::optional<std::string> nearest_name(std::string_view mistyped, const std::vector<std::string>& known) {
  if (mistyped.size() > 200) return {};  // no typing error
  std::optional<std::string> best;
  int least = std::max(1, static_cast<int>(mistyped.size()) / 3) + 1;
  for (const std::string& name : known) {
    const int distance = edit_distance(mistyped, name);
    if (distance < least) {
      least = distance;
      best = name;
    }
  }
  return best;
}

}  // namespace granuscope
