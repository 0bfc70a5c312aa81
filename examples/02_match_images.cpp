// Matches two images: features, putative matches, selection with `auto`, and a picture of the result.
//
//     02_match_images LEFT RIGHT [OUTPUT.png]
//
// Needs corrsel::features and OpenCV's imgcodecs. The exit code is 0 where the selection can be relied on.

#include <corrsel/features/extractor.h>
#include <corrsel/matching/match_drawing.h>
#include <corrsel/matching/matcher.h>
#include <corrsel/selectors/factory.h>

#include <iostream>
#include <opencv2/imgcodecs.hpp>

using namespace corrsel::core;

int main(int argc, char** argv) {
  if (argc < 3) {
    std::cerr << "usage: 02_match_images LEFT RIGHT [OUTPUT.png]\n";
    return 2;
  }
  const cv::Mat left = cv::imread(argv[1]), right = cv::imread(argv[2]);
  if (left.empty() || right.empty()) {
    std::cerr << "cannot read " << argv[left.empty() ? 1 : 2] << "\n";
    return 2;
  }

  const int threads = 2;
  const auto extractor = createExtractor("sift+sift", {{"sift", {{"max_features", "2000"}}}});
  const auto [left_features, right_features] = extractPair(*extractor, left, right, threads);
  const Correspondences matches = matchFeatures(left_features, right_features, {}, threads);
  const Selection selection = createSelector("auto")->select(matches);

  std::cout << toString(selection.status) << ": " << selection.n_selected << " of " << matches.size()
            << " matches, model " << toString(selection.model_kind) << "\n"
            << selection.message << "\n";
  if (argc > 3) {
    const cv::Mat drawn = drawSelection(left, right, matches, selection);
    if (!cv::imwrite(argv[3], drawn)) {
      std::cerr << "cannot write " << argv[3] << "\n";
      return 2;
    }
  }
  return selection.status == Status::kOk ? 0 : 1;
}
