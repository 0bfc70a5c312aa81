#pragma once

#include <cstddef>
#include <optional>

#include "corrsel/datasets/pair_source.h"
#include "corrsel/datasets/reader.h"

namespace corrsel::core {

/// The pairs of a dataset's folder in the order of its reader, which must outlive this object. next() throws
/// what DatasetReader::read() throws.
class ReaderSource : public PairSource {
 public:
  explicit ReaderSource(const DatasetReader& reader) : reader_(reader) {}

  std::size_t size() const override { return reader_.size(); }
  bool next(ImagePair& pair) override;
  std::optional<PairId> nextId() const override;
  void skip() override;

 private:
  const DatasetReader& reader_;
  std::size_t position_ = 0;
};

}  // namespace corrsel::core
