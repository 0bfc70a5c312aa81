#include "datasets/wxbs.h"

#include <algorithm>
#include <filesystem>
#include <optional>

#include "base/text.h"
#include "corrsel/evaluation/statistics.h"
#include "datasets/files.h"
#include "datasets/text_rows.h"
#include "geometry/fundamental.h"
#include "geometry/fundamental_fit.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;

constexpr char kPoints[] = "corrs.txt", kErrors[] = "crossval_errors.txt";
constexpr char kRemedy[] =
    "a pair of WxBS is a folder KIND/SCENE with 01 and 02 (.png, .jpg, ...) and corrs.txt; unpack the "
    "dataset "
    "again";
constexpr std::size_t kMinPoints = 8;

bool isPair(const std::string& folder) {
  const std::vector<std::string> names = fileNames(folder);
  return std::find(names.begin(), names.end(), kPoints) != names.end();
}

Correspondences readPoints(const std::string& folder) {
  Correspondences points;
  const std::string path = below(folder, kPoints);
  for (const TextRow& row : readTextRows(path, kRemedy)) {
    row.requireWords(4, "x1 y1 x2 y2");
    const std::vector<double> p = row.numbers(0, 4);
    points.add({static_cast<float>(p[0]), static_cast<float>(p[1])},
               {static_cast<float>(p[2]), static_cast<float>(p[3])});
  }
  if (points.size() < kMinPoints) {
    throw DatasetError(path + ": has " + std::to_string(points.size()) + " correspondences, at least " +
                       std::to_string(kMinPoints) + " are needed to fit a fundamental matrix; " + kRemedy);
  }
  return points;
}

/// Throws where there are cross-validation errors of other correspondences.
void checkErrors(const std::string& folder, std::size_t points) {
  const std::string path = below(folder, kErrors);
  if (existingFiles({path}).empty()) return;
  std::size_t errors = 0;
  for (const TextRow& row : readTextRows(path, kRemedy)) {
    errors += row.numbers(0, row.words.size()).size();
  }
  if (errors == points) return;
  throw DatasetError(path + ": has " + std::to_string(errors) + " errors for the " + std::to_string(points) +
                     " correspondences in " + kPoints + "; " + kRemedy);
}

cv::Matx33d fit(const std::string& folder, const Correspondences& points) {
  const std::optional<cv::Matx33d> fitted = fitFundamental(points);
  if (!fitted) {
    throw DatasetError(below(folder, kPoints) + ": the " + std::to_string(points.size()) +
                       " correspondences do not determine a fundamental matrix, as points in one plane do; "
                       "mark points at other depths, or give the pair as pairs/NAME with H.txt");
  }
  return *fitted;
}

/// Distances of the right points from the epipolar lines of the left ones, px.
std::vector<double> distances(const cv::Matx33d& f, const Correspondences& points) {
  std::vector<double> result;
  for (std::size_t i = 0; i < points.size(); ++i) {
    result.push_back(
        epipolarLineDistance(f, points.left_x[i], points.left_y[i], points.right_x[i], points.right_y[i]));
  }
  return result;
}

}  // namespace

WxbsReader::WxbsReader(const std::string& name, const std::string& root) : name_(name), root_(root) {
  requireFolder(root, "dataset '" + name + "'",
                "set the path to the folder that holds the folders KIND/SCENE");
  std::vector<double> all;
  std::size_t fitted = 0;
  double largest = 0;
  std::string worst;
  for (const std::string& kind : subfolders(root)) {
    bool any = false;
    for (const std::string& scene : subfolders(below(root, kind))) {
      Pair pair{kind, scene, below(below(root, kind), scene), cv::Matx33d::zeros(), ""};
      const bool used = isPair(pair.folder) || !imagesOf(below(pair.folder, "01")).empty();
      if (!used) continue;
      any = true;
      try {
        const Correspondences points = readPoints(pair.folder);
        checkErrors(pair.folder, points.size());
        pair.fundamental = fit(pair.folder, points);
        const std::vector<double> errors = distances(pair.fundamental, points);
        all.insert(all.end(), errors.begin(), errors.end());
        ++fitted;
        const double own = *std::max_element(errors.begin(), errors.end());
        if (own > largest || worst.empty()) {
          largest = own;
          worst = kind + "/" + scene;
        }
      } catch (const DatasetError& error) {
        pair.fault = error.what();
      }
      pairs_.push_back(std::move(pair));
    }
    if (!any) ignored_.push_back(kind);
  }
  if (fitted == 0) return;
  remarks_.push_back("the ground truth is fundamental matrices fitted to " + std::to_string(all.size()) +
                     " correspondences that people marked in " + std::to_string(fitted) +
                     (fitted == 1 ? " pair" : " pairs") + "; the points lie " +
                     roundedText(quantile(all, 0.5)) + " px (median), " + roundedText(quantile(all, 0.9)) +
                     " px (90 % of them below) and at most " + roundedText(largest) + " px (" + worst +
                     ") from their epipolar lines");
}

PairId WxbsReader::id(std::size_t index) const {
  const Pair& pair = pairs_.at(index);
  return {name_, pair.scene, pair.kind};
}

ImagePair WxbsReader::read(std::size_t index) const {
  ImagePair pair;
  pair.id = id(index);
  check(index);
  const Pair& own = pairs_[index];
  readImages(root_, requireImage(below(own.folder, "01"), kRemedy),
             requireImage(below(own.folder, "02"), kRemedy), kRemedy, pair);
  pair.truth.kind = TruthKind::kFundamental;
  pair.truth.matrix = own.fundamental;
  return pair;
}

void WxbsReader::check(std::size_t index) const {
  const Pair& pair = pairs_.at(index);
  if (!pair.fault.empty()) throw DatasetError(pair.fault);
  for (const char* const image : {"01", "02"}) requireImage(below(pair.folder, image), kRemedy);
}

std::vector<std::string> WxbsReader::files() const {
  std::vector<std::string> paths;
  for (const Pair& pair : pairs_) {
    for (const char* const stem : {"01", "02"}) {
      for (const std::string& image : imagesOf(below(pair.folder, stem))) paths.push_back(image);
    }
    for (const char* const file : {kPoints, kErrors}) paths.push_back(below(pair.folder, file));
  }
  return existingFiles(paths);
}

bool WxbsReader::fits(const std::string& root) {
  for (const std::string& kind : subfolders(root)) {
    for (const std::string& scene : subfolders(below(root, kind))) {
      if (isPair(below(below(root, kind), scene))) return true;
    }
  }
  return false;
}

}  // namespace corrsel::core
