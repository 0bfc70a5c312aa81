#include "descriptors.h"

#include <cmath>
#include <cstring>
#include <map>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <utility>

#include "corrsel/features/extractor.h"
#include "matching/nearest.h"

namespace corrsel::performance {
namespace {

using Descriptors = std::pair<cv::Mat, cv::Mat>;  // of the two views

std::pair<cv::Mat, cv::Mat> views() {
  const cv::Size size(2000, 1500);
  cv::RNG random(1);
  cv::Mat sum = cv::Mat::zeros(size, CV_32F);
  for (int cell = 2; cell <= 64; cell *= 2) {
    cv::Mat noise(size / cell, CV_32F), scaled;
    random.fill(noise, cv::RNG::NORMAL, 0, std::sqrt(cell));
    cv::resize(noise, scaled, size, 0, 0, cv::INTER_CUBIC);
    sum += scaled;
  }
  cv::Mat left, right, noise(size, CV_16S);
  cv::normalize(sum, sum, 0, 255, cv::NORM_MINMAX);
  sum.convertTo(left, CV_8U);
  const cv::Mat map = cv::getRotationMatrix2D(cv::Point2f(1000, 750), 10, 0.9);
  cv::warpAffine(left, right, map, size, cv::INTER_LINEAR, cv::BORDER_REFLECT);
  random.fill(noise, cv::RNG::NORMAL, 0, 2);
  cv::add(right, noise, right, cv::noArray(), CV_8U);
  return {left, right};
}

const Descriptors& descriptors(DescriptorKind kind, std::size_t n) {
  static std::map<std::pair<DescriptorKind, std::size_t>, Descriptors> made;
  Descriptors& entry = made[{kind, n}];
  if (!entry.first.empty()) return entry;
  const std::string count = std::to_string(n);
  const auto extractor =
      kind == DescriptorKind::kOrb
          ? core::createExtractor("orb+orb", {{"orb", {{"max_features", count}, {"fast_threshold", "5"}}}})
          : core::createExtractor("sift+sift",
                                  {{"sift", {{"max_features", count}, {"contrast_threshold", "0.01"}}}});
  const auto [left, right] = views();
  const auto describe = [&, kind = kind](const cv::Mat& image) {
    cv::Mat found = extractor->extract(image).descriptors;
    if (std::size_t(found.rows) < n) {
      throw std::runtime_error("the generated picture has " + std::to_string(found.rows) +
                               " features only; needed: " + count);
    }
    if (kind == DescriptorKind::kRootSift) {
      for (int row = 0; row < found.rows; ++row) {
        cv::Mat values = found.row(row);
        values /= cv::sum(values)[0];
        cv::sqrt(values, values);
      }
    }
    return found;
  };
  entry = {describe(left), describe(right)};
  return entry;
}

/// One query's outcome as bytes.
void append(Mask& bytes, std::uint32_t train, float distance, float second) {
  std::uint8_t text[sizeof train + sizeof distance + sizeof second];
  std::memcpy(text, &train, sizeof train);
  std::memcpy(text + sizeof train, &distance, sizeof distance);
  std::memcpy(text + sizeof train + sizeof distance, &second, sizeof second);
  bytes.insert(bytes.end(), std::begin(text), std::end(text));
}

SceneSpec spec(std::size_t n) { return {MatchSceneKind::kPlane, n, kNotMeasured}; }

}  // namespace

Method neighbours(const std::string& name, DescriptorKind kind, std::size_t n, int threads) {
  return {name, spec(n), 1, [=](const std::vector<Scene>&) -> Call {
            const Descriptors& input = descriptors(kind, n);
            core::NeighbourSearch search;
            search.threads = threads;
            return [&input, search](std::size_t) {
              const core::Neighbours found = core::findNeighbours(input.first, input.second, search);
              Mask outcome;
              for (std::size_t i = 0; i < found.train.size(); ++i) {
                append(outcome, found.train[i], found.distance[i], found.second_distance[i]);
              }
              return outcome;
            };
          }};
}

Method openCvNeighbours(DescriptorKind kind, std::size_t n, bool same_outcome) {
  return {"cv::BFMatcher", spec(n), 1,
          [=](const std::vector<Scene>&) -> Call {
            const Descriptors& input = descriptors(kind, n);
            return [&input, kind](std::size_t) {
              const cv::BFMatcher matcher(kind == DescriptorKind::kOrb ? cv::NORM_HAMMING : cv::NORM_L2);
              std::vector<std::vector<cv::DMatch>> found;
              matcher.knnMatch(input.first, input.second, found, 2);
              Mask outcome;
              for (const std::vector<cv::DMatch>& two : found) {
                append(outcome, std::uint32_t(two.at(0).trainIdx), two[0].distance, two.at(1).distance);
              }
              return outcome;
            };
          },
          same_outcome};
}

}  // namespace corrsel::performance
