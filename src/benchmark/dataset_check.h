#pragma once

#include <memory>
#include <string>
#include <vector>

#include "corrsel/evaluation/truth_check.h"
#include "corrsel/image_pair.h"

namespace corrsel::core {

/// Looks at pairs one after the other and finds what contradicts itself: sizes of images that do not fit
/// their sequence or their ground truth, and ground truth that the images contradict. Pairs without given
/// matches are matched for this purpose with up to 1000 ORB features per image, which are found in images
/// reduced to one megapixel.
class PairInspector {
 public:
  explicit PairInspector(int threads);
  PairInspector(PairInspector&&) noexcept;
  ~PairInspector();

  /// Takes tens of milliseconds. The pair is not kept.
  void add(const ImagePair& pair);

  /// A sentence for each pair whose sizes are odd:
  /// - less than a twentieth of the left image is mapped into the right one by the homography, or has
  ///   epipolar lines that cross it;
  /// - the disparities have another size than the left image;
  /// - the principal point of a camera lies outside of its image;
  /// - its left (or right) image has another size than the left (or right) images of all other pairs of the
  ///   sequence, which are at least three and agree.
  std::vector<std::string> oddSizes() const;

  /// Ground truth that is probably not what it was given as, see truthWarnings().
  std::vector<TruthWarning> doubtfulTruths() const;

  /// Both, as lines to print: "odd: ..." and "doubtful: ...".
  std::vector<std::string> findings() const;

 private:
  struct Tools;
  void addSizes(const ImagePair& pair);
  std::unique_ptr<Tools> tools_;
  int threads_;
  std::vector<TruthCheck> checks_;
  std::vector<std::string> odd_;
};

}  // namespace corrsel::core
