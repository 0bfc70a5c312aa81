#pragma once

#include <string>
#include <utility>
#include <vector>

#include "corrsel/camera.h"

// Cameras of every kind. Every pixel of their images has a ray.
namespace corrsel::core::testing {

inline Camera plainCamera() {
  Camera camera;
  camera.matrix = {700, 2, 320, 0, 710, 240, 0, 0, 1};
  camera.size = {640, 480};
  return camera;
}

inline Camera radtanCamera() {
  Camera camera;
  camera.matrix = {981.2178, 0, 690, 0, 975.8994, 247.1364, 0, 0, 1};
  camera.distortion = {-0.3791375, 0.2148119, 0.001227094, 0.002343833, -0.07910379};
  camera.size = {1392, 512};
  return camera;
}

inline Camera rationalCamera() {
  Camera camera;
  camera.matrix = {605, 0, 638, 0, 604, 366, 0, 0, 1};
  camera.distortion = {0.5067, -2.7088, 0.000772, -0.0000575, 1.5731, 0.3855, -2.5278, 1.4989};
  camera.size = {1280, 720};
  return camera;
}

inline Camera fisheyeCamera() {
  Camera camera;
  camera.model = Camera::Model::kFisheye;
  camera.matrix = {400, 0, 639.5, 0, 400, 479.5, 0, 0, 1};
  camera.distortion = {-0.02, 0.003};
  camera.size = {1280, 960};
  return camera;
}

inline Camera panoramaCamera() {
  Camera camera;
  camera.model = Camera::Model::kEquirectangular;
  camera.size = {2048, 1024};
  return camera;
}

inline std::vector<std::pair<std::string, Camera>> allCameras() {
  return {{"plain", plainCamera()},
          {"radtan", radtanCamera()},
          {"rational", rationalCamera()},
          {"fisheye", fisheyeCamera()},
          {"panorama", panoramaCamera()}};
}

}  // namespace corrsel::core::testing
