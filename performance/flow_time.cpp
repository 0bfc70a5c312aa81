// Processor time of optical flow with a selector behind it: a generated sequence of 640x480, 1000 points.
//
//     flow_time [SELECTOR] [PX_PER_IMAGE]

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "corrsel/evaluation/statistics.h"
#include "corrsel/random.h"
#include "corrsel/selectors/factory.h"
#include "corrsel/tracking/flow_matcher.h"

namespace {

using namespace corrsel::core;

constexpr int kWidth = 640, kHeight = 480, kImages = 300;

/// Blocks and discs with soft edges, larger than an image.
cv::Mat texture() {
  Random random(1);
  cv::Mat image(2 * kHeight, 2 * kWidth, CV_8UC1, cv::Scalar(128));
  for (int i = 0; i < 7000; ++i) {
    const cv::Point at(static_cast<int>(random.index(2 * kWidth)),
                       static_cast<int>(random.index(2 * kHeight)));
    const auto size = 4 + static_cast<int>(random.index(20));
    const cv::Scalar grey(20 + random.index(216));
    cv::rectangle(image, cv::Rect(at, cv::Size(size, size)), grey, cv::FILLED);
  }
  cv::GaussianBlur(image, image, {}, 1.0);
  return image;
}

/// What a camera sees that turns and sways, with a noise of 2 grey levels.
std::vector<cv::Mat> sequence(double speed) {
  const cv::Mat scene = texture();
  cv::RNG random(3);
  std::vector<cv::Mat> images;
  for (int i = 0; i < kImages; ++i) {
    const double x = 250 * std::sin(speed * i / 250), y = 150 * std::sin(speed * i / 300);
    cv::Matx23d motion = cv::getRotationMatrix2D({kWidth, kHeight}, 0.05 * speed * i, 1);
    motion(0, 2) += x - kWidth / 2.0;
    motion(1, 2) += y - kHeight / 2.0;
    cv::Mat image, noise(kHeight, kWidth, CV_16S);
    cv::warpAffine(scene, image, motion, {kWidth, kHeight}, cv::INTER_LINEAR, cv::BORDER_REFLECT);
    random.fill(noise, cv::RNG::NORMAL, 0, 2);
    cv::add(image, noise, image, cv::noArray(), CV_8U);
    images.push_back(image);
  }
  return images;
}

/// Times of one part of the work, ms.
struct Times {
  std::vector<double> wall, processor;

  template <class Work>
  void measure(const Work& work) {
    const auto begin = std::chrono::steady_clock::now();
    const double used = seconds();
    work();
    processor.push_back(1e3 * (seconds() - used));
    wall.push_back(1e3 * std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }

  void print(const char* name) const {
    std::printf("%-8s processor: mean %.2f, p95 %.2f ms; wall: p50 %.2f, p95 %.2f ms\n", name,
                mean(processor), quantile(processor, 0.95), quantile(wall, 0.5), quantile(wall, 0.95));
  }

 private:
  static double seconds() {
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  }
};

}  // namespace

int main(int argc, char** argv) {
  const std::string name = argc > 1 ? argv[1] : "auto";
  const double speed = argc > 2 ? std::atof(argv[2]) : 1;
  const std::vector<cv::Mat> images = sequence(speed);
  const auto selector = createSelector(name);
  FlowMatcher matcher;
  Features before;
  Times flow, selection;
  std::vector<double> points, selected;
  for (const cv::Mat& image : images) {
    Features features;
    flow.measure([&] { features = matcher.track(image, 2); });
    const Correspondences matches = matchFlow(features, before);
    before = std::move(features);
    points.push_back(static_cast<double>(before.keypoints.size()));
    if (matches.empty()) continue;
    corrsel::core::Selection result;
    selection.measure([&] { result = selector->select(matches); });
    selected.push_back(static_cast<double>(selectedRows(result.mask).size()) /
                       static_cast<double>(matches.size()));
  }
  std::printf("%d images of %dx%d, %.1f px per image, points: median %.0f; %s selects %.1f %%\n", kImages,
              kWidth, kHeight, speed, quantile(points, 0.5), name.c_str(), 100 * mean(selected));
  flow.print("flow");
  selection.print(name.c_str());
  return 0;
}
