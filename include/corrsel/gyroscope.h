#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <opencv2/core/matx.hpp>
#include <optional>

#include "corrsel/options.h"

namespace corrsel::core {

struct GyroscopeOptions : OptionSet {
  double window = 10;             ///< s; what is older is forgotten
  double max_gap = 0.05;          ///< s; a longer one between two samples is not bridged
  double noise_density = 1e-3;    ///< of white noise of each rate, rad/s/sqrt(Hz)
  double scale_error = 0.01;      ///< of the angle turned: scale and alignment of the axes, share of it
  double stamp_error = 0.002;     ///< of the stamps against those of the images, s
  double unknown_bias = 0.05;     ///< standard deviation of the bias until rest was seen, rad/s
  double max_bias = 0.15;         ///< rad/s; faster is never rest
  double max_rest_change = 0.02;  ///< rad/s; rest: no mean of an eighth of `rest_time` differs more
  double rest_time = 1;           ///< s that rest must last

  void visit(OptionVisitor& visitor) const override;
};

/// Finds the rotation between two moments from the angular rates that a gyroscope measured.
///
/// Idea: the rates are integrated, less the bias of the gyroscope, which is what it shows at rest.
///
/// Algorithm: between two samples the rate changes linearly, and its mean turns the frame by the exact
/// exponential; at both ends the rates are interpolated. For the bias, the means of eighths of `rest_time`
/// are formed. Where eight of them in a row are below `max_bias` and within `max_rest_change` of their common
/// mean, the gyroscope is at rest, and the bias is the mean of up to 64 of them. Its standard deviation is
/// that of the mean, or the difference from the bias of the rest before, if that is larger.
///
/// The standard deviation of the rotation contains the noise, the bias, `scale_error` of the angle,
/// `stamp_error` times the change of the rate, and for every interval what the course of the rate between the
/// samples may be.
///
/// Input: rates in any order of magnitude of frequency, stamps in ns of any clock. Samples may be missing.
///
/// Options: GyroscopeOptions.
///
/// Failure: a turn that is slow and perfectly even looks like rest; the next rest corrects the bias, and
/// until the one after that the standard deviation shows the doubt. A stamp before that of the sample before
/// it (a clock that was set, a bag that starts again) drops all samples; the bias is kept.
///
/// Cost: add() takes O(1), between() O(samples between the moments), memory O(window).
///
/// Source: own work; the integration is that of Bortz, A New Mathematical Formulation for Strapdown Inertial
/// Navigation, IEEE Transactions on Aerospace and Electronic Systems 1971, for a constant rate.
///
/// Not thread-safe.
class Gyroscope {
 public:
  struct Bias {
    cv::Vec3d rate;      ///< rad/s
    double sigma = 0;    ///< standard deviation of each coordinate, rad/s
    bool known = false;  ///< rest was seen
  };
  struct Turn {
    cv::Matx33d rotation;  ///< a direction d in the frame at `from` is R d in the frame at `to`
    double sigma = 0;      ///< standard deviation about every axis, rad
  };

  /// Throws std::invalid_argument for options out of range.
  explicit Gyroscope(const GyroscopeOptions& options = {});

  /// Adds a sample. One with the stamp of the sample before it is skipped.
  /// @param stamp  ns. @param rate  in the frame of the gyroscope, rad/s
  /// @return false if the rate is not finite; then it is skipped
  bool add(std::int64_t stamp, const cv::Vec3d& rate);

  /// The rotation of the gyroscope's frame between two moments, ns, in either order; nothing where the
  /// samples do not cover the time between them.
  std::optional<Turn> between(std::int64_t from, std::int64_t to) const;

  /// The newest stamp, ns; nothing where there are no samples.
  std::optional<std::int64_t> newest() const;

  const Bias& bias() const { return bias_; }

 private:
  struct Sample {
    std::int64_t stamp;
    cv::Vec3d rate;
  };

  cv::Vec3d rateAt(std::int64_t stamp) const;
  void addToRest(const Sample& sample);
  void closeBlock();
  void restart();

  GyroscopeOptions options_;
  std::deque<Sample> samples_;  ///< of the last seconds, oldest first
  Bias bias_;
  Bias bias_before_;              ///< that of the rest before
  std::deque<cv::Vec3d> blocks_;  ///< means of the rates in a row that may be rest, oldest first
  std::int64_t block_begin_ = 0;
  cv::Vec3d block_sum_;
  std::size_t block_size_ = 0;
};

}  // namespace corrsel::core
