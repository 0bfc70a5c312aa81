#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/core/version.hpp>
#include <opencv2/features2d.hpp>
#include <string>
#include <utility>
#include <vector>

#include "corrsel/features/extractor.h"
#include "feature_checks.h"
#include "features/detectors/cv_sift.h"

namespace corrsel::core::testing {
namespace {

constexpr bool kHasSift = CV_VERSION_MAJOR > 4 || (CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR >= 4);

TEST(CvSift, NeedsOpenCv44) {
  for (const auto& [major, minor] : {std::pair{4, 4}, {4, 10}, {5, 0}}) {
    EXPECT_NO_THROW(requireCvSift("cv_sift", major, minor, 0)) << major << "." << minor;
  }
  EXPECT_EQ(errorOf<std::invalid_argument>([] { requireCvSift("cv_sift", 4, 2, 0); }),
            "cv_sift needs OpenCV 4.4 or newer, but this is OpenCV 4.2.0; use sift, which works with every "
            "version");
  EXPECT_NE(errorOf<std::invalid_argument>([] { requireCvSift("cv_sift", 3, 9, 1); }), "");
}

TEST(CvSift, IsListedWithEveryVersionAndCreatedWhereOpenCvHasIt) {
  const std::vector<std::string> detectors = detectorNames(), descriptors = descriptorNames();
  for (const std::vector<std::string>& names : {detectors, descriptors}) {
    EXPECT_EQ(std::count(names.begin(), names.end(), "cv_sift"), 1);
  }
  if (kHasSift) {
    EXPECT_EQ(createExtractor("cv_sift+cv_sift")->name(), "cv_sift+cv_sift");
  } else {
    EXPECT_TRUE(
        contains(errorOf<std::invalid_argument>([] { createExtractor("cv_sift+cv_sift"); }), "use sift"));
  }
}

TEST(CvSift, IsMissingWhereItCannotBeCreated) {
  const auto missing = missingAlgorithms();
  ASSERT_EQ(missing.size(), kHasSift ? 0 : 1);
  for (const auto& [name, reason] : missing) {
    EXPECT_EQ(name, "cv_sift");
    EXPECT_EQ(reason, errorOf<std::invalid_argument>([] { createExtractor("cv_sift+cv_sift"); }));
  }
}

TEST(CvSift, IsThatOfOpenCv) {
#if CV_VERSION_MAJOR > 4 || (CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR >= 4)
  const cv::Mat image = shapes();
  std::vector<cv::KeyPoint> keypoints;
  cv::Mat descriptors;
  cv::SIFT::create()->detectAndCompute(image, cv::noArray(), keypoints, descriptors);
  const Features ours = createExtractor("cv_sift+cv_sift")->extract(image);
  ASSERT_EQ(ours.keypoints.size(), keypoints.size());
  // Ours are sorted.
  const auto sum = [](const std::vector<cv::KeyPoint>& all) {
    double total = 0;
    for (const cv::KeyPoint& p : all) total += p.pt.x * p.size + p.pt.y * p.angle;
    return total;
  };
  EXPECT_NEAR(sum(ours.keypoints), sum(keypoints), 1e-9 * sum(keypoints));
  EXPECT_EQ(cv::sum(ours.descriptors), cv::sum(descriptors));
#else
  GTEST_SKIP() << "OpenCV " << CV_VERSION << " has no SIFT";
#endif
}

}  // namespace
}  // namespace corrsel::core::testing
