#pragma once

#include <string>
#include <vector>

#include "corrsel/datasets/pair_source.h"

namespace corrsel {

/// Reads the image pairs of a bag in this process, so that no topic can lose a frame. next() throws
/// core::DatasetError that names pair and topic if a pair is incomplete or cannot be decoded; the next call
/// goes on with the pair after it.
class BagSource : public core::PairSource {
 public:
  /// Sentences for people: which messages were left out and why, and what the reader decided.
  const std::vector<std::string>& notes() const { return notes_; }

  /// Which pairs are evaluated with a calibration and not by a message with ground truth; empty: none.
  const std::string& evaluatedByCalibration() const { return evaluated_by_calibration_; }

 protected:
  std::vector<std::string> notes_;
  std::string evaluated_by_calibration_;
};

}  // namespace corrsel
