#include "corrsel/gyroscope.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>

#include "geometry/rotation_vector.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kMinBlocks = 8, kMaxBlocks = 64;  // of rest
constexpr std::size_t kMaxSamples = 100000;             // whatever the rate is

double seconds(std::int64_t nanoseconds) { return 1e-9 * static_cast<double>(nanoseconds); }

cv::Vec3d meanOf(const std::deque<cv::Vec3d>& values) {
  cv::Vec3d sum;
  for (const cv::Vec3d& value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

double squared(double value) { return value * value; }

}  // namespace

void GyroscopeOptions::visit(OptionVisitor& visitor) const {
  using P = GyroscopeOptions;
  visitor.number({"window", 0.1, 1000, "s", "Time after which samples are forgotten"}, &P::window);
  visitor.number({"max_gap", 1e-4, 10, "s", "Longest time between two samples that is bridged"}, &P::max_gap);
  visitor.number({"noise_density", 0, 1, "rad/s/sqrt(Hz)", "White noise of each rate"}, &P::noise_density);
  visitor.number(
      {"scale_error", 0, 1, "-", "Error of scale and alignment of the axes, as share of the angle turned"},
      &P::scale_error);
  visitor.number({"stamp_error", 0, 1, "s", "Error of the stamps against those of the images"},
                 &P::stamp_error);
  visitor.number(
      {"unknown_bias", 0, 10, "rad/s", "Standard deviation of the bias until the gyroscope was at rest"},
      &P::unknown_bias);
  visitor.number({"max_bias", 0, 10, "rad/s", "Largest bias; what turns faster is not at rest"},
                 &P::max_bias);
  visitor.number({"max_rest_change", 0, 10, "rad/s",
                  "Largest change at rest of the mean rate of an eighth of rest_time"},
                 &P::max_rest_change);
  visitor.number({"rest_time", 0.01, 1000, "s", "Time that rest must last before it gives the bias"},
                 &P::rest_time);
}

Gyroscope::Gyroscope(const GyroscopeOptions& options) : options_(options) {
  options_.check();
  bias_.sigma = options_.unknown_bias;
}

bool Gyroscope::add(std::int64_t stamp, const cv::Vec3d& rate) {
  if (!cv::checkRange(cv::Mat(rate, false))) return false;
  if (!samples_.empty()) {
    if (stamp == samples_.back().stamp) return true;
    if (stamp < samples_.back().stamp) restart();
  }
  samples_.push_back({stamp, rate});
  while (seconds(stamp - samples_.front().stamp) > options_.window || samples_.size() > kMaxSamples) {
    samples_.pop_front();
  }
  addToRest(samples_.back());
  return true;
}

void Gyroscope::restart() {
  samples_.clear();
  blocks_.clear();
  block_size_ = 0;
}

void Gyroscope::addToRest(const Sample& sample) {
  const double block = options_.rest_time / static_cast<double>(kMinBlocks);
  if (samples_.size() > 1 &&
      seconds(sample.stamp - samples_[samples_.size() - 2].stamp) > std::max(options_.max_gap, block)) {
    blocks_.clear();
    block_size_ = 0;
  }
  if (block_size_ > 0 && seconds(sample.stamp - block_begin_) >= block) closeBlock();
  if (block_size_ == 0) {
    block_begin_ = sample.stamp;
    block_sum_ = cv::Vec3d();
  }
  block_sum_ += sample.rate;
  ++block_size_;
}

void Gyroscope::closeBlock() {
  blocks_.push_back(block_sum_ / static_cast<double>(block_size_));
  block_size_ = 0;
  if (blocks_.size() > kMaxBlocks) blocks_.pop_front();
  const cv::Vec3d mean = meanOf(blocks_);
  double variance = 0;
  bool rest = cv::norm(mean) <= options_.max_bias;
  for (const cv::Vec3d& value : blocks_) {
    const cv::Vec3d change = value - mean;
    rest = rest && cv::norm(change, cv::NORM_INF) <= options_.max_rest_change;
    variance += change.dot(change) / 3;
  }
  if (!rest) {  // the newest one has moved: rest may begin with it
    blocks_.erase(blocks_.begin(), blocks_.end() - 1);
    return;
  }
  const std::size_t n = blocks_.size();
  if (n < kMinBlocks) return;
  if (n == kMinBlocks) bias_before_ = bias_;
  const double count = static_cast<double>(n);
  const double doubt = bias_before_.known ? cv::norm(mean - bias_before_.rate) : 0.0;
  bias_ = {mean, std::max(std::sqrt(variance / (count * (count - 1))), doubt), true};
}

std::optional<std::int64_t> Gyroscope::newest() const {
  return samples_.empty() ? std::nullopt : std::make_optional(samples_.back().stamp);
}

/// @pre the samples cover the moment
cv::Vec3d Gyroscope::rateAt(std::int64_t stamp) const {
  const auto next =
      std::lower_bound(samples_.begin(), samples_.end(), stamp,
                       [](const Sample& sample, std::int64_t value) { return sample.stamp < value; });
  if (next == samples_.begin()) return next->rate;
  const Sample& before = *(next - 1);
  const double share = seconds(stamp - before.stamp) / seconds(next->stamp - before.stamp);
  return before.rate + share * (next->rate - before.rate);
}

std::optional<Gyroscope::Turn> Gyroscope::between(std::int64_t from, std::int64_t to) const {
  if (from < to) {
    std::optional<Turn> back = between(to, from);
    if (back) back->rotation = back->rotation.t();
    return back;
  }
  if (samples_.empty() || to < samples_.front().stamp || from > samples_.back().stamp) return std::nullopt;
  const auto upper =
      std::upper_bound(samples_.begin(), samples_.end(), to,
                       [](std::int64_t value, const Sample& sample) { return value < sample.stamp; });
  // The gap that an end lies in counts as a whole.
  std::int64_t sampled = upper == samples_.begin() ? to : (upper - 1)->stamp;
  const Sample first = {to, rateAt(to)}, last = {from, rateAt(from)};
  Sample before = first;
  Turn turn = {cv::Matx33d::eye(), 0};
  double variance = 0, angle = 0;
  for (auto next = upper; before.stamp < from; ++next) {
    if (seconds(next->stamp - sampled) > options_.max_gap) return std::nullopt;
    sampled = next->stamp;
    const Sample end = next->stamp < from ? *next : last;
    const double time = seconds(end.stamp - before.stamp);
    const cv::Vec3d step = (0.5 * (before.rate + end.rate) - bias_.rate) * time;
    turn.rotation = turn.rotation * rotationFromVector(step);
    angle += cv::norm(step);
    variance += squared(time * cv::norm(end.rate - before.rate)) / 12;
    before = end;
  }
  const double duration = seconds(from - to);
  variance += squared(options_.noise_density) * duration + squared(bias_.sigma * duration) +
              squared(options_.scale_error * angle) +
              squared(options_.stamp_error * cv::norm(last.rate - first.rate));
  turn.sigma = std::sqrt(variance);
  return turn;
}

}  // namespace corrsel::core
