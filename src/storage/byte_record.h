#pragma once
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace granuscope {

/// Values one after the other as bytes, for a process on the same machine. Read them back in the same order.
class ByteWriter {
 public:
  template <class Value>
  void put(const Value& value) {
    static_assert(std::is_trivially_copyable_v<Value>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void put(const std::string& text) {
    put(std::uint64_t{text.size()});
    bytes_ += text;
  }
  template <class Value>
  void put(const std::vector<Value>& values) {
    static_assert(std::is_trivially_copyable_v<Value>);
    put(std::uint64_t{values.size()});
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Value));
  }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

/// The other end. Throws std::logic_error where the bytes end too early: then the two ends do not fit.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : left_(bytes) {}

  template <class Value>
  void get(Value& value) {
    static_assert(std::is_trivially_copyable_v<Value>);
    std::memcpy(&value, next(sizeof value).data(), sizeof value);
  }
  void get(std::string& text) { text = next(length()); }
  template <class Value>
  void get(std::vector<Value>& values) {
    static_assert(std::is_trivially_copyable_v<Value>);
    const std::size_t count = length();
    if (count > left_.size() / sizeof(Value)) next(left_.size() + 1);
    values.resize(count);
    if (count > 0) std::memcpy(values.data(), next(count * sizeof(Value)).data(), count * sizeof(Value));
  }

 private:
  std::size_t length() {
    std::uint64_t size = 0;
    get(size);
    return size;
  }
  std::string_view next(std::size_t count) {
    if (count > left_.size()) throw std::logic_error("a byte record ends too early");
    const std::string_view found = left_.substr(0, count);
    left_.remove_prefix(count);
    return found;
  }

  std::string_view left_;
};

}  // namespace granuscope
