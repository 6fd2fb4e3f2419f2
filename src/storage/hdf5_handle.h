#pragma once
#include <cstdint>
#include <mutex>
#include <string>
#include <utility>

namespace granuscope {

/// HDF5's hid_t. Spelled out so that only the .cc files of this room include the library's headers.
using Hdf5Id = std::int64_t;

/// Owns one HDF5 identifier and closes it with the function it came with. A negative identifier is none.
class Hdf5Handle {
 public:
  using Close = int (*)(Hdf5Id);

  Hdf5Handle(Hdf5Id id, Close close) : id_(id), close_(close) {}
  Hdf5Handle(Hdf5Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Hdf5Handle(const Hdf5Handle&) = delete;
  Hdf5Handle& operator=(const Hdf5Handle&) = delete;
  Hdf5Handle& operator=(Hdf5Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  ~Hdf5Handle() {
    if (id_ >= 0) close_(id_);
  }

  Hdf5Id get() const { return id_; }
  bool valid() const { return id_ >= 0; }
  /// Gives the identifier up, for a close whose status matters.
  Hdf5Id release() { return std::exchange(id_, -1); }

 private:
  Hdf5Id id_;
  Close close_;
};

/// The right to call HDF5, which Debian builds without thread safety: one thread at a time holds it. Also silences the
/// library, which prints its errors by itself unless told otherwise. Not recursive: hold one at a time.
class Hdf5Session {
 public:
  Hdf5Session();

 private:
  std::unique_lock<std::mutex> lock_;
};

/// The innermost complaint of the last failed call, "" if there is none.
std::string hdf5_reason();

}  // namespace granuscope
