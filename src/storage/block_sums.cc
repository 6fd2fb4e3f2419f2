#include "storage/block_sums.h"

#include <span>

#include "support/digest.h"

namespace granuscope {
namespace {

/// The numbers of some blocks; none where there are no squares.
std::span<const double> slice(const BlockSums& sums, const QuantitySums& quantity, const std::vector<double>& numbers,
                              std::size_t first, std::size_t blocks) {
  if (numbers.empty()) return {};
  const std::size_t each = sums.layers.size() * static_cast<std::size_t>(quantity.width);
  return std::span(numbers).subspan(first * each, blocks * each);
}

}  // namespace

BlockSums zero_sums(const BlockSums& like, int first_block, std::size_t blocks) {
  BlockSums zero;
  zero.layers = like.layers;
  zero.rows = like.rows;
  zero.first_block = first_block;
  zero.count.assign(blocks, 0);
  for (const auto& [name, quantity] : like.quantities) {
    const std::size_t size = blocks * like.layers.size() * static_cast<std::size_t>(quantity.width);
    zero.quantities[name] = {quantity.width, std::vector<double>(size),
                             std::vector<double>(quantity.has_squares() ? size : 0)};
  }
  return zero;
}

BlockSums take_blocks(const BlockSums& all, std::size_t first, std::size_t blocks) {
  BlockSums taken;
  taken.layers = all.layers;
  taken.rows = all.rows;
  taken.first_block = all.first_block + static_cast<int>(first);
  const auto count = all.count.begin() + static_cast<std::ptrdiff_t>(first);
  taken.count.assign(count, count + static_cast<std::ptrdiff_t>(blocks));
  for (const auto& [name, quantity] : all.quantities) {
    const auto sum = slice(all, quantity, quantity.sum, first, blocks);
    const auto squares = slice(all, quantity, quantity.sum_of_squares, first, blocks);
    taken.quantities[name] = {quantity.width, {sum.begin(), sum.end()}, {squares.begin(), squares.end()}};
  }
  return taken;
}

std::string key_of_block(const BlockSums& sums, std::size_t at) {
  std::string bytes;
  const auto append = [&bytes](const auto& numbers) {
    bytes.append(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(numbers[0]));
  };
  const int number = sums.first_block + static_cast<int>(at);
  append(std::span(&number, 1));
  append(std::span(&sums.count[at], 1));
  append(sums.layers);
  for (const auto& [name, quantity] : sums.quantities) {
    bytes += name;
    append(slice(sums, quantity, quantity.sum, at, 1));
    append(slice(sums, quantity, quantity.sum_of_squares, at, 1));
  }
  return cache_key(bytes);
}

}  // namespace granuscope
