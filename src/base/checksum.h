#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace corrsel::core {

/// The 64-bit FNV-1a checksum: hash = (hash ^ unit) * 0x100000001b3, starting at 0xcbf29ce484222325. It
/// distinguishes data quickly, but does not protect against data that is made to collide. The value depends
/// only on the bytes and their order, so it is the same on every machine.
///
/// Source: Fowler, Noll, Vo and Eastlake, "The FNV Non-Cryptographic Hash Algorithm", IETF draft.
class Checksum {
 public:
  /// Adds bytes, one unit each. O(size).
  void add(const void* data, std::size_t size) {
    const auto* const bytes = static_cast<const std::uint8_t*>(data);
    for (std::size_t i = 0; i < size; ++i) addUnit(bytes[i]);
  }

  void add(const std::string& text) { add(text.data(), text.size()); }

  /// Adds one unit, which may be wider than a byte: eight bytes in one step take an eighth of the time, but
  /// the value differs from that of the same bytes one by one.
  void addUnit(std::uint64_t unit) { value_ = (value_ ^ unit) * 0x100000001b3ULL; }

  std::uint64_t value() const { return value_; }

  /// The value as 16 hexadecimal digits.
  std::string text() const;

 private:
  std::uint64_t value_ = 0xcbf29ce484222325ULL;
};

}  // namespace corrsel::core
