#include "support/describe_bytes.h"

#include <fmt/format.h>

namespace granuscope {

std::string describe_bytes(double bytes) {
  if (bytes < 1e9) return fmt::format("{:.1f} MB", bytes / 1e6);
  if (bytes < 1e12) return fmt::format("{:.1f} GB", bytes / 1e9);
  return fmt::format("{:.3g} TB", bytes / 1e12);
}

}  // namespace granuscope
