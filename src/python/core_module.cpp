// The Python module corrsel._core: selectors, ground-truth errors and metrics over numpy arrays.
// Documentation for users is in the Python package, which wraps it.

#include <pybind11/stl.h>

#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "base/text.h"
#include "corrsel/evaluation/errors.h"
#include "corrsel/evaluation/metrics.h"
#include "corrsel/evaluation/pose.h"
#include "corrsel/evaluation/statistics.h"
#include "corrsel/motion_labels.h"
#include "corrsel/pose_result.h"
#include "corrsel/reference/reference_selectors.h"
#include "corrsel/selectors/factory.h"
#include "python/arrays.h"
#include "python/cameras.h"

namespace corrsel::python {
namespace {

/// b1 and b2 of translationBasis(), 2 x 3; None where there is no translation.
py::object basisOf(const cv::Vec3d& translation) {
  if (translation == cv::Vec3d()) return py::none();
  cv::Vec3d b1, b2;
  core::translationBasis(translation, b1, b2);
  return arrayFrom(cv::Matx23d(b1[0], b1[1], b1[2], b2[0], b2[1], b2[2]));
}

/// The arguments of corrsel.Pose.
py::tuple poseTuple(const core::Pose& pose) {
  return py::make_tuple(arrayFrom(pose.rotation), arrayFrom(pose.translation));
}

/// Keyword arguments for corrsel.PoseResult.
py::dict toDict(const core::PoseResult& found) {
  py::dict result;
  result["motion"] = core::toString(found.motion);
  result["rotation"] = arrayFrom(found.pose.rotation);
  result["translation"] = arrayFrom(found.pose.translation);
  result["basis"] = basisOf(found.pose.translation);
  result["covariance"] = arrayFrom(found.covariance);
  result["uncertain"] = found.uncertain;
  result["noise"] = found.noise;
  result["parallax"] = found.parallax;
  result["second"] = found.second ? py::object(poseTuple(*found.second)) : py::none();
  return result;
}

/// Keyword arguments for corrsel.Selection; those for the PoseResult are a dictionary in it.
py::dict selectMatches(const core::Selector& selector, const py::object& matches) {
  const core::Correspondences input = correspondencesFrom(matches);
  core::Selection selection;
  {
    const py::gil_scoped_release released;
    selection = selector.select(input);
    core::addConfidence(input, selection);
  }
  py::dict result;
  result["mask"] = arrayFrom<bool>(std::move(selection.mask), {static_cast<py::ssize_t>(input.size())});
  const bool scored = !selection.score.empty();
  result["score"] = scored ? py::object(arrayFrom(std::move(selection.score))) : py::none();
  const bool grouped = !selection.group.empty();
  result["group"] = grouped ? py::object(arrayFrom(std::move(selection.group))) : py::none();
  const bool modelled = selection.model_kind != core::ModelKind::kNone;
  result["model"] = modelled ? py::object(arrayFrom(selection.model)) : py::none();
  result["model_kind"] = core::toString(selection.model_kind);
  result["status"] = core::toString(selection.status);
  result["scene"] = core::toString(selection.scene);
  result["confidence"] = selection.confidence;
  result["sigma"] = selection.sigma;
  const bool rated = !selection.probability.empty();
  result["probability"] = rated ? py::object(arrayFrom(std::move(selection.probability))) : py::none();
  result["motion"] = py::none();  // see motionOf()
  result["pose"] = selection.pose ? py::object(toDict(*selection.pose)) : py::none();
  result["guess"] = core::toString(selection.guess);
  result["message"] = selection.message;
  result["seconds"] = selection.seconds;
  result["iterations"] = selection.iterations;
  result["n_input"] = selection.n_input;
  result["n_ignored"] = selection.n_ignored;
  result["n_selected"] = selection.n_selected;
  return result;
}

core::ModelKind modelKindFrom(const std::string& text) {
  for (const core::ModelKind kind :
       {core::ModelKind::kNone, core::ModelKind::kHomography, core::ModelKind::kFundamental,
        core::ModelKind::kEssential, core::ModelKind::kRotation}) {
    if (core::toString(kind) == text) return kind;
  }
  throw std::invalid_argument("unknown model kind '" + text + "'");
}

/// Mask, model, status, scene, confidence and iterations of a corrsel.Selection.
core::Selection selectionFrom(const py::object& of) {
  core::Selection selection;
  selection.mask = vectorFrom<std::uint8_t>(of.attr("mask"));
  selection.model_kind = modelKindFrom(of.attr("model_kind").cast<std::string>());
  if (selection.model_kind != core::ModelKind::kNone) selection.model = matrixFrom(of.attr("model"));
  selection.status = core::statusFromString(of.attr("status").cast<std::string>());
  selection.scene = core::sceneFromString(of.attr("scene").cast<std::string>());
  selection.confidence = of.attr("confidence").cast<double>();
  selection.iterations = of.attr("iterations").cast<int>();
  return selection;
}

/// Confidence, sigma, and probability (or None) of a corrsel.Selection.
py::tuple probabilityOf(const py::object& matches, const py::object& of) {
  const core::Correspondences input = correspondencesFrom(matches);
  core::Selection selection = selectionFrom(of);
  {
    const py::gil_scoped_release released;
    core::addProbability(input, selection);
  }
  const bool rated = !selection.probability.empty();
  return py::make_tuple(selection.confidence, selection.sigma,
                        rated ? py::object(arrayFrom(std::move(selection.probability))) : py::none());
}

/// Motion and poses of a corrsel.PoseResult.
core::PoseResult poseResultFrom(const py::object& of) {
  const auto poseFrom = [](const py::object& pose) {
    return core::Pose{matrixFrom(pose.attr("rotation")), vectorOfThree(pose.attr("translation"))};
  };
  core::PoseResult result;
  result.motion = core::motionFromString(of.attr("motion").cast<std::string>());
  result.pose = poseFrom(of);
  if (!of.attr("second").is_none()) result.second = poseFrom(of.attr("second"));
  return result;
}

/// Mask, group and motion of a corrsel.Selection after labelMotion().
py::tuple motionOf(const py::object& matches, const py::object& of) {
  const core::Correspondences input = correspondencesFrom(matches);
  core::Selection selection = selectionFrom(of);
  selection.group = vectorFrom<std::int32_t>(of.attr("group"));
  if (!of.attr("pose").is_none()) selection.pose = poseResultFrom(of.attr("pose"));
  {
    const py::gil_scoped_release released;
    core::labelMotion(input, selection);
  }
  py::list motion;
  for (const core::GroupMotion of_group : selection.motion) motion.append(core::toString(of_group));
  const auto rows = static_cast<py::ssize_t>(input.size());
  return py::make_tuple(arrayFrom<bool>(std::move(selection.mask), {rows}),
                        arrayFrom(std::move(selection.group)), py::tuple(motion));
}

py::array groundTruthErrors(const py::object& matches, const std::string& kind, const py::object& value) {
  const core::Correspondences input = correspondencesFrom(matches);
  core::GroundTruth truth;
  truth.kind = core::truthKindFromString(kind);
  py::array_t<float, py::array::c_style | py::array::forcecast> disparity;
  if (truth.kind == core::TruthKind::kLabels) {
    truth.labels = vectorFrom<std::uint32_t>(value);
  } else if (truth.kind == core::TruthKind::kDisparity) {
    disparity = py::array_t<float, py::array::c_style | py::array::forcecast>(value);
    if (disparity.ndim() != 2) throw std::invalid_argument("the disparity is not two-dimensional");
    truth.disparity = cv::Mat(static_cast<int>(disparity.shape(0)), static_cast<int>(disparity.shape(1)),
                              CV_32F, const_cast<float*>(disparity.data()));
  } else {
    truth.matrix = matrixFrom(value);
  }
  std::vector<double> errors;
  {
    const py::gil_scoped_release released;
    errors = core::groundTruthErrors(truth, input);
  }
  return arrayFrom(std::move(errors));
}

/// One column of the metrics of all tolerances.
template <class Value>
py::array column(const std::vector<core::Metrics>& metrics, Value core::Metrics::*member) {
  std::vector<Value> values;
  for (const core::Metrics& row : metrics) values.push_back(row.*member);
  return arrayFrom(std::move(values));
}

/// Keyword arguments for corrsel.Evaluation.
py::dict evaluate(const std::string& kind, const py::object& errors, const py::object& mask,
                  const std::optional<std::vector<double>>& tolerances,
                  const std::optional<double>& ground_truth_tolerance) {
  core::EvaluationOptions options;
  if (tolerances) options.tolerances = *tolerances;
  if (ground_truth_tolerance) options.ground_truth_tolerance = *ground_truth_tolerance;
  const std::vector<double> error_values = vectorFrom<double>(errors);
  const std::vector<std::uint8_t> mask_values = vectorFrom<std::uint8_t>(mask);
  core::Evaluation evaluation;
  {
    const py::gil_scoped_release released;
    evaluation = core::evaluate(core::truthKindFromString(kind), error_values, mask_values, options);
  }
  py::dict result;
  result["n_putative"] = evaluation.n_putative;
  result["n_ground_truth"] = evaluation.n_ground_truth;
  result["n_selected"] = evaluation.n_selected;
  result["tolerance"] = column(evaluation.metrics, &core::Metrics::tau);
  result["n_correct"] = column(evaluation.metrics, &core::Metrics::n_correct);
  result["precision"] = column(evaluation.metrics, &core::Metrics::precision);
  result["recall_paper"] = column(evaluation.metrics, &core::Metrics::recall_paper);
  result["recall_same_tau"] = column(evaluation.metrics, &core::Metrics::recall_same_tau);
  result["f_paper"] = column(evaluation.metrics, &core::Metrics::f_paper);
  result["f_same_tau"] = column(evaluation.metrics, &core::Metrics::f_same_tau);
  return result;
}

core::RelativePose poseFrom(const py::object& rotation, const py::object& translation) {
  core::RelativePose pose;
  pose.rotation = matrixFrom(rotation);
  pose.translation = vectorOfThree(translation);
  return pose;
}

py::tuple poseErrors(const py::object& rotation, const py::object& translation,
                     const py::object& true_rotation, const py::object& true_translation) {
  const core::RelativePose truth = poseFrom(true_rotation, true_translation);
  truth.check();
  const core::PoseErrors errors = core::poseErrors(matrixFrom(rotation), vectorOfThree(translation), truth);
  return py::make_tuple(errors.rotation, errors.translation, errors.pose);
}

py::array epipolarErrors(const py::object& matches, const py::object& rotation, const py::object& translation,
                         const py::object& left_camera, const py::object& right_camera) {
  core::RelativePose truth = poseFrom(rotation, translation);
  truth.left_camera = matrixFrom(left_camera);
  truth.right_camera = matrixFrom(right_camera);
  truth.check();
  return arrayFrom(core::epipolarErrors(truth, correspondencesFrom(matches)));
}

double cornerError(const py::object& homography, const py::object& truth,
                   const std::pair<int, int>& left_size) {
  return core::cornerError(matrixFrom(homography), matrixFrom(truth), {left_size.first, left_size.second});
}

/// Group, its meaning, name and meaning of every built-in selector, in the order of the factory.
py::list selectorList() {
  py::list result;
  for (const core::SelectorFactory& factory : core::builtInSelectors()) {
    result.append(py::make_tuple(core::toString(factory.group()), core::meaningOf(factory.group()),
                                 factory.name(), factory.meaning()));
  }
  return result;
}

}  // namespace
}  // namespace corrsel::python

PYBIND11_MODULE(_core, module) {
  using namespace corrsel;
  using namespace corrsel::python;
  core::addReferenceSelectors();
  module.attr("__version__") = CORRSEL_VERSION;
  module.def("selector_names", &core::selectorNames);
  module.def("valid_names", [](const std::string& word, const std::vector<std::string>& names) {
    return core::validNames(word, names);
  });
  module.def("selector_list", &selectorList);
  module.def("selector_presets", &core::selectorPresets);
  module.def("probability_of", &probabilityOf);
  module.def("motion_of", &motionOf);
  module.def("ground_truth_errors", &groundTruthErrors);
  module.def("evaluate", &evaluate);
  module.def("pose_errors", &poseErrors);
  module.def("epipolar_errors", &epipolarErrors);
  module.def("corner_error", &cornerError);
  module.def("error_auc", &core::errorAuc);
  module.def("mean_interval", [](const std::vector<double>& values) {
    const core::Interval interval = core::bootstrapMean(values, core::kBootstrapSeed);
    return std::make_tuple(core::mean(values), interval.low, interval.high);
  });
  module.def("threshold_accuracy", &core::thresholdAccuracy);
  addCameras(module);
  module.def("check_prior", [](const py::object& prior) { priorFrom(prior).check(); });
  module.def("check_guess", [](const py::object& guess) { guessFrom(guess).check(); });
  module.attr("FAILED_POSE") = core::kFailedPose;
  module.attr("POSE_THRESHOLDS") = core::kPoseThresholds;
  module.attr("ACCURACY_THRESHOLDS") = core::kAccuracyThresholds;
  py::class_<core::Selector>(module, "Selector")
      .def(py::init([](const std::string& spec, const core::OptionMap& options) {
        return core::createSelector(spec, options);
      }))
      .def("name", &core::Selector::name)
      .def("needed_input", &core::neededInput)
      .def("options", [](const core::Selector& selector) { return toDicts(selector.options()); })
      .def("select", &selectMatches);
}
