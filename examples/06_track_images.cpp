// Follows features over the images of one camera, and writes their tracks.
//
//     06_track_images OUTPUT.csv FEATURES MAX_GAP IMAGE IMAGE...
//
// for example 06_track_images tracks.csv sift+sift 2 frames/*.png. Every image is matched with the one
// before; `auto` decides which matches are right, and which features were found again after up to MAX_GAP
// images. In the file, the column `stamp` holds the number of the image, from 1. Needs corrsel::features and
// OpenCV's imgcodecs.

#include <corrsel/features/extractor.h>
#include <corrsel/matching/matcher.h>
#include <corrsel/selectors/factory.h>
#include <corrsel/tracking/gap_bridge.h>
#include <corrsel/tracking/track_file.h>

#include <exception>
#include <iostream>
#include <opencv2/imgcodecs.hpp>
#include <string>

using namespace corrsel::core;

int main(int argc, char** argv) try {
  if (argc < 6) {
    std::cerr << "usage: 06_track_images OUTPUT.csv FEATURES MAX_GAP IMAGE IMAGE...\n";
    return 2;
  }
  const auto extractor =
      createExtractor(argv[2], {{"sift", {{"max_features", "1000"}}}, {"orb", {{"max_features", "1000"}}}});
  const std::shared_ptr<const Selector> selector = createSelector("auto");
  TrackKeeper keeper(std::stoul(argv[3]), GapBridge(selector));
  TrackFile file(argv[1]);
  std::shared_ptr<const Features> previous;
  TrackKeeper::Counts sum;
  for (int i = 4; i < argc; ++i) {
    const cv::Mat image = cv::imread(argv[i], cv::IMREAD_GRAYSCALE);
    if (image.empty()) {
      std::cerr << "cannot read " << argv[i] << "\n";
      return 2;
    }
    const auto features = std::make_shared<const Features>(extractor->extract(image));
    const auto id = static_cast<std::uint64_t>(i - 3);
    TrackKeeper::Frame frame{id, {}, features};
    for (const cv::KeyPoint& keypoint : features->keypoints) frame.points.push_back(keypoint.pt);
    if (previous == nullptr) {
      keeper.add(frame);
    } else {
      const Correspondences matches = matchFeatures(*features, *previous);
      keeper.add(frame, id - 1, selectedLinks(matches, selector->select(matches).mask));
    }
    previous = features;
    file.add(id, keeper.tracks());
    sum.continued += keeper.counts().continued;
    sum.bridged += keeper.counts().bridged;
  }
  std::cout << argc - 4 << " images: features continued a track " << sum.continued << " times, and "
            << sum.bridged << " times after a gap\n";
  return 0;
} catch (const std::exception& error) {
  std::cerr << error.what() << "\n";
  return 2;
}
