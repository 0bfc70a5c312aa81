#pragma once

#include <cstddef>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "corrsel/image_pair.h"

namespace corrsel::core {

/// A dataset folder or one of its files is missing or broken.
class DatasetError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Reads a dataset folder pair by pair, with one pair in memory at a time.
class DatasetReader {
 public:
  virtual ~DatasetReader() = default;

  /// Number of pairs that the dataset should have, broken ones included. Their order is fixed.
  virtual std::size_t size() const = 0;

  virtual PairId id(std::size_t index) const = 0;

  /// Reads one pair. Throws DatasetError naming the file, what is wrong with it and the remedy.
  virtual ImagePair read(std::size_t index) const = 0;

  /// Throws DatasetError like read(), but is faster where possible: the existence of images is checked, and
  /// they are not decoded.
  virtual void check(std::size_t index) const { read(index); }

  /// Names of folders in the dataset's folder that have no file of the layout.
  virtual std::vector<std::string> ignored() const { return {}; }

  /// What the reader decided, left out or did to the images, one sentence without its full stop each.
  virtual std::vector<std::string> remarks() const { return {}; }

  /// Files that the pairs are read from or made of. Their sizes and times identify the state of the dataset.
  virtual std::vector<std::string> files() const = 0;
};

/// Opens dataset `name` from folder `path`. A name of datasetNames() means that dataset and its layout.
/// Under any other name the folder's layout is recognised from its files: numbered images with homographies
/// as in VGG or as in HPatches, a folder per pair as in SymBench or as in `pairs`, .mat files as in
/// AdelaideRMF, EVD, WxBS, a list of pairs as SuperGlue publishes them, reconstructions by COLMAP, sequences
/// of TUM RGB-D or of EuRoC (docs/datasets.md). The ids of the pairs contain the name as given.
///
/// A name that begins with kUnrelatedPrefix means pairs of different scenes, made from the images of the
/// dataset that the rest of the name means; `path` is the folder of that dataset. It is not used where
/// needsFolder() says so.
///
/// Throws std::invalid_argument for a name that is empty, "." or ".." or has a path separator, and for an
/// unknown name whose folder does not exist (listing the known ones). Throws DatasetError where a known
/// dataset's folder is missing or has none of its files, and where no layout, or more than one, is
/// recognised. The error tells what was looked for, what the first folders hold and what they lack.
/// @param seed  used by datasets that generate or draw pairs (sample, those whose names end with _generated,
///              unrelated ones)
std::unique_ptr<DatasetReader> openDataset(const std::string& name, const std::string& path, int seed = 0);

/// Names that openDataset() knows, in alphabetical order.
std::vector<std::string> datasetNames();

/// "unrelated_vgg" is the dataset of pairs of different scenes of "vgg".
inline constexpr char kUnrelatedPrefix[] = "unrelated_";

bool isUnrelated(const std::string& name);

/// Name of the dataset whose images are used: "vgg" for "vgg" and for "unrelated_vgg".
std::string imageDataset(const std::string& name);

/// Returns whether the dataset is read from a folder, in contrast to those that are generated from nothing.
bool needsFolder(const std::string& name);

/// Returns whether the dataset is made from the photographs that scripts/fetch_samples.sh collects. Its
/// folder is then that of the sample set.
bool needsSamplePhotographs(const std::string& name);

}  // namespace corrsel::core
