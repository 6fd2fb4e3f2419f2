#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <vector>

#include "storage/hdf5_handle.h"

namespace granuscope {

/// The bytes of a file that is being composed. Only pages that were written take memory: what is reserved and filled
/// later, on disk, takes none. Bytes never written are zero.
class SparseImage {
 public:
  void write(std::uint64_t at, const void* bytes, std::size_t size);
  void read(std::uint64_t at, void* bytes, std::size_t size) const;
  std::uint64_t size() const { return size_; }
  void resize(std::uint64_t size) { size_ = size; }
  /// Each page that was written, in order, without what lies beyond the end.
  void for_each_page(const std::function<void(std::uint64_t at, std::span<const char> bytes)>& visit) const;

 private:
  std::map<std::uint64_t, std::vector<char>> pages_;  ///< by number
  std::uint64_t size_ = 0;
};

/// Makes HDF5 keep the file opened with this access list in `image`, which must outlive it. (The library's own driver
/// for files in memory fills everything that is reserved with zeros.) Negative if that fails.
int set_sparse_driver(Hdf5Id access_list, SparseImage* image);

}  // namespace granuscope
