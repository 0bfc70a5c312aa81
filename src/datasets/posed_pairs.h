#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "corrsel/datasets/reader.h"
#include "datasets/lens.h"
#include "datasets/pair_choice.h"
#include "geometry/rigid_motion.h"

namespace corrsel::core {

/// An image file of a calibrated camera.
struct PosedImage {
  std::string path;
  std::shared_ptr<const Lens> lens;
  int quarter_turns = 0;  ///< counter-clockwise, by which the image of a pinhole is turned before use; 0 to 3
};

/// A pair of images whose relative pose is known.
struct PosedPair {
  PairId id;
  PosedImage left, right;
  RigidMotion motion;  ///< from the frame of the left camera, before it is turned, to that of the right one
  std::string fault;   ///< where not empty, the pair cannot be read, for this reason
};

/// What was found in the folder of a dataset of posed pairs.
struct PosedDataset {
  std::vector<PosedPair> pairs;    ///< in their order
  std::vector<std::string> files;  ///< beside the images: calibrations, poses, lists
  std::vector<std::string> remarks;
  std::vector<std::string> ignored;
  std::string remedy;  ///< what can be done about a missing or damaged image

  /// A sequence that cannot be read becomes one broken pair.
  void addBroken(const std::string& name, const std::string& sequence, const std::string& fault) {
    PosedPair pair;
    pair.id = {name, sequence, "all"};
    pair.fault = fault;
    pairs.push_back(std::move(pair));
  }
};

/// Reads pairs of calibrated images. The images are turned by their quarter turns, or freed from the
/// distortion of their lens (Lens), and calibration and pose are those of the images that result. The ground
/// truth is that of truthOf(): the images of fisheye lenses stay as they are.
class PosedPairReader : public DatasetReader {
 public:
  /// Pairs of equal names get numbers: a second "1-2" becomes "1-2#2".
  /// @param root  the dataset's folder, below which the images have their names. Images that are changed have
  ///              none, because their matches do not fit the files.
  PosedPairReader(PosedDataset dataset, std::string root);

  std::size_t size() const override { return dataset_.pairs.size(); }
  PairId id(std::size_t index) const override { return dataset_.pairs.at(index).id; }
  /// Throws DatasetError where an image is missing, cannot be decoded, or is not of the size for which its
  /// camera was calibrated.
  ImagePair read(std::size_t index) const override;
  void check(std::size_t index) const override;
  std::vector<std::string> ignored() const override { return dataset_.ignored; }
  std::vector<std::string> files() const override;
  std::vector<std::string> remarks() const override { return dataset_.remarks; }

 private:
  const PosedPair& usable(std::size_t index) const;

  PosedDataset dataset_;
  std::string root_;
};

/// The folders of the sequences of a dataset: the root itself where it is one, or else folders in it.
/// @param ignored  receives the names of the others; may be null
std::vector<std::string> sequenceFolders(const std::string& root,
                                         bool (*is_sequence)(const std::string& folder),
                                         std::vector<std::string>* ignored = nullptr);

/// An image of a sequence, and where its camera was.
struct PosedFrame {
  std::string name;  ///< in the names of pairs
  PosedImage image;
  RigidMotion pose;   ///< from the camera's frame to the world's
  bool known = true;  ///< whether there is a pose
};

/// Appends the pairs of frames i and i + step of a sequence to `dataset`: those with a pose at both ends and
/// a baseline of at least choice.min_baseline, spread evenly where they are more than choice.max_pairs. A
/// remark counts what was left out.
void addSteps(const std::string& name, const std::string& sequence, const std::vector<PosedFrame>& frames,
              const PairChoice& choice, PosedDataset& dataset);

/// How the sequences (or reconstructions) of a format are found and read.
struct SequenceFormat {
  std::string content;  ///< of a dataset's folder, in words, e.g. "the sequences"
  std::string remedy;   ///< that of the dataset
  bool (*is_sequence)(const std::string& folder);
  /// Its files beside the images, whether or not they exist.
  std::vector<std::string> (*files)(const std::string& folder);
  /// Appends its pairs and remarks to the dataset. Where it throws DatasetError, a broken pair is appended.
  void (*add)(const std::string& name, const std::string& folder, const PairChoice& choice,
              PosedDataset& dataset);
};

/// Reads all sequences of a dataset. Throws DatasetError where the folder or its PairChoice cannot be read,
/// and where sequences that can be read have no pair.
PosedDataset readSequences(const std::string& name, const std::string& root, const SequenceFormat& format);

/// Throws DatasetError where a dataset has no pair at all.
[[noreturn]] void failWithoutPairs(const std::string& name, const std::string& root, const std::string& why);

}  // namespace corrsel::core
