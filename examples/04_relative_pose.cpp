// Computes the motion of a camera, with its uncertainty, from matches between two images as a fisheye lens
// took them.
//
// The matches are made up here: 700 of 1000 are points seen before and after the camera has moved 0.8 to the
// right and turned by 6 degrees; the noise is up to half a pixel. The program prints what kind of motion the
// matches show, the pose, and the standard deviation of every angle. It needs corrsel::core only.

#include <corrsel/random.h>
#include <corrsel/selectors/factory.h>

#include <cmath>
#include <iostream>
#include <opencv2/core.hpp>

using namespace corrsel::core;

int main() {
  Camera camera;
  camera.model = Camera::Model::kFisheye;
  camera.matrix = {400, 0, 639.5, 0, 400, 479.5, 0, 0, 1};
  camera.distortion = {-0.02, 0.003};
  camera.size = {1280, 960};
  Correspondences matches;
  matches.left_camera = matches.right_camera = camera;

  const double angle = 6 * CV_PI / 180;
  const cv::Matx33d turn(std::cos(angle), 0, std::sin(angle), 0, 1, 0, -std::sin(angle), 0, std::cos(angle));
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const double x = random.uniform(-9, 9), y = random.uniform(-6, 6), z = random.uniform(2, 8);
    const double u = random.uniform(0, 1280), v = random.uniform(0, 960);
    const double noise_u = random.uniform(-0.5, 0.5), noise_v = random.uniform(-0.5, 0.5);
    cv::Point2d left, right(u, v);
    if (!project(camera, {x, y, z}, left)) continue;
    if (i < 700) project(camera, turn * cv::Vec3d(x - 0.8, y, z), right);
    right += cv::Point2d(noise_u, noise_v);
    matches.add(left, right);
  }

  const Selection selection = createSelector("pose")->select(matches);
  if (selection.status != Status::kOk || !selection.pose) {
    std::cerr << toString(selection.status) << ": " << selection.message << "\n";
    return 1;
  }
  const PoseResult& found = *selection.pose;
  std::cout << toString(found.motion) << ": " << selection.n_selected << " of " << matches.size()
            << " matches, noise " << found.noise << " px\nrotation\n"
            << found.pose.rotation << "\ntranslation " << found.pose.translation << "\nstandard deviations";
  for (int i = 0; i < 5; ++i) std::cout << " " << std::sqrt(found.covariance(i, i)) * 180 / CV_PI;
  std::cout << " degrees\n";
  return found.uncertain ? 1 : 0;
}
