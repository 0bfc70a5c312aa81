#include "features/detectors/orb.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <memory>
#include <thread>
#include <utility>

#include "base/parallel.h"
#include "features/parts/feature_list.h"
#include "features/parts/image_pyramid.h"
#include "kernels/kernels.h"

namespace corrsel::core {

void OrbOptions::visit(OptionVisitor& visitor) const {
  visitCommon(visitor);
  visitor.number({"scale_factor", 1.05, 3, "-", "ORB: scale between pyramid levels"},
                 &OrbOptions::scale_factor);
  visitor.integer({"levels", 1, 16, "-", "ORB: levels of the pyramid"}, &OrbOptions::levels);
  visitor.integer({"fast_threshold", 0, 255, "grey levels", "ORB: smallest corner contrast"},
                  &OrbOptions::fast_threshold);
  visitor.integer({"patch_size", 5, 127, "px",
                   "ORB: side of the described patch; features nearer to the border are lost"},
                  &OrbOptions::patch_size);
}

namespace {

constexpr int kBandRows = 32;         // of a level that are searched at once
constexpr int kTileColumns = 64;      // of a band that are left out where the mask allows no place
constexpr std::size_t kPatches = 64;  // that a thread describes at once
constexpr double kHarrisWeight = 0.04;
// The scale of a derivative: Sobel's operator has the weight 4; sums over 7 px as OpenCV divides them.
constexpr double kHarrisUnit = 1.0 / (4 * 7 * 255);

/// How many times as many corners of a level as are wanted are ranked by Harris' measure; as in OpenCV's ORB.
constexpr int kRankedShare = 2;
constexpr int kScores = 256;

/// A corner of a level.
struct Corner {
  cv::Point2f place;  ///< px of the image
  float response;
  std::int32_t x, y, level;
};

/// The order of stronger().
bool strongerCorner(const Corner& a, const Corner& b) {
  if (a.response != b.response) return a.response > b.response;
  if (a.place.y != b.place.y) return a.place.y < b.place.y;
  return a.place.x != b.place.x ? a.place.x < b.place.x : a.level < b.level;
}

/// A band of a level, and its corners.
struct Band {
  int level, begin, end;
  std::vector<PixelPlace> places;
  std::vector<std::uint8_t> scores;
};

/// The numbers of corners of a level by their scores, while several threads find them.
class ScoreCounts {
 public:
  /// @param ranked  corners with the largest scores that will be ranked; 0 = all
  void start(int ranked) {
    ranked_ = ranked;
    found_ = 0;
    for (auto& count : counts_) count.store(0, std::memory_order_relaxed);
  }

  void add(const std::vector<std::uint8_t>& scores) {
    if (ranked_ == 0) return;
    for (const std::uint8_t score : scores) counts_[score].fetch_add(1, std::memory_order_relaxed);
    found_.fetch_add(static_cast<int>(scores.size()), std::memory_order_relaxed);
  }

  /// The largest score that at least `ranked` of the corners found so far reach, or 0. It only rises while
  /// corners are added, so corners below it cannot be ranked in the end either.
  int minScore() const {
    if (ranked_ == 0 || found_.load(std::memory_order_relaxed) < ranked_) return 0;
    int reached = 0;
    for (int score = kScores - 1; score > 0; --score) {
      reached += counts_[static_cast<std::size_t>(score)].load(std::memory_order_relaxed);
      if (reached >= ranked_) return score;
    }
    return 0;
  }

 private:
  int ranked_ = 0;
  std::atomic<int> found_{0};
  std::array<std::atomic<int>, kScores> counts_{};
};

/// Memory that is kept for the next image.
struct OrbMemory {
  ImagePyramid pyramid;
  std::vector<Band> bands;
  std::vector<std::unique_ptr<ScoreCounts>> counts;  ///< per level
  std::vector<std::vector<Corner>> corners;          ///< per level
  std::vector<Corner> all;
};

/// Memory of a thread.
struct BandMemory {
  std::vector<std::uint8_t> scores[3];
  std::vector<std::int32_t> columns;
};

struct RankingMemory {
  std::vector<PixelPlace> places;
  std::vector<StructureSums> sums;
};

float harrisResponse(const StructureSums& sums) {
  const double xx = sums.xx, yy = sums.yy, xy = sums.xy, trace = xx + yy;
  constexpr double kUnit = kHarrisUnit * kHarrisUnit * kHarrisUnit * kHarrisUnit;
  return static_cast<float>((xx * yy - xy * xy - kHarrisWeight * (trace * trace)) * kUnit);
}

/// The pixels [begin, end) of a row.
struct Span {
  int begin, end;
};

/// Whether corners may be allowed in a part of a level, px of the level.
bool mayHaveCorners(const PyramidLevel& level, const cv::Rect& part, const PlaceMask& mask) {
  const cv::Point2f first = level.toImage(part.x, part.y);
  const cv::Point2f last = level.toImage(part.br().x - 1, part.br().y - 1);
  const cv::Point corner(static_cast<int>(std::floor(first.x)), static_cast<int>(std::floor(first.y)));
  const cv::Point opposite(static_cast<int>(std::ceil(last.x)) + 1, static_cast<int>(std::ceil(last.y)) + 1);
  return mask.allowsAny({corner, opposite});
}

/// The columns of a band that are needed: those from which at most `reach` px lead to a place where corners
/// may be allowed.
/// @param rows   the band
/// @param inner  where corners are searched, px of the level
std::vector<Span> neededSpans(const PyramidLevel& level, const Span& rows, const cv::Rect& inner, int reach,
                              const PlaceMask& mask) {
  const int first = inner.x - reach, last = inner.br().x + reach;
  if (mask.everywhere()) return {{first, last}};
  std::vector<Span> spans;
  for (int x = first; x < last; x += kTileColumns) {
    const int end = std::min(x + kTileColumns, last);
    const cv::Rect around(x - reach, rows.begin - reach, end - x + 2 * reach,
                          rows.end - rows.begin + 2 * reach);
    if (!mayHaveCorners(level, around & inner, mask)) continue;
    if (!spans.empty() && spans.back().end == x) {
      spans.back().end = end;
    } else {
      spans.push_back({x, end});
    }
  }
  return spans;
}

/// Finds the corners of a band in some of its columns, whose scores are above a threshold.
void findCorners(const PyramidLevel& level, const Span& span, int threshold, const PlaceMask& mask,
                 Workspace& workspace, Band& band) {
  const CornerKernels& corners = kernels().corners;
  auto& memory = workspace.part<BandMemory>();
  // Corners are compared with their neighbours, so one more pixel is needed on each side.
  const int first = span.begin - 1, width = span.end - span.begin;
  for (auto& row : memory.scores) row.resize(static_cast<std::size_t>(width + 2 + kCornerPadding));
  memory.columns.resize(static_cast<std::size_t>(width));
  bool any[3] = {};
  const auto score = [&](int y) {
    any[y % 3] = corners.scores(level.pixels + y * level.stride + first, level.stride, width + 2, threshold,
                                memory.scores[y % 3].data());
  };
  score(band.begin - 1);
  score(band.begin);
  for (int y = band.begin; y < band.end; ++y) {
    score(y + 1);
    if (!any[y % 3]) continue;
    const auto row = [&](int at) { return memory.scores[at % 3].data() + 1; };
    const int found = corners.maxima(row(y - 1), row(y), row(y + 1), width, memory.columns.data());
    for (int i = 0; i < found; ++i) {
      const PixelPlace place{span.begin + memory.columns[static_cast<std::size_t>(i)], y};
      if (!mask.everywhere() && !mask.allows(level.toImage(place.x, place.y))) continue;
      band.places.push_back(place);
      band.scores.push_back(row(y)[memory.columns[static_cast<std::size_t>(i)]]);
    }
  }
}

/// Reduces the image and searches all bands, on several threads: the first one makes the levels, one after
/// the other; the others search the levels that are finished.
/// @param radius  of the patches that will be described
void searchLevels(const DetectionRequest& request, const OrbOptions& options, int radius, OrbMemory& memory) {
  const int levels = memory.pyramid.size(), border = options.patch_size;
  std::size_t count = 0;
  for (int level = 0; level < levels; ++level) {
    const PyramidLevel& pixels = memory.pyramid.level(level);
    // A narrow level has no column whose patch is inside it.
    if (pixels.width <= 2 * border) continue;
    const int last = pixels.height - border;
    for (int y = border; y < last; y += kBandRows, ++count) {
      if (memory.bands.size() <= count) memory.bands.emplace_back();
      Band& band = memory.bands[count];
      band.level = level;
      band.begin = y;
      band.end = std::min(y + kBandRows, last);
      band.places.clear();
      band.scores.clear();
    }
  }
  memory.bands.resize(count);
  std::atomic<bool> building{false};
  std::atomic<int> made{1};
  std::atomic<std::size_t> next{0};
  onThreads(std::min(count, static_cast<std::size_t>(std::max(1, request.threads))), [&] {
    Workspace& workspace = Workspace::ofThread();
    if (!building.exchange(true)) {
      for (int level = 1; level < levels; ++level) {
        memory.pyramid.reduce(level, workspace);
        made.store(level + 1, std::memory_order_release);
      }
    }
    for (std::size_t i = next++; i < count; i = next++) {
      Band& band = memory.bands[i];
      while (made.load(std::memory_order_acquire) <= band.level) std::this_thread::yield();
      const PyramidLevel& level = memory.pyramid.level(band.level);
      ScoreCounts& counts = *memory.counts[static_cast<std::size_t>(band.level)];
      const int threshold = std::max(options.fast_threshold, counts.minScore() - 1);
      const cv::Rect inner(border, border, level.width - 2 * border, level.height - 2 * border);
      for (const Span& span : neededSpans(level, {band.begin, band.end}, inner, 0, request.mask)) {
        findCorners(level, span, threshold, request.mask, workspace, band);
      }
      counts.add(band.scores);
      if (!request.describe) continue;
      // The patches of the first and of the last band reach beyond it.
      const Span rows{band.begin - (band.begin == inner.y ? radius : 0),
                      band.end + (band.end == inner.br().y ? radius : 0)};
      for (const Span& span : neededSpans(level, rows, inner, radius, request.mask)) {
        memory.pyramid.blur(
            band.level, {span.begin, rows.begin, span.end - span.begin, rows.end - rows.begin}, workspace);
      }
    }
  });
}

/// Ranks the corners of a level and keeps the `max_features` strongest ones; 0 = all.
void rankCorners(const OrbMemory& memory, int number, int max_features, Workspace& workspace,
                 std::vector<Corner>& corners) {
  const PyramidLevel& level = memory.pyramid.level(number);
  const int min_score = memory.counts[static_cast<std::size_t>(number)]->minScore();
  corners.clear();
  auto& [places, sums] = workspace.part<RankingMemory>();
  places.clear();
  for (const Band& band : memory.bands) {
    if (band.level != number) continue;
    for (std::size_t i = 0; i < band.places.size(); ++i) {
      if (band.scores[i] >= min_score) places.push_back(band.places[i]);
    }
  }
  sums.resize(places.size());
  kernels().corners.structure(level.pixels, level.stride, places.data(), places.size(), sums.data());
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const auto [x, y] = places[i];
    corners.push_back({level.toImage(x, y), harrisResponse(sums[i]), x, y, number});
  }
  const auto wanted = static_cast<std::size_t>(max_features);
  if (max_features > 0 && corners.size() > wanted) {
    std::nth_element(corners.begin(), corners.begin() + max_features, corners.end(), strongerCorner);
    corners.resize(wanted);
  }
}

}  // namespace

OrbDetector::OrbDetector(const OrbOptions& options) : options_(options), patch_(options.patch_size) {
  options_.check();
}

void OrbDetector::detect(const DetectionRequest& request, Features& features) const {
  const cv::Mat& grey = request.image;
  if (grey.cols <= 2 * options_.patch_size || grey.rows <= 2 * options_.patch_size) return;
  auto& memory = request.workspace.part<OrbMemory>();
  const int levels = usableLevels(grey.size(), options_.scale_factor, options_.levels, options_.patch_size);
  const auto level_count = static_cast<std::size_t>(levels);
  memory.pyramid.start(grey, options_.scale_factor, levels, request.describe);
  const bool shared = options_.max_features > 0 && !options_.spread;
  const std::vector<int> shares = shared ? levelShares(options_.max_features, options_.scale_factor, levels)
                                         : std::vector<int>(level_count);
  while (memory.counts.size() < level_count) memory.counts.push_back(std::make_unique<ScoreCounts>());
  for (std::size_t level = 0; level < level_count; ++level)
    memory.counts[level]->start(kRankedShare * shares[level]);
  searchLevels(request, options_, patch_.radius(), memory);

  memory.corners.resize(level_count);
  forEachBlock(level_count, 1, request.threads, [&](std::size_t level, std::size_t) {
    memory.corners[level].clear();
    if (shared && shares[level] == 0) return;
    rankCorners(memory, static_cast<int>(level), shares[level], Workspace::ofThread(), memory.corners[level]);
  });
  std::vector<Corner>& corners = memory.all;
  corners.clear();
  for (const auto& level : memory.corners) corners.insert(corners.end(), level.begin(), level.end());
  std::sort(corners.begin(), corners.end(), strongerCorner);

  features.keypoints.resize(corners.size());
  const double diameter = request.describe ? options_.patch_size : kFastDiameter;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Corner& corner = corners[i];
    const double size = diameter * memory.pyramid.level(corner.level).scale;
    features.keypoints[i] = {corner.place, static_cast<float>(size), 0.0F, corner.response,
                             corner.level, static_cast<int>(i)};
  }
  features.frames.resize(corners.size());
  // Before angles and descriptors are computed; the angle does not influence the order.
  keepStrongest(options_.max_features, options_.spread, grey.size(), features);

  if (request.describe) {
    features.descriptors.create(static_cast<int>(features.keypoints.size()), OrientedPatch::kBytes, CV_8U);
  }
  forEachBlock(features.keypoints.size(), kPatches, request.threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      cv::KeyPoint& keypoint = features.keypoints[i];
      const Corner& corner = corners[static_cast<std::size_t>(keypoint.class_id)];
      keypoint.class_id = -1;
      const PatchDirection direction =
          patch_.direction(memory.pyramid.level(corner.level), corner.x, corner.y);
      keypoint.angle = direction.angle;
      const float c = direction.cosine * (keypoint.size / 2), s = direction.sine * (keypoint.size / 2);
      features.frames[i] = {c, -s, keypoint.pt.x, s, c, keypoint.pt.y};
      if (request.describe) {
        patch_.describe(memory.pyramid.blurred(corner.level), corner.x, corner.y, keypoint.angle,
                        features.descriptors.ptr(static_cast<int>(i)));
      }
    }
  });
}

}  // namespace corrsel::core
