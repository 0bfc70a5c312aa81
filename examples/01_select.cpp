// Selects the inliers among putative matches with `auto`, which finds out by itself what kind of scene they
// show.
//
// The matches are made up here: 700 follow a homography with half a pixel of noise, and 300 are unrelated.
// The program prints the status, the number of selected matches, the model and the confidence. It needs
// corrsel::core only.

#include <corrsel/random.h>
#include <corrsel/selectors/factory.h>

#include <iostream>

using namespace corrsel::core;

int main() {
  Correspondences matches;
  matches.left_size = matches.right_size = {640, 480};
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const double x = random.uniform(0, 640), y = random.uniform(0, 480);
    double u = random.uniform(0, 640), v = random.uniform(0, 480);
    if (i < 700) {
      const double w = 1 + 0.0002 * x;
      u = (0.95 * x - 0.1 * y + 40) / w + random.uniform(-0.5, 0.5);
      v = (0.1 * x + 0.95 * y - 20) / w + random.uniform(-0.5, 0.5);
    }
    matches.add(cv::Point2f(float(x), float(y)), cv::Point2f(float(u), float(v)));
  }

  const auto selector = createSelector("auto");
  const Selection selection = selector->select(matches);
  std::cout << toString(selection.status) << ": " << selection.n_selected << " of " << matches.size()
            << " matches, model " << toString(selection.model_kind) << ", confidence " << selection.confidence
            << "\n"
            << selection.message << "\n";
  if (selection.status != Status::kOk) return 1;
  for (const std::uint32_t row : selectedRows(selection.mask)) {
    // Here your program uses matches.left_x[row], left_y[row], right_x[row] and right_y[row].
    if (row >= matches.size()) return 1;
  }
  return 0;
}
