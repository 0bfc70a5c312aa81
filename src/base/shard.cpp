#include "corrsel/shard.h"

#include <stdexcept>

#include "base/text.h"

namespace corrsel::core {

std::string Shard::text() const {
  return count == 1 ? "" : std::to_string(index + 1) + "/" + std::to_string(count);
}

Shard Shard::fromText(const std::string& text) {
  if (text.empty()) return {};
  const std::size_t slash = text.find('/');
  const std::string wanted = "shard '" + text + "' does not read as i/n with 1 <= i <= n <= 100000, e.g. 2/8";
  if (slash == std::string::npos) throw std::invalid_argument(wanted);
  const int part = parseInteger(text.substr(0, slash), "shard");
  const int parts = parseInteger(text.substr(slash + 1), "shard");
  if (part < 1 || part > parts || parts > 100000) throw std::invalid_argument(wanted);
  return {static_cast<std::size_t>(part - 1), static_cast<std::size_t>(parts)};
}

}  // namespace corrsel::core
