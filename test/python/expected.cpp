// What the library computes in C++, for comparison with Python: prints JSON. The only argument is a folder
// with the images left.pgm and right.pgm.

#include <iostream>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <utility>
#include <vector>

#include "corrsel/datasets/scene.h"
#include "corrsel/evaluation/errors.h"
#include "corrsel/evaluation/metrics.h"
#include "corrsel/features/extractor.h"
#include "corrsel/matching/matcher.h"
#include "corrsel/reference/reference_selectors.h"
#include "corrsel/selectors/factory.h"

namespace {

using namespace corrsel::core;
using nlohmann::json;

json toJson(const cv::Size& size) { return {size.width, size.height}; }

json toJson(const cv::Matx33d& matrix) { return std::vector<double>(matrix.val, matrix.val + 9); }

json toJson(const Correspondences& matches) {
  return {{"left_x", matches.left_x},
          {"left_y", matches.left_y},
          {"right_x", matches.right_x},
          {"right_y", matches.right_y},
          {"distance", matches.distance},
          {"second_distance", matches.second_distance},
          {"probability", matches.probability},
          {"left_frame", matches.left_frame},
          {"right_frame", matches.right_frame},
          {"left_index", matches.left_index},
          {"right_index", matches.right_index},
          {"left_size", toJson(matches.left_size)},
          {"right_size", toJson(matches.right_size)}};
}

json toJson(const Selection& selection) {
  return {{"mask", selection.mask},
          {"score", selection.score},
          {"group", selection.group},
          {"model", toJson(selection.model)},
          {"model_kind", toString(selection.model_kind)},
          {"status", toString(selection.status)},
          {"scene", toString(selection.scene)},
          {"confidence", selection.confidence},
          {"sigma", selection.sigma},
          {"probability", selection.probability},
          {"guess", toString(selection.guess)},
          {"message", selection.message},
          {"iterations", selection.iterations},
          {"n_input", selection.n_input},
          {"n_ignored", selection.n_ignored},
          {"n_selected", selection.n_selected}};
}

json toJson(const Evaluation& evaluation) {
  json result = {{"n_putative", evaluation.n_putative},
                 {"n_ground_truth", evaluation.n_ground_truth},
                 {"n_selected", evaluation.n_selected}};
  for (const Metrics& metrics : evaluation.metrics) {
    result["tolerance"].push_back(metrics.tau);
    result["n_correct"].push_back(metrics.n_correct);
    result["precision"].push_back(metrics.precision);
    result["recall_paper"].push_back(metrics.recall_paper);
    result["recall_same_tau"].push_back(metrics.recall_same_tau);
    result["f_paper"].push_back(metrics.f_paper);
    result["f_same_tau"].push_back(metrics.f_same_tau);
  }
  return result;
}

/// Every selector with every preset.
json selections(const Correspondences& matches) {
  json result = json::object();
  for (const std::string& name : selectorNames()) {
    std::vector<std::string> specs = {name};
    for (const std::string& preset : selectorPresets(name)) specs.push_back(name + ":" + preset);
    for (const std::string& spec : specs) {
      Selection selection = createSelector(spec)->select(matches);
      addProbability(matches, selection);
      result[spec] = toJson(selection);
    }
  }
  return result;
}

json evaluated(const GroundTruth& truth, const MatchScene& scene) {
  const std::vector<double> errors = groundTruthErrors(truth, scene.matches);
  return {{"kind", toString(truth.kind)},
          {"matrix", toJson(truth.matrix)},
          {"errors", errors},
          {"evaluation", toJson(evaluate(truth.kind, errors, scene.inlier))}};
}

json sceneResults(MatchSceneKind kind) {
  SceneSpec spec;
  spec.kind = kind;
  spec.n = 300;
  MatchScene scene = makeScene(spec);
  GroundTruth model, labels;
  model.kind = kind == MatchSceneKind::kPlane ? TruthKind::kHomography : TruthKind::kFundamental;
  model.matrix =
      createSelector(kind == MatchSceneKind::kPlane ? "usac:h" : "usac:f")->select(scene.matches).model;
  labels.kind = TruthKind::kLabels;
  labels.labels.assign(scene.inlier.begin(), scene.inlier.end());
  return {{"matches", toJson(scene.matches)},
          {"inlier", scene.inlier},
          {"selections", selections(scene.matches)},
          {"evaluated", {evaluated(model, scene), evaluated(labels, scene)}}};
}

json featureResults(const std::string& name, const cv::Mat& left, const cv::Mat& right) {
  const auto extractor = createExtractor(name);
  const auto [features, right_features] = extractPair(*extractor, left, right, 1);
  json result = {{"frame", features.frames},
                 {"descriptors", json::array()},
                 {"matches", toJson(matchFeatures(features, right_features))}};
  for (const cv::KeyPoint& keypoint : features.keypoints) {
    result["x"].push_back(keypoint.pt.x);
    result["y"].push_back(keypoint.pt.y);
    result["size"].push_back(keypoint.size);
    result["angle"].push_back(keypoint.angle);
    result["response"].push_back(keypoint.response);
    result["octave"].push_back(keypoint.octave);
  }
  for (int row = 0; row < features.descriptors.rows; ++row) {
    cv::Mat values;
    features.descriptors.row(row).convertTo(values, CV_32F);
    result["descriptors"].push_back(std::vector<float>(values.begin<float>(), values.end<float>()));
  }
  return result;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: " << argv[0] << " FOLDER\n";
    return 2;
  }
  addReferenceSelectors();
  const std::string folder = argv[1];
  const cv::Mat left = cv::imread(folder + "/left.pgm", cv::IMREAD_UNCHANGED);
  const cv::Mat right = cv::imread(folder + "/right.pgm", cv::IMREAD_UNCHANGED);
  json result = {{"scenes", {sceneResults(MatchSceneKind::kPlane), sceneResults(MatchSceneKind::kSpace)}}};
  for (const std::string name : {"orb+orb", "sift+sift", "hessian_affine+sift"}) {
    result["features"][name] = featureResults(name, left, right);
  }
  std::cout << result << "\n";
}
