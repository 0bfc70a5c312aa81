#include "corrsel/features/sequence.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <stdexcept>
#include <utility>

namespace corrsel::core {

void SequenceOptions::visit(OptionVisitor& visitor) {
  visitor.choice("reference", {"previous", "keyframe"}, "Sequence: the frame that new ones are compared with",
                 reference);
  visitor.integer({"step", 1, 100, "frames", "Sequence, previous: so many processed frames ago"}, step);
  visitor.number(
      {"min_overlap", 0, 1, "-", "Sequence, keyframe: renewed when less than this share of it is seen again"},
      min_overlap);
  visitor.number({"ratio", 0, 1, "-",
                  "Sequence, keyframe: matches with at most this ratio of distances show what is seen again"},
                 ratio);
}

Sequence::Sequence(const SequenceOptions& options) : options_(options) { options_.check(); }

void Sequence::setOptions(const SequenceOptions& options) {
  options.check();
  const bool keyframes = options.reference == "keyframe";
  if (keyframes != (options_.reference == "keyframe")) {
    keyframe_.reset();
    if (keyframes && !frames_.empty() && !frames_.back().features->keypoints.empty()) {
      keyframe_ = frames_.back();
    }
  }
  options_ = options;
  trim();
}

const Sequence::Frame* Sequence::reference() const {
  if (options_.reference == "keyframe") return keyframe_ ? &*keyframe_ : nullptr;
  const auto step = static_cast<std::size_t>(options_.step);
  return frames_.size() < step ? nullptr : &frames_[frames_.size() - step];
}

void Sequence::add(Frame frame, const Correspondences& matches) {
  if (frame.features == nullptr) {
    throw std::invalid_argument("frame " + std::to_string(frame.id) + " has no pointer to features");
  }
  const Frame* const compared = reference();
  last_overlap_ = compared ? overlap(matches, *compared->features, options_.ratio)
                           : std::numeric_limits<double>::quiet_NaN();
  if (options_.reference == "keyframe" && !frame.features->keypoints.empty() &&
      (!keyframe_ || last_overlap_ < options_.min_overlap)) {
    keyframe_ = frame;
  }
  frames_.push_back(std::move(frame));
  trim();
}

void Sequence::trim() {
  const auto most = options_.reference == "keyframe" ? 1 : static_cast<std::size_t>(options_.step);
  while (frames_.size() > most) frames_.pop_front();
}

void Sequence::reset() {
  frames_.clear();
  keyframe_.reset();
  last_overlap_ = std::numeric_limits<double>::quiet_NaN();
}

double overlap(const Correspondences& matches, const Features& reference, double ratio) {
  constexpr int kSide = 8;
  enum Cell : char { kEmpty, kFeatures, kSeen };
  std::array<Cell, kSide * kSide> cells{};
  const auto cellAt = [&](float x, float y) -> Cell& {
    const auto along = [](float position, int length) {
      return std::clamp(static_cast<int>((position + 0.5F) * kSide / static_cast<float>(length)), 0,
                        kSide - 1);
    };
    return cells[static_cast<std::size_t>(along(y, reference.image_size.height) * kSide +
                                          along(x, reference.image_size.width))];
  };
  for (const cv::KeyPoint& keypoint : reference.keypoints) cellAt(keypoint.pt.x, keypoint.pt.y) = kFeatures;
  const bool distances = !matches.distance.empty() && !matches.second_distance.empty();
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (distances && !(matches.distance[i] <= ratio * matches.second_distance[i])) continue;
    Cell& cell = cellAt(matches.right_x[i], matches.right_y[i]);
    if (cell == kFeatures) cell = kSeen;
  }
  const auto seen = std::count(cells.begin(), cells.end(), kSeen);
  const auto filled = seen + std::count(cells.begin(), cells.end(), kFeatures);
  return filled == 0 ? std::numeric_limits<double>::quiet_NaN()
                     : static_cast<double>(seen) / static_cast<double>(filled);
}

}  // namespace corrsel::core
