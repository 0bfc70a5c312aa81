#pragma once

#include <cstddef>
#include <optional>

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

  /// Id of the next pair where it is known before the pair is read; nothing otherwise.
  virtual std::optional<PairId> nextId() const { return std::nullopt; }

  /// Passes over the next pair; a source that knows the ids of its pairs does not read it. Throws like
  /// next().
  virtual void skip() {
    ImagePair ignored;
    next(ignored);
  }
};

}  // namespace corrsel::core
