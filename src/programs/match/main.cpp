// corrsel_match: matches two images from the shell.

#include <yaml-cpp/yaml.h>

#include <iostream>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

#include "corrsel/camera_formats.h"
#include "programs/match/program.h"
#ifdef CORRSEL_HAS_REFERENCE
#include "corrsel/reference/reference_selectors.h"
#endif

namespace {

std::vector<std::uint8_t> encode(const std::string& ending, const cv::Mat& image) {
  std::vector<std::uint8_t> bytes;
  if (cv::haveImageWriter("x" + ending)) cv::imencode(ending, image, bytes);
  return bytes;
}

corrsel::core::Camera readCamera(const std::string& path, const std::string& name) {
  try {
    const YAML::Node file = YAML::LoadFile(path);
    const YAML::Node node = file["intrinsics"] ? file : file[name];
    if (!node || !node["intrinsics"])
      throw std::runtime_error("it has neither intrinsics nor a camera " + name);
    const YAML::Node coefficients =
        node[node["distortion_coeffs"] ? "distortion_coeffs" : "distortion_coefficients"];
    corrsel::core::KalibrCamera camera;
    camera.camera_model = node["camera_model"].as<std::string>();
    camera.intrinsics = node["intrinsics"].as<std::vector<double>>();
    camera.distortion_model = node["distortion_model"].as<std::string>();
    camera.distortion_coeffs = coefficients.as<std::vector<double>>();
    const auto size = node["resolution"].as<std::vector<int>>();
    if (size.size() == 2) camera.resolution = {size[0], size[1]};
    return corrsel::core::cameraFromKalibr(camera);
  } catch (const std::exception& error) {
    throw std::runtime_error(path + ": no camera can be read (" + error.what() +
                             "); give a YAML file of Kalibr or EuRoC, or fx,fy,cx,cy");
  }
}

}  // namespace

int main(int argc, char** argv) {
#ifdef CORRSEL_HAS_REFERENCE
  corrsel::core::addReferenceSelectors();
#endif
  corrsel::MatchFront front;
  front.program = "corrsel_match";
  front.decode = [](const std::vector<std::uint8_t>& bytes) { return cv::imdecode(bytes, cv::IMREAD_COLOR); };
  front.encode = encode;
  front.camera = readCamera;
  return corrsel::runMatch({argv + 1, argv + argc}, front, std::cout, std::cerr);
}
