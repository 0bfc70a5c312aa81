#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

#include "corrsel/correspondences.h"
#include "corrsel/features/extractor.h"
#include "corrsel/features/features.h"
#include "corrsel/features/region.h"
#include "corrsel/options.h"

namespace corrsel::core {

struct Brightness;
struct GreyBuffer;

struct FlowOptions : OptionSet {
  std::string detector = "orb";  ///< finds new points, with the options of this algorithm
  int max_points = 1000;         ///< points that are followed at most
  double refill = 0.8;          ///< new points are detected when fewer than this share of max_points are left
  double min_distance = 8;      ///< of two points, px; where two come closer, the older one stays
  int window = 16;              ///< side of the patches that are compared, px; multiples of 8 are fastest
  int levels = 4;               ///< of the pyramid; each one doubles the largest motion
  double max_error = 0.7;       ///< largest distance of a point that was followed there and back, px
  double max_deviation = 0.07;  ///< largest standard deviation of a position by the noise, px

  void visit(OptionVisitor& visitor) const override;
};

/// Follows points through the images of one camera by pyramidal Lucas-Kanade.
///
/// Idea: Errors of a chain of comparisons between neighbouring images add up, so that points drift even where
/// the camera stands. Here a point keeps the patch around it in the image in which it was found, and is
/// looked for in every new image by this patch, starting at its last place. It gets a new patch only where it
/// no longer looks like the old one.
///
/// Algorithm: A point is followed from the image of its patch to the newest one and back, which must end
/// within `max_error` of the beginning; the way back starts as far off as the way there. As many levels of
/// the pyramid are used as the last image would have needed, and all where that fails. Where all fail, or the
/// patches differ much more than after the first step, the point is followed from the previous image, and the
/// newest image becomes that of its patch. It does so, too, where the patches begin to differ. At most four
/// images with patches are kept: of more, the one with the fewest points gives them to the newest image. A
/// point is dropped where both fail, where it comes within half a window of the border, on a zero of the
/// mask, outside the area, too close to an older point, or where its place would be less exact than
/// `max_deviation`. With fewer than `refill` of `max_points` left (at least every fifth image while the scene
/// does not show as many), the detector looks for points in what is empty, and the cells with the fewest
/// points are filled first.
///
/// Light: The grey values of an image are mapped to those of the first one by a gain and an offset, which are
/// estimated from the means of the patches, because Lucas-Kanade takes brighter for nearer. Where the light
/// of a part of the image changes, its points get new patches.
///
/// Exactness: With a noise of the grey values of s and N pixels of the window, the deviation of a place is
/// sqrt(2 / (N g)) s along the direction in which the mean squared gradient g is least. s comes from the
/// differences of the patches, which noise and changes of the scene cause.
///
/// Input: images as FeatureExtractor::extract() takes them, of any size; another size begins anew.
///
/// Failure: Blank and tiny images have no points. Motion of more than about window 2^(levels - 2) px, and
/// repeated textures with motion of more than half a period, lose points or let them jump to another place
/// that looks the same: selectors are needed as behind any other matcher.
///
/// Cost: O(pixels) for a pyramid with derivatives, and O(window^2 levels) for each point, on OpenCV's threads
/// (cv::setNumThreads()). The result does not depend on their number. Memory of 6 pyramids of 6.7 bytes per
/// pixel.
///
/// Source: Lucas and Kanade, "An Iterative Image Registration Technique", IJCAI 1981; Shi and Tomasi, "Good
/// Features to Track", CVPR 1994; Bouguet, "Pyramidal Implementation of the Lucas Kanade Feature Tracker",
/// Intel 2000; implementation of one comparison: OpenCV's video.
///
/// Not thread-safe.
class FlowMatcher {
 public:
  /// Throws std::invalid_argument for options out of range, an unknown detector, and options of the detector
  /// that it refuses. `max_features` and `spread` of the detector have no effect, nor has `patch_size`,
  /// because nothing is described.
  explicit FlowMatcher(const FlowOptions& options = {}, const AlgorithmOptions& detector_options = {});
  ~FlowMatcher();

  /// Follows the points to the next image, and finds new ones.
  /// @param threads  that the detector may use; the result does not depend on it
  /// @param region   where points may be
  /// @return the points in this image, oldest first, without descriptors and frames. `class_id` of a keypoint
  /// is the number of the point, which it keeps from image to image; `size` is the window. detect_seconds is
  /// the time of everything.
  /// Throws what FeatureExtractor::extract() throws for the image and the region; then nothing changes.
  Features track(const cv::Mat& image, int threads = 1, const FeatureRegion& region = {});

  /// Drops all points, e.g. after a jump in time.
  void reset();

  /// "orb+flow" with the detector "orb".
  std::string name() const { return options_.detector + "+flow"; }

  const FlowOptions& options() const { return options_; }

 private:
  /// Images whose points keep their patches, beside the newest one.
  static constexpr std::size_t kKeyframes = 4;

  struct Point {
    int id;
    std::size_t image;     ///< that of its patch, in images_
    cv::Point2f patch;     ///< centre of the patch, px
    cv::Point2f place;     ///< in the newest image, px
    cv::Point2f step;      ///< from the image before to the newest one, px
    float level;           ///< mean of the patch, grey levels
    float first_residual;  ///< of the patches after the first step, grey levels; NaN = not known
  };
  using Pyramid = std::vector<cv::Mat>;

  /// Points that are followed from one image to another.
  struct Steps {
    std::vector<std::size_t> rows;      ///< in points_
    std::vector<cv::Point2f> from, to;  ///< `to` begins with a guess
    std::vector<std::uint8_t> found;
    std::vector<float> residuals;  ///< mean difference of the patches, grey levels
  };

  void follow(std::size_t newest);
  void step(const Pyramid& from, const Pyramid& to, int max_level, Steps& steps) const;
  void stepFromPatches(std::size_t newest, int max_level, std::vector<float>& residuals);
  void stepFromPrevious(std::size_t newest, std::vector<float>& residuals);
  static void move(Point& point, const cv::Point2f& place);
  void renew(Point& point, std::size_t newest) const;
  int levelFor(double error) const;
  void drop(const std::vector<char>& keep);
  void dropOutside(const cv::Rect& area, const cv::Mat& mask);
  void limitKeyframes(std::size_t newest);
  void refill(const cv::Mat& grey, std::size_t newest, int threads, const cv::Rect& area,
              const FeatureRegion& region);
  cv::Mat adaptedToLight(const cv::Mat& grey);
  float levelAt(const cv::Mat& image, const cv::Point2f& place) const;
  bool wantsPoints() const;
  float typicalResidual() const;
  double minEigenvalue() const;
  std::size_t freeImage() const;
  Features result(const cv::Size& size) const;

  FlowOptions options_;
  std::unique_ptr<FeatureExtractor> detector_;
  std::unique_ptr<GreyBuffer> grey_;
  std::unique_ptr<Brightness> brightness_;      ///< of the newest image
  cv::Mat adapted_;                             ///< memory for an image
  std::array<Pyramid, kKeyframes + 2> images_;  ///< and the previous and the newest one
  std::size_t previous_ = 0;                    ///< the last image, in images_
  cv::Size size_;                               ///< of the images, px
  int top_level_ = 0;                           ///< that images of this size have
  int usual_level_ = 0;                         ///< from which most points can be found
  std::vector<Point> points_;                   ///< oldest first
  std::size_t filled_ = 0;                      ///< points after the last detection
  int images_since_refill_ = 0;
  int next_id_ = 0;
};

/// The points that two results of FlowMatcher::track() share, by their numbers. left_index and right_index
/// are the rows of the points. There are no distances, because the error of a comparison does not tell right
/// from wrong points as descriptors do. O(points).
Correspondences matchFlow(const Features& left, const Features& right);

}  // namespace corrsel::core
