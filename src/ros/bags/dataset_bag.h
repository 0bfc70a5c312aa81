#pragma once

#include <cstddef>
#include <memory>

#include "ros/bags/bag_file.h"
#include "ros/bags/bag_source.h"

namespace corrsel {

/// Reads a dataset bag: messages with equal header stamps form a pair, which ends where the next stamp
/// begins. Images are raw or compressed, in any mixture of encodings; a pair with given matches may have
/// none. A pair without ground truth has TruthKind::kNone and, unless it has given matches, is named {bag's
/// name, "bag", stamp}. There are no notes: next() reports incomplete pairs.
class DatasetBagSource : public BagSource {
 public:
  /// Throws core::DatasetError that lists the bag's topics if it has no left or no right images.
  explicit DatasetBagSource(BagFile file);
  ~DatasetBagSource() override;

  /// Number of left images or of ground truths, whichever is larger. No message is read for it.
  std::size_t size() const override;
  bool next(core::ImagePair& pair) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace corrsel
