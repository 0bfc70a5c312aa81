#pragma once

#include <cstddef>

#include "corrsel/image_pair.h"

namespace corrsel::core {

/// A stream of image pairs. It is read once from front to back, with one pair in memory at a time.
class PairSource {
 public:
  virtual ~PairSource() = default;

  /// Number of pairs in the stream, known before the first is read.
  virtual std::size_t size() const = 0;

  /// Reads the next pair. @return false at the end of the stream.
  /// Throws DatasetError where a pair cannot be decoded; the next call reads the pair after it.
  virtual bool next(ImagePair& pair) = 0;
};

}  // namespace corrsel::core
