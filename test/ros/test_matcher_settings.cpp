#include <gtest/gtest.h>

#include <atomic>
#include <opencv2/core.hpp>
#include <string>
#include <thread>

#include "ros/live/matcher_settings.h"

namespace corrsel {
namespace {

constexpr std::uint32_t kAll = ~0u;
constexpr std::uint32_t kLevelMatch = 2;

FeatureMatcherConfig config(const std::string& features) {
  FeatureMatcherConfig config = FeatureMatcherConfig::__getDefault__();
  config.features = features;
  return config;
}

int maxFeatures(const core::FeatureExtractor& extractor, const cv::Mat& image) {
  return static_cast<int>(extractor.extract(image, 1).keypoints.size());
}

cv::Mat noise() {
  cv::Mat image(240, 320, CV_8UC1);
  cv::RNG(7).fill(image, cv::RNG::UNIFORM, 0, 256);
  return image;
}

TEST(MatcherSettings, FollowTheConfiguration) {
  MatcherSettings settings;
  FeatureMatcherConfig asked = config("orb+orb");
  asked.orb_max_features = 50;
  asked.match_mutual = true;
  asked.match_second_distance_radius = 2.5;
  asked.sequence_step = 3;
  asked.roi_x = 10;
  asked.roi_y = 20;
  asked.roi_width = 30;
  asked.roi_height = 40;
  const MatcherSettings::Change change = settings.configure(asked, kAll);
  EXPECT_EQ(change.error, "");
  EXPECT_EQ(change.features, "orb+orb");
  EXPECT_TRUE(change.new_features);

  const LiveMatcher::Settings current = settings.current();
  ASSERT_TRUE(current.extractor);
  EXPECT_EQ(current.extractor->name(), "orb+orb");
  const int found = maxFeatures(*current.extractor, noise());
  EXPECT_GT(found, 0);
  EXPECT_LE(found, 50);
  EXPECT_TRUE(current.match.mutual);
  EXPECT_EQ(current.match.second_distance_radius, 2.5);
  EXPECT_EQ(current.sequence.step, 3);
  EXPECT_EQ(current.area, cv::Rect(10, 20, 30, 40));
}

TEST(MatcherSettings, LimitTheNumberOfFeaturesByDefault) {
  MatcherSettings settings;
  FeatureMatcherConfig asked = config("orb+orb");
  ASSERT_EQ(settings.configure(asked, kAll).error, "");
  cv::Mat image(960, 1280, CV_8UC1);
  cv::RNG(7).fill(image, cv::RNG::UNIFORM, 0, 256);
  EXPECT_LT(maxFeatures(*settings.current().extractor, image), 1100);
  EXPECT_GT(maxFeatures(*settings.current().extractor, image), 900);
  // The library's default is not the one in live use, and 0 still means all.
  EXPECT_GT(maxFeatures(*core::createExtractor("orb+orb"), image), 2000);
  asked.orb_max_features = 0;
  ASSERT_EQ(settings.configure(asked, kAll).error, "");
  EXPECT_GT(maxFeatures(*settings.current().extractor, image), 2000);
}

TEST(MatcherSettings, TheExtractorIsBuiltAnewForFeaturesOnly) {
  MatcherSettings settings;
  FeatureMatcherConfig asked = config("orb+orb");
  settings.configure(asked, kAll);
  const auto before = settings.current().extractor;

  asked.match_mutual = true;
  MatcherSettings::Change change = settings.configure(asked, kLevelMatch);
  EXPECT_FALSE(change.new_features);
  EXPECT_EQ(change.features, "orb+orb");
  EXPECT_EQ(settings.current().extractor, before);
  EXPECT_TRUE(settings.current().match.mutual);

  asked.orb_max_features = 100;
  change = settings.configure(asked, MatcherSettings::kLevelFeatures);
  EXPECT_TRUE(change.new_features);
  EXPECT_NE(settings.current().extractor, before);
}

TEST(MatcherSettings, OpticalFlowIsBuiltAnewForItsOptions) {
  FeatureMatcherConfig asked = config("orb+orb");
  MatcherSettings descriptors;
  descriptors.configure(asked, kAll);
  EXPECT_FALSE(descriptors.current().flow);

  MatcherSettings settings(true);
  asked.flow_max_points = 77;
  MatcherSettings::Change change = settings.configure(asked, kAll);
  EXPECT_EQ(change.error, "");
  EXPECT_EQ(change.features, "orb+flow");
  const auto before = settings.current().flow;
  ASSERT_TRUE(before);
  EXPECT_EQ(before->options().max_points, 77);

  asked.match_mutual = true;
  EXPECT_FALSE(settings.configure(asked, kLevelMatch).new_features);
  EXPECT_EQ(settings.current().flow, before);

  asked.flow_detector = "brisk";
  change = settings.configure(asked, MatcherSettings::kLevelFlow);
  EXPECT_TRUE(change.new_features);
  EXPECT_EQ(change.features, "brisk+flow");

  asked.flow_detector = "harris";
  change = settings.configure(asked, MatcherSettings::kLevelFlow);
  EXPECT_NE(change.error.find("harris"), std::string::npos) << change.error;
  EXPECT_NE(change.error.find("brisk+flow stays in force"), std::string::npos) << change.error;
  EXPECT_EQ(asked.flow_detector, "brisk");
  EXPECT_EQ(settings.current().flow->name(), "brisk+flow");
}

TEST(MatcherSettings, AConfigurationThatDoesNotWorkLeavesTheOneBeforeInForce) {
  MatcherSettings settings;
  FeatureMatcherConfig good = config("orb+orb");
  good.orb_levels = 5;
  good.roi_width = 100;
  ASSERT_EQ(settings.configure(good, kAll).error, "");
  const auto before = settings.current().extractor;
  for (const char* features : {"surf+surf", "orb", "", "sift+"}) {
    FeatureMatcherConfig bad = config(features);
    bad.roi_width = 7;
    bad.match_mutual = true;
    const MatcherSettings::Change change = settings.configure(bad, kAll);
    EXPECT_NE(change.error.find("not changed: "), std::string::npos) << features;
    EXPECT_NE(change.error.find("orb+orb stays in force"), std::string::npos) << change.error;
    EXPECT_EQ(change.features, "orb+orb");
    EXPECT_FALSE(change.new_features);
    EXPECT_EQ(bad.features, "orb+orb") << "the configuration is written back as it is in force";
    EXPECT_EQ(bad.orb_levels, 5);
    EXPECT_EQ(bad.roi_width, 100);
    EXPECT_EQ(settings.current().extractor, before);
    EXPECT_EQ(settings.current().area.width, 100) << "nothing of it is in force";
    EXPECT_FALSE(settings.current().match.mutual);
  }
}

TEST(MatcherSettings, OptionsThatTheMatcherRefusesAreRolledBackToo) {
  MatcherSettings settings;
  FeatureMatcherConfig good = config("orb+orb");
  ASSERT_EQ(settings.configure(good, kAll).error, "");
  FeatureMatcherConfig bad = good;
  bad.match_second_distance_radius = -1.0;  // the server would not let it pass
  const MatcherSettings::Change change = settings.configure(bad, kLevelMatch);
  EXPECT_NE(change.error.find("second_distance_radius"), std::string::npos) << change.error;
  EXPECT_EQ(bad.match_second_distance_radius, good.match_second_distance_radius);
  EXPECT_EQ(settings.current().match.second_distance_radius, good.match_second_distance_radius);
}

TEST(MatcherSettings, StartWithTheDefaultsWhereTheFirstConfigurationDoesNotWork) {
  MatcherSettings settings;
  FeatureMatcherConfig bad = config("nonsense+nonsense");
  const MatcherSettings::Change change = settings.configure(bad, kAll);
  const std::string standard = FeatureMatcherConfig::__getDefault__().features;
  EXPECT_NE(change.error.find("nonsense"), std::string::npos) << change.error;
  EXPECT_EQ(change.features, standard);
  EXPECT_TRUE(change.new_features);
  EXPECT_EQ(bad.features, standard);
  ASSERT_TRUE(settings.current().extractor);
  EXPECT_EQ(settings.current().extractor->name(), standard);
}

TEST(MatcherSettings, CanBeReadWhileTheyChange) {
  MatcherSettings settings;
  FeatureMatcherConfig first = config("orb+orb");
  settings.configure(first, kAll);
  std::atomic<bool> over{false};
  std::thread storm([&] {
    for (int i = 0; i < 100; ++i) {
      FeatureMatcherConfig next = config(i % 3 == 0 ? "orb+orb" : i % 3 == 1 ? "brisk+brisk" : "nonsense");
      next.roi_width = next.features == "orb+orb" ? 11 : 22;
      settings.configure(next, kAll);
    }
    over = true;
  });
  while (!over) {
    const LiveMatcher::Settings current = settings.current();
    ASSERT_TRUE(current.extractor);
    if (current.area.width == 0) continue;  // the first one
    EXPECT_EQ(current.area.width, current.extractor->name() == "orb+orb" ? 11 : 22) << "two settings mixed";
  }
  storm.join();
}

}  // namespace
}  // namespace corrsel
