#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "support/file_descriptor.h"

namespace granuscope {

/// The numbers of a dataset: where they stand in the file or, if they stand there in another form (compressed, other
/// byte order), the numbers themselves.
struct RawData {
  std::string dataset;                  ///< for messages
  std::vector<std::uint64_t> shape;     ///< row-major
  std::optional<std::uint64_t> offset;  ///< of the first one in the file, each 8 bytes of this machine's doubles
  std::vector<double> values;           ///< all of them, if there is no offset
};

/// "'/V_R' at [12, 3] is nan, not a finite number", or nothing if all are finite. `values` begin at number `first` of
/// the dataset of the given shape.
std::optional<std::string> find_not_finite(const std::string& dataset, const std::vector<std::uint64_t>& shape,
                                           std::size_t first, std::span<const double> values);

/// A file whose plain numbers are read where they stand, without the HDF5 library. All errors are InputError naming the
/// file, the dataset and, for a number that is not finite, its place.
class RawDataFile {
 public:
  /// `kind` is what the file should be, with its article ("a pile file"), for messages.
  RawDataFile(std::filesystem::path source, std::string kind);

  /// Numbers `first` to `first + target.size() - 1` in row-major order; all are finite.
  void read(const RawData& numbers, std::size_t first, std::span<double> target) const;

 private:
  [[noreturn]] void fail(const std::string& reason) const;

  std::filesystem::path source_;
  std::string kind_;
  FileDescriptor file_;
};

}  // namespace granuscope
