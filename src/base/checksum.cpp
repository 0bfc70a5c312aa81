#include "base/checksum.h"

namespace corrsel::core {

std::string Checksum::text() const {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (int shift = 60; shift >= 0; shift -= 4) text += kDigits[value_ >> shift & 15U];
  return text;
}

}  // namespace corrsel::core
