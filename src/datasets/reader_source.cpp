#include "datasets/reader_source.h"

namespace corrsel::core {

bool ReaderSource::next(ImagePair& pair) {
  if (position_ == reader_.size()) return false;
  const std::size_t index = position_++;  // also where the pair cannot be read
  pair = reader_.read(index);
  return true;
}

std::optional<PairId> ReaderSource::nextId() const {
  if (position_ == reader_.size()) return std::nullopt;
  return reader_.id(position_);
}

void ReaderSource::skip() {
  if (position_ < reader_.size()) ++position_;
}

}  // namespace corrsel::core
