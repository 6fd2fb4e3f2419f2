#pragma once
#include <hwy/aligned_allocator.h>

#include <cstddef>
#include <new>

namespace granuscope {

/// Piles that are solved side by side, one to a vector lane: bead i of pile k is entry 8 i + k of a row.
inline constexpr std::size_t group_lanes = 8;

/// Memory that vectors of any width may be read from and written to.
template <typename T>
using AlignedArray = hwy::AlignedFreeUniquePtr<T[]>;

/// Throws std::bad_alloc where there is not so much memory.
template <typename T>
AlignedArray<T> aligned_array(std::size_t size) {
  AlignedArray<T> array = hwy::AllocateAligned<T>(size);
  if (array == nullptr) throw std::bad_alloc();
  return array;
}

}  // namespace granuscope
