#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <map>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

#include "base/text.h"
#include "corrsel/camera.h"
#include "corrsel/correspondences.h"
#include "corrsel/options.h"
#include "corrsel/random.h"
#include "corrsel/selection.h"
#include "corrsel/selectors/selector.h"

// Generates selector input of every kind from bytes and checks the results against the contract. Used by the
// fuzzer and by the tests of all selectors.
namespace corrsel::core::testing {

/// Reads values from bytes. After the last byte, a generator seeded by the first four continues, so that a
/// few bytes already produce a rich input.
class ByteSource {
 public:
  ByteSource(const std::uint8_t* data, std::size_t size)
      : data_(data), size_(size), beyond_(seedOf(data, size)) {}

  std::uint8_t byte() {
    return position_ < size_ ? data_[position_++] : static_cast<std::uint8_t>(beyond_.next() >> 56);
  }

  std::uint32_t word() {
    std::uint32_t value = 0;
    for (int i = 0; i < 4; ++i) value = value << 8 | byte();
    return value;
  }

  /// @pre 0 < bound <= 65536
  std::uint32_t below(std::uint32_t bound) {
    const std::uint32_t high = bound > 256 ? byte() : 0U;
    return (high << 8 | byte()) % bound;
  }

  bool oneIn(std::uint32_t n) { return below(n) == 0; }

  /// A multiple of 1/65536 in [0, 1).
  double share() { return below(65536) / 65536.0; }

  /// Any bit pattern.
  float anyFloat() {
    const std::uint32_t bits = word();
    float value = 0;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  }

 private:
  static std::uint64_t seedOf(const std::uint8_t* data, std::size_t size) {
    std::uint64_t seed = size;
    for (std::size_t i = 0; i < std::min<std::size_t>(size, 4); ++i) seed = seed << 8 | data[i];
    return seed;
  }

  const std::uint8_t* data_;
  std::size_t size_, position_ = 0;
  Random beyond_;
};

inline constexpr float kSpecialFloats[] = {0.F,
                                           -0.F,
                                           1.F,
                                           -1.F,
                                           1e-40F,
                                           std::numeric_limits<float>::denorm_min(),
                                           std::numeric_limits<float>::min(),
                                           1e-20F,
                                           1e6F,
                                           -1e6F,
                                           1000000.0625F,
                                           999999.9375F,
                                           3e38F,
                                           -3e38F,
                                           std::numeric_limits<float>::infinity(),
                                           -std::numeric_limits<float>::infinity(),
                                           std::numeric_limits<float>::quiet_NaN(),
                                           16777216.F};

inline float specialFloat(ByteSource& source) {
  return kSpecialFloats[source.below(std::size(kSpecialFloats))];
}

/// Ways to generate the coordinates of a match.
enum class MatchKind : std::uint8_t {
  kPlane,
  kUnrelated,
  kStereo,
  kLattice,
  kLine,
  kSpecial,
  kAnyBits,
  kCount
};

/// Appends one match's coordinates, most of them inside an image of 640x480 px.
inline void addArbitraryMatch(ByteSource& source, MatchKind kind, Correspondences& m) {
  const auto within = [&source](float size) { return static_cast<float>(source.share()) * size; };
  std::array<float, 4> c = {within(640), within(480), 0, 0};
  switch (kind) {
    case MatchKind::kPlane:
      c[2] = 0.9F * c[0] - 0.1F * c[1] + 40 + within(2);
      c[3] = 0.1F * c[0] + 0.95F * c[1] + 5 + within(2);
      break;
    case MatchKind::kUnrelated:
      c[2] = within(640);
      c[3] = within(480);
      break;
    case MatchKind::kStereo:
      c[2] = c[0] - within(60);
      c[3] = c[1] + within(1);
      break;
    case MatchKind::kLattice:
      for (float& value : c) value = 40.F * static_cast<float>(source.below(6));
      break;
    case MatchKind::kLine:
      c[1] = 2 * c[0];
      c[2] = c[0] + 10;
      c[3] = c[1] - 10;
      break;
    case MatchKind::kSpecial:
      for (float& value : c) value = specialFloat(source);
      break;
    default:
      for (float& value : c) value = source.anyFloat();
  }
  m.left_x.push_back(c[0]);
  m.left_y.push_back(c[1]);
  m.right_x.push_back(c[2]);
  m.right_y.push_back(c[3]);
}

inline float arbitraryDistance(ByteSource& source) {
  switch (source.below(8)) {
    case 0:
      return specialFloat(source);
    case 1:
      return static_cast<float>(source.below(4));
    default:
      return static_cast<float>(source.share()) * 300.F;
  }
}

inline AffineFrame arbitraryFrame(ByteSource& source, float x, float y) {
  const auto entry = [&source] { return static_cast<float>(source.share()) * 40.F - 20.F; };
  AffineFrame frame = {entry(), entry(), x, entry(), entry(), y};
  switch (source.below(8)) {
    case 0:  // singular
      frame[3] = frame[0];
      frame[4] = frame[1];
      break;
    case 1:
      frame = {0, 0, x, 0, 0, y};
      break;
    case 2:
      for (float& value : frame) value = specialFloat(source);
      break;
    case 3:
      for (float& value : frame) value = source.anyFloat();
      break;
    default:;
  }
  return frame;
}

/// Length of an optional column: mostly that of the matches, often 0, rarely a wrong one.
inline std::size_t arbitraryLength(ByteSource& source, std::size_t n) {
  const std::uint32_t choice = source.below(64);
  if (choice == 0) return n + 1;
  if (choice == 1) return n / 2;
  return choice < 16 ? 0 : n;
}

inline cv::Size arbitrarySize(ByteSource& source) {
  constexpr int kSides[] = {640, 480, 800, 1, 0, -1, 100000, std::numeric_limits<int>::max()};
  if (!source.oneIn(4)) return {640, 480};
  const int width = kSides[source.below(std::size(kSides))];
  return {width, kSides[source.below(std::size(kSides))]};
}

/// Mostly the usual value, varied a little; otherwise one that breaks careless code.
inline double arbitraryNumber(ByteSource& source, double usual) {
  constexpr double kAbsurd[] = {0, 1e10, -1e10, 1e300, -1e300, 1e-300, 5e-324, 1e160};
  switch (source.below(48)) {
    case 0:
      return specialFloat(source);
    case 1:
      return source.anyFloat();
    case 2:
      return kAbsurd[source.below(std::size(kAbsurd))];
    default:
      return usual * (0.5 + source.share());
  }
}

/// A camera of any model, among them those that do not pass Camera::check(): focal lengths of zero, absurd
/// distortion, NaN.
inline Camera arbitraryCamera(ByteSource& source) {
  constexpr double kUsual[] = {-0.3, 0.1, 0.001, 0.002, -0.05, 0.3, -0.2, 0.02};
  Camera camera;
  camera.model = static_cast<Camera::Model>(source.below(3));
  const bool panorama = camera.model == Camera::Model::kEquirectangular;
  camera.matrix(0, 0) = arbitraryNumber(source, 500);
  camera.matrix(1, 1) = arbitraryNumber(source, 500);
  camera.matrix(0, 2) = arbitraryNumber(source, 320);
  camera.matrix(1, 2) = arbitraryNumber(source, 240);
  if (source.oneIn(8)) camera.matrix(0, 1) = arbitraryNumber(source, 1);
  if (source.oneIn(64)) camera.matrix(2, 1) = arbitraryNumber(source, 1);
  std::size_t coefficients = panorama ? 0 : camera.model == Camera::Model::kFisheye ? 4 : source.below(9);
  if (source.oneIn(32)) coefficients = camera.distortion.size();
  for (std::size_t i = 0; i < coefficients; ++i) {
    camera.distortion[i] = arbitraryNumber(source, kUsual[i]);
  }
  if (panorama || source.oneIn(2)) camera.size = arbitrarySize(source);
  return camera;
}

/// Gives matches no camera, one or two of them.
inline void addArbitraryCameras(ByteSource& source, Correspondences& m) {
  if (source.oneIn(2)) m.left_camera = arbitraryCamera(source);
  if (m.left_camera.has_value() != source.oneIn(8)) m.right_camera = arbitraryCamera(source);
}

/// Describes the first fault of the rays of a camera: one that is neither of unit length nor NaN, a Jacobian
/// that does not fit it, a projection that is not finite. Empty if there is none.
inline std::string cameraFault(const Camera& camera, const cv::Point2d& pixel, const cv::Vec3d& point) {
  Ray ray;
  cv::Point2d image;
  const bool exists = unproject(camera, pixel, ray);
  for (const double value : ray.direction.val) {
    if (std::isnan(value) == exists)
      return "a ray that exists is NaN, or one that does not exist is a number";
  }
  for (const double value : ray.jacobian.val) {
    if (std::isfinite(value) != exists) return "the Jacobian does not fit the ray";
  }
  if (exists && !(std::isfinite(pixel.x) && std::isfinite(pixel.y)))
    return "a pixel that is not finite has a ray";
  if (exists && !(std::abs(ray.direction.dot(ray.direction) - 1) < 1e-9))
    return "a ray is not of unit length";
  if (project(camera, point, image) && !(std::isfinite(image.x) && std::isfinite(image.y))) {
    return "a point is projected to a place that is not finite";
  }
  return "";
}

/// Generates matches of many kinds: planes, stereo, lattices, duplicates, NaN and infinite values, columns
/// that are absent or of a wrong length, image sizes that are unknown or absurd.
inline Correspondences arbitraryMatches(ByteSource& source, std::size_t max_matches = 300) {
  Correspondences m;
  const std::size_t n = source.below(static_cast<std::uint32_t>(max_matches + 1));
  constexpr auto kKinds = static_cast<std::uint32_t>(MatchKind::kCount);
  const auto usual = static_cast<MatchKind>(source.below(kKinds));
  const std::uint32_t other_in = 1 + source.below(64), copy_in = 1 + source.below(64);
  while (m.size() < n) {
    if (!m.empty() && copy_in > 1 && source.oneIn(copy_in)) {
      const std::size_t row = source.below(static_cast<std::uint32_t>(m.size()));
      for (std::vector<float>* column : {&m.left_x, &m.left_y, &m.right_x, &m.right_y}) {
        column->push_back((*column)[row]);
      }
      continue;
    }
    const bool other = other_in > 1 && source.oneIn(other_in);
    addArbitraryMatch(source, other ? static_cast<MatchKind>(source.below(kKinds)) : usual, m);
  }
  m.left_size = arbitrarySize(source);
  m.right_size = arbitrarySize(source);
  for (std::vector<float>* column : {&m.distance, &m.second_distance}) {
    column->resize(arbitraryLength(source, n));
    for (float& value : *column) value = arbitraryDistance(source);
  }
  m.left_frame.resize(arbitraryLength(source, n));
  m.right_frame.resize(arbitraryLength(source, n));
  for (std::size_t i = 0; i < m.left_frame.size(); ++i) {
    m.left_frame[i] = arbitraryFrame(source, i < n ? m.left_x[i] : 0, i < n ? m.left_y[i] : 0);
  }
  for (std::size_t i = 0; i < m.right_frame.size(); ++i) {
    m.right_frame[i] = arbitraryFrame(source, i < n ? m.right_x[i] : 0, i < n ? m.right_y[i] : 0);
  }
  for (std::vector<std::uint32_t>* column : {&m.left_index, &m.right_index}) {
    column->resize(arbitraryLength(source, n));
    for (std::uint32_t& value : *column) value = source.oneIn(8) ? source.word() : source.below(300);
  }
  // A coordinate column of another length than left_x.
  if (source.oneIn(64)) m.right_y.resize(n / 2);
  m.probability.resize(arbitraryLength(source, n));
  for (float& value : m.probability) {
    value = source.oneIn(32) ? std::numeric_limits<float>::quiet_NaN() : float(source.below(101)) / 100;
  }
  if (!m.probability.empty() && source.oneIn(16)) m.probability.front() = arbitraryDistance(source);
  return m;
}

/// Draws values for some of the options, within their ranges. Whole numbers are kept small enough for a call
/// to take a fraction of a second. Time limits keep their values, because results would depend on the clock.
class ArbitraryOptions : public OptionVisitor {
 public:
  explicit ArbitraryOptions(ByteSource& source) : source_(source) {}

  void field(OptionField field) override {
    const bool repeats = field.name.find("iterations") != std::string::npos;
    const bool per_match = field.name.find("_per_match") != std::string::npos;
    if (field.unit == "s" || (!repeats && source_.oneIn(2))) return;
    std::string& value = values[field.name];
    switch (field.type) {
      case OptionType::kNumber:
        value = formatNumber(between(field.min, field.max));
        break;
      case OptionType::kInteger: {
        // 0 iterations would mean as many as the selector likes.
        const double least = repeats ? std::max(1.0, field.min) : field.min;
        const double greatest = std::min(field.max, repeats ? 300.0 : per_match ? 10.0 : 2000.0);
        value = std::to_string(static_cast<int>(between(least, std::max(least, greatest))));
        break;
      }
      case OptionType::kFlag:
        value = source_.oneIn(2) ? "true" : "false";
        break;
      case OptionType::kChoice:
        value = field.choices[source_.below(static_cast<std::uint32_t>(field.choices.size()))].name;
        break;
      case OptionType::kText:
        break;
    }
  }

  OptionMap values;

 private:
  double between(double min, double max) {
    switch (source_.below(8)) {
      case 0:
        return min;
      case 1:
        return max;
      case 2:
      case 3:
        return min + (max - min) * source_.share();
      default:  // near the lower end, where most ranges have their usual values
        return min + (max - min) * std::pow(source_.share(), 6);
    }
  }

  ByteSource& source_;
};

inline OptionMap arbitraryOptions(ByteSource& source, const Selector& selector) {
  ArbitraryOptions drawn(source);
  selector.options().visit(drawn);
  return drawn.values;
}

inline bool sameBits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0);
}

/// Describes the first difference between two results, compared bit by bit without their times; empty if
/// there is none.
inline std::string difference(const Selection& a, const Selection& b) {
  if (a.status != b.status) return "status " + toString(a.status) + " and " + toString(b.status);
  if (a.message != b.message) return "message '" + a.message + "' and '" + b.message + "'";
  if (toString(a.scene) != toString(b.scene)) return "scenes differ";
  if (std::memcmp(&a.confidence, &b.confidence, sizeof a.confidence) != 0) return "confidences differ";
  if (std::memcmp(&a.sigma, &b.sigma, sizeof a.sigma) != 0) return "sigmas differ";
  if (!sameBits(a.probability, b.probability)) return "probabilities differ";
  if (a.mask != b.mask) return "masks differ";
  if (!sameBits(a.score, b.score)) return "scores differ";
  if (a.model_kind != b.model_kind) return "model kinds differ";
  if (std::memcmp(a.model.val, b.model.val, sizeof a.model.val) != 0) return "models differ";
  if (a.iterations != b.iterations) return "numbers of iterations differ";
  if (a.n_selected != b.n_selected || a.n_ignored != b.n_ignored) return "counts differ";
  return "";
}

/// Whether both rays of a match exist. Without cameras, there are none to miss.
inline bool hasRays(const Correspondences& m, std::size_t i) {
  if (!m.left_camera || !m.right_camera) return true;
  Ray ray;
  return unproject(*m.left_camera, cv::Point2d(m.left_x[i], m.left_y[i]), ray) &&
         unproject(*m.right_camera, cv::Point2d(m.right_x[i], m.right_y[i]), ray);
}

/// Describes the first violation of Selector's contract by a result; empty if there is none.
inline std::string contractViolation(const Correspondences& m, const Selection& s) {
  const std::size_t n = m.size();
  const bool consistent = m.inconsistency().empty();
  if (s.n_input != n) return "n_input is " + std::to_string(s.n_input);
  if (s.mask.size() != n) return "the mask has " + std::to_string(s.mask.size()) + " rows";
  if (!s.score.empty() && s.score.size() != n)
    return "there are " + std::to_string(s.score.size()) + " scores";
  std::size_t selected = 0, ignored = 0, without_ray = 0;
  for (std::size_t i = 0; i < n; ++i) {
    if (s.mask[i] > 1) return "the mask holds " + std::to_string(s.mask[i]);
    selected += s.mask[i];
    if (!consistent) continue;
    const float coordinates[] = {m.left_x[i], m.left_y[i], m.right_x[i], m.right_y[i]};
    const bool usable = std::all_of(std::begin(coordinates), std::end(coordinates),
                                    [](float value) { return std::abs(value) <= 1e6F; });
    without_ray += usable && !hasRays(m, i) ? 1 : 0;
    if (usable) continue;
    ++ignored;
    if (s.mask[i] != 0) return "row " + std::to_string(i) + " is selected and not usable";
    if (!s.score.empty() && !std::isnan(s.score[i])) return "row " + std::to_string(i) + " has a score";
    if (!s.probability.empty() && s.probability[i] != 0)
      return "row " + std::to_string(i) + " has a probability";
  }
  if (s.n_selected != selected) return "n_selected is " + std::to_string(s.n_selected);
  if (!consistent && s.status != Status::kUnsupportedInput) return "columns of different length pass";
  // Calibrated selectors ignore matches without a ray as well.
  if (s.status != Status::kUnsupportedInput && s.n_ignored != ignored &&
      s.n_ignored != ignored + without_ray) {
    return "n_ignored is " + std::to_string(s.n_ignored);
  }
  if (s.status != Status::kOk && s.message.empty()) return "no message with status " + toString(s.status);
  if (s.status == Status::kFailed) return "failed: " + s.message;
  const bool nothing = s.status == Status::kTooFew || s.status == Status::kNoModel ||
                       s.status == Status::kUnsupportedInput || s.status == Status::kTooLarge;
  if (nothing && selected > 0) return "matches are selected with status " + toString(s.status);
  if (s.model_kind != ModelKind::kNone) {
    double sum = 0;
    for (const double value : s.model.val) sum += std::abs(value);
    if (!(std::isfinite(sum) && sum > 0)) return "the model is zero or not finite";
  }
  if (s.confidence < 0 || std::isinf(s.confidence)) return "the confidence is negative or infinite";
  if (s.sigma < 0 || std::isinf(s.sigma)) return "sigma is negative or infinite";
  if (!s.probability.empty() && s.probability.size() != n)
    return "there are " + std::to_string(s.probability.size()) + " probabilities";
  for (const float probability : s.probability)
    if (!(probability >= 0 && probability <= 1)) return "a probability is " + std::to_string(probability);
  if (s.iterations < 0 || !(s.seconds >= 0)) return "iterations or seconds are negative";
  return "";
}

}  // namespace corrsel::core::testing
