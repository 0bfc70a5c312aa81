// libFuzzer program: cameras of every kind, made from the fuzzer's bytes, their rays and projections.
// scripts/maintenance/fuzz.sh builds and runs it.

#include <cstdlib>
#include <iostream>
#include <opencv2/core.hpp>  // printing of points
#include <string>

#include "arbitrary.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace corrsel::core;
  using namespace corrsel::core::testing;
  ByteSource source(data, size);
  const Camera camera = arbitraryCamera(source);
  cv::Point2d pixel;
  pixel.x = arbitraryNumber(source, 300);
  pixel.y = arbitraryNumber(source, 200);
  cv::Vec3d point;
  for (double& value : point.val) value = arbitraryNumber(source, 2);
  const std::string fault = cameraFault(camera, pixel, point);
  if (!fault.empty()) {
    std::cerr << "\ncamera with the pixel " << pixel << " and the point " << point << ": " << fault
              << std::endl;
    std::abort();
  }
  return 0;
}
