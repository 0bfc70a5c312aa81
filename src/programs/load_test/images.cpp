#include "images.h"

#include <cv_bridge/cv_bridge.h>

#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>

#include "base/text.h"
#include "datasets/files.h"
#include "datasets/sample.h"

namespace corrsel::load_test {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxPairs = 100;  ///< of a folder: they are all kept in memory

sensor_msgs::Image toImageMsg(cv::Mat image, const Arguments& arguments, const std::string& frame) {
  if (!arguments.size.empty() && image.size() != arguments.size) {
    cv::resize(image, image, arguments.size, 0, 0, cv::INTER_AREA);
  }
  if (arguments.encoding == "mono8" && image.channels() == 3) cv::cvtColor(image, image, cv::COLOR_BGR2GRAY);
  if (arguments.encoding == "bgr8" && image.channels() == 1) cv::cvtColor(image, image, cv::COLOR_GRAY2BGR);
  sensor_msgs::Image msg;
  std_msgs::Header header;
  header.frame_id = frame;
  cv_bridge::CvImage(header, arguments.encoding, image).toImageMsg(msg);
  return msg;
}

StereoImages toPair(const cv::Mat& left, const cv::Mat& right, const Arguments& arguments) {
  return {toImageMsg(left, arguments, "left_camera_optical"),
          toImageMsg(right, arguments, "right_camera_optical")};
}

std::vector<StereoImages> fromFiles(const std::vector<std::pair<std::string, std::string>>& files,
                                    const Arguments& arguments) {
  const std::string remedy = "Give --images LEFT,RIGHT or a folder of left_* and right_* images.";
  std::vector<StereoImages> pairs;
  for (const auto& [left, right] : files) {
    const cv::Mat left_image = core::readImageFile(left, remedy);
    pairs.push_back(toPair(left_image, core::readImageFile(right, remedy), arguments));
  }
  return pairs;
}

/// left_NAME with right_NAME, and left/NAME with right/NAME.
std::vector<std::pair<std::string, std::string>> pairsOf(const std::string& folder) {
  std::vector<std::pair<std::string, std::string>> files;
  const auto add = [&files](const fs::path& left, const fs::path& right) {
    if (core::isImageExtension(left.extension().string()) && files.size() < kMaxPairs) {
      files.emplace_back(left.string(), right.string());
    }
  };
  const fs::path root(folder);
  for (const std::string& name : core::fileNames(folder)) {
    if (name.compare(0, 4, "left") == 0) add(root / name, root / ("right" + name.substr(4)));
  }
  for (const std::string& name : core::fileNames((root / "left").string())) {
    add(root / "left" / name, root / "right" / name);
  }
  if (files.empty()) {
    throw core::DatasetError(folder + " has no images left_NAME, nor left/NAME. " +
                             "Their counterparts must be called right_NAME, or right/NAME.");
  }
  return files;
}

/// The first pair of each of the sample set's sequences before kFirstReal, so that the load is that of
/// earlier tests.
std::vector<StereoImages> samples(Arguments arguments) {
  if (arguments.size.empty()) arguments.size = {640, 480};
  const std::string folder = core::sampleFolder();
  if (!fs::is_directory(folder)) {
    throw core::DatasetError("the sample photographs are not in " + folder +
                             "; run: rosrun corrsel fetch_samples.sh, or give --images");
  }
  const core::SampleReader reader(folder);
  std::vector<StereoImages> pairs;
  std::string sequence;
  for (std::size_t i = 0; i < core::SampleReader::kFirstReal; ++i) {
    if (reader.id(i).sequence == sequence) continue;
    sequence = reader.id(i).sequence;
    const core::ImagePair pair = reader.read(i);
    pairs.push_back(toPair(pair.left, pair.right, arguments));
  }
  return pairs;
}

}  // namespace

std::vector<StereoImages> loadImages(const Arguments& arguments) {
  if (arguments.images.empty()) return samples(arguments);
  if (fs::is_directory(arguments.images)) return fromFiles(pairsOf(arguments.images), arguments);
  const std::vector<std::string> files = core::splitList(arguments.images);
  if (files.size() != 2) {
    throw core::DatasetError("--images '" + arguments.images +
                             "' is neither a folder nor two files separated by a comma");
  }
  return fromFiles({{files[0], files[1]}}, arguments);
}

}  // namespace corrsel::load_test
