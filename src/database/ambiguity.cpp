#include "corrsel/database/ambiguity.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "auto/leftover.h"
#include "base/coordinate_order.h"
#include "base/deadline.h"
#include "base/gather.h"
#include "corrsel/neighbours.h"
#include "corrsel/random.h"
#include "points/length_unit.h"
#include "search/homography_model.h"
#include "search/local_proposal.h"
#include "selectors/parts/sequential_planes.h"

namespace corrsel::core {
namespace {

constexpr double kDisplaced = 20;             // units of the image
constexpr int kNearest = 8, kSupporters = 2;  // of the nearest displaced matches
constexpr double kSameShift = 0.1;            // relative difference of two shifts
constexpr int kContesting = 4;                // of the nearest matches
constexpr double kMinShare = 0.1;             // of the selected matches
constexpr double kMinPlane = 0.4;             // of the selected matches, which the first relation explains
constexpr std::size_t kMinPlaces = 8;         // of the second relation
constexpr double kMinContested = 0.5;         // share of the second relation
constexpr double kMaxBetween = 0.2;           // matches between both relations, over those of the second one
constexpr std::size_t kMaxExamined = 1000;    // matches, of more a random sample
constexpr std::size_t kMaxSearched = 128;     // matches in which a homography is searched
constexpr int kHypotheses = 100, kMaxRelations = 2;
constexpr double kAbsurd = 1e6;  // px

/// Looks for a second relation beside that of a selection. Memory is kept between calls.
class SecondRelation {
 public:
  double examine(const Correspondences& matches, const Selection& selection, Workspace& workspace);

 private:
  using Rows = std::vector<std::uint32_t>;
  using Mask = std::vector<std::uint8_t>;

  void takeSample(const Correspondences& matches, const Mask& mask);
  bool findFirst(const Selection& selection);
  bool findHomography(cv::Matx33d& homography);
  bool sortByShift();
  void takeSupported();
  bool mayContest(std::size_t enough);
  void addContested(const std::vector<float>& x, const std::vector<float>& y);
  double evaluate(const cv::Matx33d& second);
  bool isBetween(const cv::Matx33d& second, std::uint32_t row) const;
  cv::Point2d predicted(const cv::Matx33d& h, std::uint32_t row) const;

  Workspace* workspace_ = nullptr;
  double displaced_ = 0;  // px
  cv::Matx33d first_;     // homography of the first relation, or of its largest plane
  std::vector<KeyedRow> sorted_, scratch_;
  Correspondences usable_, sample_;  // the matches without those at infinity, and those that are examined
  Mask selected_;                    // per match of the sample, as everything below
  std::vector<cv::Point2f> shift_;   // by row: from where the first relation expects the match to where it is
  Rows agreeing_, far_;              // selected matches near the first relation, and all matches far from it
  Rows supported_;                   // of the latter, those whose neighbours are shifted in the same way
  Mask contested_;                   // by row, of the supported ones
  Rows searched_, near_, members_;
  Mask of_first_, of_second_;
  std::vector<float> x_, y_;
  PlanarNeighbours neighbours_;
  SequentialPlanes planes_;
  Leftover leftover_;
};

cv::Point2d SecondRelation::predicted(const cv::Matx33d& h, std::uint32_t row) const {
  const cv::Vec3d p = h * cv::Vec3d(sample_.left_x[row], sample_.left_y[row], 1);
  return {p[0] / p[2], p[1] / p[2]};
}

/// Takes the usable matches in a random order that does not depend on theirs, at most kMaxExamined.
void SecondRelation::takeSample(const Correspondences& matches, const Mask& mask) {
  const auto usable = [](float value) { return std::abs(value) <= kAbsurd; };  // false for NaN
  members_.clear();
  for (std::uint32_t i = 0; i < matches.size(); ++i)
    if (usable(matches.left_x[i]) && usable(matches.left_y[i]) && usable(matches.right_x[i]) &&
        usable(matches.right_y[i]))
      members_.push_back(i);
  gather(matches, members_, usable_);
  sortByCoordinates(usable_, sorted_, scratch_);
  searched_.clear();
  for (const KeyedRow& entry : sorted_) searched_.push_back(entry.row);
  Random(0).shuffle(searched_);
  searched_.resize(std::min(searched_.size(), kMaxExamined));
  gather(usable_, searched_, sample_);
  selected_.resize(searched_.size());
  for (std::size_t i = 0; i < searched_.size(); ++i) selected_[i] = mask[members_[searched_[i]]];
}

/// Finds the homography that most of the matches in searched_ agree with, and leaves the others there.
bool SecondRelation::findHomography(cv::Matx33d& homography) {
  if (searched_.size() < kMinPlaces) return false;
  PlanesOptions options;
  options.max_iterations = kHypotheses;
  options.max_planes = 1;
  const HomographyModel model;
  const SearchParts parts = {model, workspace_->part<LocalProposal>()};
  Selection remarks;
  planes_.find(sample_, searched_, nullptr, parts, options, Deadline(0), *workspace_, remarks);
  homography = planes_.model();
  return planes_.planes() > 0;
}

bool SecondRelation::findFirst(const Selection& selection) {
  if (selection.model_kind == ModelKind::kHomography) {
    first_ = selection.model;
    return true;
  }
  searched_.clear();
  for (std::uint32_t row = 0; row < sample_.size(); ++row)
    if (selected_[row] != 0) searched_.push_back(row);
  searched_.resize(std::min(searched_.size(), kMaxSearched));
  return findHomography(first_);
}

/// Finds out which matches are near the first relation. @return whether there are enough of the selected ones
bool SecondRelation::sortByShift() {
  agreeing_.clear();
  far_.clear();
  shift_.resize(sample_.size());
  std::size_t others = 0;
  for (std::uint32_t row = 0; row < sample_.size(); ++row) {
    const cv::Point2d p = predicted(first_, row);
    const cv::Point2d shift(sample_.right_x[row] - p.x, sample_.right_y[row] - p.y);
    shift_[row] = shift;
    if (!(shift.dot(shift) < kAbsurd * kAbsurd)) continue;
    const bool far = shift.dot(shift) > displaced_ * displaced_;
    if (far) far_.push_back(row);
    if (selected_[row] == 0) continue;
    if (far)
      ++others;
    else
      agreeing_.push_back(row);
  }
  return static_cast<double>(agreeing_.size()) >= kMinPlane * static_cast<double>(agreeing_.size() + others);
}

/// Takes the matches far from the first relation of whose nearest ones some have the same shift.
void SecondRelation::takeSupported() {
  supported_.clear();
  const std::size_t n = far_.size();
  if (n <= kNearest) return;
  gather(sample_.left_x, far_, x_);
  gather(sample_.left_y, far_, y_);
  neighbours_.build(x_.data(), y_.data(), n, kNearest + 1);
  near_.resize(n * (kNearest + 1));
  neighbours_.nearestToAll(x_.data(), y_.data(), n, kNearest + 1, near_.data());
  for (std::size_t i = 0; i < n; ++i) {
    const cv::Point2f own = shift_[far_[i]];
    const double tolerance = std::max(0.5 * displaced_, kSameShift * std::hypot(own.x, own.y));
    int supporters = -1;  // without the match itself
    for (std::size_t k = i * (kNearest + 1); k < (i + 1) * (kNearest + 1); ++k) {
      const cv::Point2f other = shift_[far_[near_[k]]];
      supporters += std::hypot(other.x - own.x, other.y - own.y) <= tolerance ? 1 : 0;
    }
    if (supporters >= kSupporters) supported_.push_back(far_[i]);
  }
}

/// Whether enough of the supported matches have matches of the first relation near them in one of the images.
/// This is a cheap test before the search; evaluate() decides.
bool SecondRelation::mayContest(std::size_t enough) {
  contested_.assign(sample_.size(), 0);
  addContested(sample_.left_x, sample_.left_y);
  addContested(sample_.right_x, sample_.right_y);
  return static_cast<std::size_t>(std::count(contested_.begin(), contested_.end(), 1)) >= enough;
}

void SecondRelation::addContested(const std::vector<float>& x, const std::vector<float>& y) {
  members_ = supported_;
  members_.insert(members_.end(), agreeing_.begin(), agreeing_.end());
  gather(x, members_, x_);
  gather(y, members_, y_);
  neighbours_.build(x_.data(), y_.data(), members_.size(), kNearest + 1);
  std::uint32_t near[kNearest + 1];
  for (std::size_t i = 0; i < supported_.size(); ++i) {
    const int found = neighbours_.nearest(x_[i], y_[i], kNearest + 1, near);
    const auto first = std::count_if(near, near + found, [&](auto k) { return k >= supported_.size(); });
    if (first >= kContesting) contested_[supported_[i]] = 1;
  }
}

/// Whether a match lies between what both relations predict for it.
bool SecondRelation::isBetween(const cv::Matx33d& second, std::uint32_t row) const {
  const cv::Point2d way = predicted(second, row) - predicted(first_, row);
  const cv::Point2d own = shift_[row];
  const double squared = way.dot(way), along = own.dot(way), across = own.cross(way);
  return along > 0.25 * squared && along < 0.75 * squared && std::abs(across) < 0.25 * squared;
}

/// The evidence for the relation that was just found over that for the first one; 0 if it does not contest
/// it.
double SecondRelation::evaluate(const cv::Matx33d& second) {
  of_first_.assign(sample_.size(), 0);
  of_second_.assign(sample_.size(), 0);
  std::size_t members = 0, between = 0;
  for (const std::uint32_t row : far_) {
    of_second_[row] = planes_.group()[row] == 0 ? 1 : 0;
    members += of_second_[row];
    between += isBetween(second, row) ? 1 : 0;
  }
  for (std::uint32_t row = 0; row < sample_.size(); ++row)
    of_first_[row] = selected_[row] != 0 && of_second_[row] == 0 ? 1 : 0;
  const std::size_t second_places = leftover_.distinctPlaces(of_second_);
  const std::size_t first_places = leftover_.distinctPlaces(of_first_);
  // Matches that agree with both relations contest neither.
  for (std::uint32_t row = 0; row < sample_.size(); ++row)
    if (planes_.errors()[row] <= displaced_ * displaced_) of_first_[row] = 0;
  // The smaller one of both must lie among the other one's matches.
  const bool smaller = second_places <= first_places;
  const std::size_t places = smaller ? second_places : first_places;
  const std::size_t coherent =
      smaller ? leftover_.coherent(of_second_, of_first_) : leftover_.coherent(of_first_, of_second_);
  const bool bounded = static_cast<double>(between) <= kMaxBetween * static_cast<double>(members);
  const bool contested = static_cast<double>(coherent) <= (1 - kMinContested) * static_cast<double>(places);
  if (places < kMinPlaces || !bounded || !contested) return 0;
  return static_cast<double>(second_places) / static_cast<double>(first_places);
}

double SecondRelation::examine(const Correspondences& matches, const Selection& selection,
                               Workspace& workspace) {
  workspace_ = &workspace;
  takeSample(matches, selection.mask);
  displaced_ = kDisplaced * LengthUnits::of(sample_).right;
  if (!findFirst(selection) || !sortByShift()) return 0;
  const auto enough =
      std::max(kMinPlaces, static_cast<std::size_t>(kMinShare * static_cast<double>(agreeing_.size())));
  takeSupported();
  if (supported_.size() < enough || !mayContest(enough)) return 0;
  leftover_.assign(sample_);
  searched_ = supported_;
  searched_.resize(std::min(searched_.size(), kMaxSearched));
  const std::size_t enough_left = std::min(enough, kMaxSearched / 4);
  double result = 0;
  for (int relation = 0; relation < kMaxRelations && searched_.size() >= enough_left; ++relation) {
    cv::Matx33d second;
    if (!findHomography(second)) break;
    result = std::max(result, evaluate(second));
  }
  return std::min(result, 1.0);
}

}  // namespace

double ambiguity(const Correspondences& matches, const Selection& selection, Workspace& workspace) {
  const bool nothing =
      std::all_of(selection.mask.begin(), selection.mask.end(), [](auto m) { return m == 0; });
  if (nothing) return std::numeric_limits<double>::quiet_NaN();
  return workspace.part<SecondRelation>().examine(matches, selection, workspace);
}

}  // namespace corrsel::core
