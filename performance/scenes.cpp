#include "scenes.h"

#include <map>
#include <tuple>
#include <utility>

namespace corrsel::performance {

std::shared_ptr<const std::vector<Scene>> scenes(SceneSpec spec, std::size_t count) {
  using Key =
      std::tuple<MatchSceneKind, std::size_t, double, bool, double, double, bool, bool, bool, std::size_t>;
  static std::map<Key, std::shared_ptr<const std::vector<Scene>>> made;
  auto& entry = made[Key(spec.kind, spec.n, spec.inlier_ratio, spec.sorted, spec.noise, spec.object_share,
                         spec.frames, spec.distances, spec.sizes, count)];
  if (!entry) {
    std::vector<Scene> list;
    for (spec.seed = 0; spec.seed < count; ++spec.seed) list.push_back(core::makeScene(spec));
    entry = std::make_shared<const std::vector<Scene>>(std::move(list));
  }
  return entry;
}

std::shared_ptr<const std::vector<Scene>> scenes(core::CalibratedSceneSpec spec, std::size_t count) {
  std::vector<Scene> list;
  for (spec.seed = 0; spec.seed < count; ++spec.seed) {
    core::CalibratedScene made = core::makeCalibratedScene(spec);
    Scene scene;
    scene.matches = std::move(made.matches);
    scene.inlier = std::move(made.inlier);
    list.push_back(std::move(scene));
  }
  return std::make_shared<const std::vector<Scene>>(std::move(list));
}

double modelRecall(const Scene& scene, const cv::Matx33d& model, double threshold) {
  std::size_t inliers = 0, met = 0;
  for (std::size_t i = 0; i < scene.inlier.size(); ++i) {
    if (!scene.inlier[i]) continue;
    ++inliers;
    const cv::Vec3d q = model * cv::Vec3d(scene.left[i].x, scene.left[i].y, 1);
    const cv::Point2d error = cv::Point2d(q[0] / q[2], q[1] / q[2]) - cv::Point2d(scene.right[i]);
    met += cv::norm(error) <= threshold ? 1U : 0U;
  }
  return inliers ? double(met) / double(inliers) : 0;
}

}  // namespace corrsel::performance
