// Uses corrsel as an application outside its source tree does: 80 matches of a translation and 20 unrelated
// ones.

#include <corrsel/random.h>
#include <corrsel/selectors/factory.h>

#include <iostream>

int main() {
  corrsel::core::Correspondences matches;
  matches.left_size = matches.right_size = {640, 480};
  corrsel::core::Random random(1);
  for (int i = 0; i < 100; ++i) {
    const double x = random.uniform(0, 600), y = random.uniform(0, 450);
    const bool correct = i < 80;
    matches.left_x.push_back(static_cast<float>(x));
    matches.left_y.push_back(static_cast<float>(y));
    matches.right_x.push_back(static_cast<float>(correct ? x + 30 : random.uniform(0, 640)));
    matches.right_y.push_back(static_cast<float>(correct ? y + 20 : random.uniform(0, 480)));
  }
  const auto selector = corrsel::core::createSelector("ransac");
  const corrsel::core::Selection selection = selector->select(matches);
  std::cout << selection.n_selected << " of " << matches.size() << " matches selected\n";
  for (std::size_t i = 0; i < 80; ++i) {
    if (selection.mask[i] != 1) return 1;
  }
  return selection.n_selected < 85 ? 0 : 1;
}
