#include "storage/raw_data.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cmath>
#include <utility>

#include "support/error.h"
#include "support/system_reason.h"

namespace granuscope {
namespace {

/// Subscripts of a number in row-major order: "[12, 3]".
std::string position(std::size_t index, const std::vector<std::uint64_t>& shape) {
  std::vector<std::uint64_t> subscripts(shape.size());
  for (std::size_t axis = shape.size(); axis-- > 0;) {
    subscripts[axis] = index % shape[axis];
    index /= shape[axis];
  }
  return fmt::format("[{}]", fmt::join(subscripts, ", "));
}

}  // namespace

std::optional<std::string> find_not_finite(const std::string& dataset, const std::vector<std::uint64_t>& shape,
                                           std::size_t first, std::span<const double> values) {
  // Exponents of only ones are nan and infinity. No branch for each value, so that the compiler takes several at once.
  constexpr std::uint64_t exponent = 0x7ff0000000000000;
  bool found = false;
  for (const double value : values) found |= (std::bit_cast<std::uint64_t>(value) & exponent) == exponent;
  if (!found) return std::nullopt;
  const auto wrong = std::find_if_not(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
  return fmt::format("'{}' at {} is {}, not a finite number", dataset,
                     position(first + static_cast<std::size_t>(wrong - values.begin()), shape),
                     std::isnan(*wrong) ? "nan" : "infinite");
}

RawDataFile::RawDataFile(std::filesystem::path source, std::string kind)
    : source_(std::move(source)), kind_(std::move(kind)), file_(::open(source_.c_str(), O_RDONLY | O_CLOEXEC)) {
  if (!file_.valid()) fail(system_reason(errno));
}

void RawDataFile::fail(const std::string& reason) const {
  throw InputError(fmt::format("cannot read '{}' as {}: {}", source_.string(), kind_, reason));
}

void RawDataFile::read(const RawData& numbers, std::size_t first, std::span<double> target) const {
  if (!numbers.offset) {
    const auto from = numbers.values.begin() + static_cast<std::ptrdiff_t>(first);
    std::copy(from, from + static_cast<std::ptrdiff_t>(target.size()), target.begin());
  } else {
    auto* bytes = reinterpret_cast<char*>(target.data());
    std::size_t left = target.size_bytes();
    auto at = static_cast<off_t>(*numbers.offset + first * sizeof(double));
    while (left > 0) {
      const ssize_t got = ::pread(file_.get(), bytes, left, at);
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) fail(system_reason(errno));
      if (got == 0) {
        fail(
            fmt::format("its dataset '{}' is cut short, or the file changed while it was read. Make the file again "
                        "or name another one.",
                        numbers.dataset));
      }
      bytes += got;
      at += got;
      left -= static_cast<std::size_t>(got);
    }
  }
  if (const auto wrong = find_not_finite(numbers.dataset, numbers.shape, first, target)) {
    fail(fmt::format("{}. Make the file again or name another one.", *wrong));
  }
}

}  // namespace granuscope
