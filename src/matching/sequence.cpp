#include "corrsel/matching/sequence.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <stdexcept>
#include <utility>
#include <vector>

namespace corrsel::core {

void SequenceOptions::visit(OptionVisitor& visitor) const {
  visitor.choice("reference",
                 {{Reference::kPrevious, "previous", "The one sequence_step frames ago"},
                  {Reference::kKeyframe, "keyframe", "One that stays until too little of it is seen again"}},
                 "Sequence: the frame that new ones are compared with", &SequenceOptions::reference);
  visitor.integer({"step", 1, 100, "frames", "Sequence, previous: so many processed frames ago"},
                  &SequenceOptions::step);
  visitor.number(
      {"min_overlap", 0, 1, "-", "Sequence, keyframe: renewed when less than this share of it is seen again"},
      &SequenceOptions::min_overlap);
  visitor.number({"ratio", 0, 1, "-",
                  "Sequence, keyframe: matches with at most this ratio of distances show what is seen again"},
                 &SequenceOptions::ratio);
}

Sequence::Sequence(const SequenceOptions& options) : options_(options) { options_.check(); }

void Sequence::setOptions(const SequenceOptions& options) {
  options.check();
  const bool changes = options.reference != options_.reference;
  options_ = options;
  if (changes) {
    keyframe_.reset();
    if (keyframes() && !frames_.empty() && !frames_.back().features->keypoints.empty()) {
      keyframe_ = frames_.back();
    }
  }
  trim();
}

const Sequence::Frame* Sequence::reference() const {
  if (keyframes()) return keyframe_ ? &*keyframe_ : nullptr;
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
  if (keyframes() && !frame.features->keypoints.empty() &&
      (!keyframe_ || last_overlap_ < options_.min_overlap)) {
    keyframe_ = frame;
  }
  frames_.push_back(std::move(frame));
  trim();
}

void Sequence::trim() {
  const auto max_frames = keyframes() ? 1 : static_cast<std::size_t>(options_.step);
  while (frames_.size() > max_frames) frames_.pop_front();
}

void Sequence::reset() {
  frames_.clear();
  keyframe_.reset();
  last_overlap_ = std::numeric_limits<double>::quiet_NaN();
}

double overlap(const Correspondences& matches, const Features& reference, double ratio) {
  constexpr int kSide = 8;
  // At a ratio of 0.8 outliers hit some 5 % of the features.
  constexpr double kSeen = 0.15;
  if (!matches.empty() && matches.right_index.empty()) {
    throw std::invalid_argument("overlap: the matches carry no feature numbers");
  }
  const std::size_t n = reference.keypoints.size();
  std::vector<char> found(n, 0);
  const bool distances = !matches.distance.empty() && !matches.second_distance.empty();
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const std::uint32_t right = matches.right_index[i];
    if (right >= n) {
      throw std::invalid_argument("overlap: match " + std::to_string(i) + " ends at feature " +
                                  std::to_string(right) + " of a reference with " + std::to_string(n) +
                                  "; the matches belong to another reference");
    }
    if (!distances || matches.distance[i] <= ratio * matches.second_distance[i]) found[right] = 1;
  }
  struct Cell {
    int features = 0, found = 0;
  };
  std::array<Cell, kSide * kSide> cells{};
  const auto along = [](float position, int length) {
    return static_cast<int>(
        std::clamp((position + 0.5F) * kSide / static_cast<float>(length), 0.0F, kSide - 1.0F));
  };
  for (std::size_t i = 0; i < n; ++i) {
    const cv::Point2f& at = reference.keypoints[i].pt;
    Cell& cell = cells[static_cast<std::size_t>(along(at.y, reference.image_size.height) * kSide +
                                                along(at.x, reference.image_size.width))];
    ++cell.features;
    cell.found += found[i];
  }
  int filled = 0, seen = 0;
  for (const Cell& cell : cells) {
    if (cell.features == 0) continue;
    ++filled;
    seen += cell.found >= kSeen * cell.features;
  }
  return filled == 0 ? std::numeric_limits<double>::quiet_NaN() : static_cast<double>(seen) / filled;
}

}  // namespace corrsel::core
