#include "storage/block_sums.h"

#include <algorithm>

#include "support/files.h"

namespace granuscope {
namespace {

/// The numbers of some blocks; none where there are no squares.
std::span<const double> slice(const BlockSums& sums, const QuantitySums& quantity, const std::vector<double>& numbers,
                              std::size_t first, std::size_t blocks) {
  if (sums.elsewhere && quantity.width > 1) throw std::logic_error("profiles of blocks are taken from memory only");
  if (numbers.empty()) return {};
  const std::size_t each = sums.layers.size() * static_cast<std::size_t>(quantity.width);
  return std::span(numbers).subspan(first * each, blocks * each);
}

/// Moves the means of blocks of `count` samples apart about that of all of them. `sums`: [blocks, width].
void scatter_blocks(std::vector<double>& sums, const std::vector<std::uint64_t>& count, double factor) {
  const std::size_t width = sums.size() / count.size();
  const auto samples = static_cast<double>(std::accumulate(count.begin(), count.end(), std::uint64_t{0}));
  for (std::size_t i = 0; i < width; ++i) {
    double mean = 0;
    for (std::size_t b = 0; b < count.size(); ++b) mean += sums[b * width + i] / samples;
    for (std::size_t b = 0; b < count.size(); ++b) {
      const double expected = mean * static_cast<double>(count[b]);
      sums[b * width + i] = expected + factor * (sums[b * width + i] - expected);
    }
  }
}

}  // namespace

LayerSums BlockSums::layer(const std::string& quantity, std::size_t row) const {
  const QuantitySums& q = quantities.at(quantity);
  const auto width = static_cast<std::size_t>(q.width);
  const bool here = elsewhere == nullptr || width == 1;
  if (here && scatter == 1) return {&q.sum[row * width], count.size(), layers.size() * width, width};
  std::vector<double> read(count.size() * width);
  for (std::size_t b = 0; b < count.size(); ++b) {
    const std::span to = std::span(read).subspan(b * width, width);
    if (here) {
      for (std::size_t i = 0; i < width; ++i) to[i] = q.sum[(b * layers.size() + row) * width + i];
    } else {
      elsewhere->read(quantity, b, row, to);
    }
  }
  if (scatter != 1) scatter_blocks(read, count, scatter);
  return {std::move(read), width};
}

BlockSums in_memory(const BlockSums& sums) {
  BlockSums all = sums;
  if (sums.elsewhere == nullptr) return all;
  if (sums.scatter != 1) throw std::logic_error("blocks are moved apart for an analysis, not to be kept");
  all.elsewhere.reset();
  for (auto& [name, quantity] : all.quantities) {
    if (quantity.width == 1) continue;
    quantity.sum.clear();
    const auto width = static_cast<std::size_t>(quantity.width);
    quantity.sum.resize(sums.count.size() * sums.layers.size() * width);
    for (std::size_t row = 0; row < sums.layers.size(); ++row) {
      const LayerSums layer = sums.layer(name, row);
      for (std::size_t b = 0; b < sums.count.size(); ++b) {
        std::copy_n(layer.block(b), width, &quantity.sum[(b * sums.layers.size() + row) * width]);
      }
    }
  }
  return all;
}

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
  std::size_t size = sizeof(int) + sizeof(sums.count[at]) + sums.layers.size() * sizeof(int);
  for (const auto& [name, quantity] : sums.quantities) {
    const std::size_t numbers = sums.layers.size() * static_cast<std::size_t>(quantity.width);
    size += name.size() + (quantity.has_squares() ? 2 : 1) * numbers * sizeof(double);
  }
  bytes.reserve(size);  // a growing one would take three times as much
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
