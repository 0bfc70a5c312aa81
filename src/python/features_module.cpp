// The Python module corrsel._features: extraction and matching over numpy arrays. Documentation for users is
// in the Python package, which wraps it.

#include <pybind11/stl.h>

#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "corrsel/features/extractor.h"
#include "corrsel/matching/guided.h"
#include "corrsel/matching/match_drawing.h"
#include "corrsel/matching/matcher.h"
#include "programs/match/program.h"
#include "python/arrays.h"

namespace corrsel::python {
namespace {

using Bytes = py::array_t<std::uint8_t, py::array::c_style>;

/// Rows x columns, or rows x columns x channels, of 8 or 16 bits, as a matrix that shares the array's memory.
cv::Mat imageFrom(const py::array& array) {
  if (array.ndim() < 2 || array.ndim() > 3) throw std::invalid_argument("an image has the wrong shape");
  const bool deep = py::isinstance<py::array_t<std::uint16_t>>(array);
  if (!deep && !py::isinstance<py::array_t<std::uint8_t>>(array)) {
    throw std::invalid_argument("an image is neither uint8 nor uint16");
  }
  const int channels = array.ndim() == 3 ? static_cast<int>(array.shape(2)) : 1;
  const py::ssize_t pixel = array.itemsize() * channels;
  // Strides of sides of one element or none mean nothing.
  const bool adjacent = (array.shape(1) <= 1 || array.strides(1) == pixel) &&
                        (channels == 1 || array.strides(2) == array.itemsize());
  const py::ssize_t step = array.shape(0) <= 1 ? pixel * array.shape(1) : array.strides(0);
  if (array.size() == 0) return {};
  if (!adjacent || step < pixel * array.shape(1)) {
    throw std::invalid_argument("the elements of an image's rows are not adjacent");
  }
  return cv::Mat(static_cast<int>(array.shape(0)), static_cast<int>(array.shape(1)),
                 CV_MAKETYPE(deep ? CV_16U : CV_8U, channels), const_cast<void*>(array.data()),
                 static_cast<std::size_t>(step));
}

/// Where features are looked for: None or an array, None or (x, y, width, height).
struct Region {
  Region(const py::object& mask, const py::object& area) {
    if (!mask.is_none()) {
      mask_ = Bytes(mask);
      region.mask = imageFrom(mask_);
    }
    if (!area.is_none()) {
      const auto sides = py::cast<std::vector<int>>(area);
      if (sides.size() != 4) throw std::invalid_argument("an area has not four numbers");
      region.area = {sides[0], sides[1], sides[2], sides[3]};
    }
  }
  core::FeatureRegion region;

 private:
  Bytes mask_;  ///< keeps the memory
};

/// An array that shares the matrix's memory.
py::array arrayFrom(const cv::Mat& descriptors) {
  auto* kept = new cv::Mat(descriptors.isContinuous() ? descriptors : descriptors.clone());
  const py::capsule owner(kept, [](void* matrix) { delete static_cast<cv::Mat*>(matrix); });
  const py::dtype type = kept->depth() == CV_8U ? py::dtype::of<std::uint8_t>() : py::dtype::of<float>();
  return py::array(type, {kept->rows, kept->cols}, kept->data, owner);
}

/// Height x width x 3 of uint8, a copy.
py::array pixelsFrom(const cv::Mat& image) {
  py::array pixels(py::dtype::of<std::uint8_t>(), {image.rows, image.cols, image.channels()});
  image.copyTo(cv::Mat(image.rows, image.cols, image.type(), pixels.mutable_data()));
  return pixels;
}

/// Keyword arguments for corrsel.Features.
py::dict toDict(core::Features&& features) {
  std::vector<float> x, y, size, angle, response;
  std::vector<std::int32_t> octave;
  for (const cv::KeyPoint& keypoint : features.keypoints) {
    x.push_back(keypoint.pt.x);
    y.push_back(keypoint.pt.y);
    size.push_back(keypoint.size);
    angle.push_back(keypoint.angle);
    response.push_back(keypoint.response);
    octave.push_back(keypoint.octave);
  }
  py::dict result;
  result["points"] = positions(x, y);
  result["descriptors"] = arrayFrom(features.descriptors);
  result["frame"] = python::arrayFrom(std::move(features.frames));
  result["size"] = python::arrayFrom(std::move(size));
  result["angle"] = python::arrayFrom(std::move(angle));
  result["response"] = python::arrayFrom(std::move(response));
  result["octave"] = python::arrayFrom(std::move(octave));
  result["image_size"] = py::make_tuple(features.image_size.width, features.image_size.height);
  result["detect_seconds"] = features.detect_seconds;
  result["describe_seconds"] = features.describe_seconds;
  return result;
}

/// What matching needs of a corrsel.Features.
core::Features featuresFrom(const py::object& object) {
  core::Features features;
  const auto [x, y] = coordinates(object.attr("points"));
  const auto response = vectorFrom<float>(object.attr("response"));
  if (!response.empty() && response.size() != x.size()) {
    throw std::invalid_argument("points and response differ in length");
  }
  for (std::size_t i = 0; i < x.size(); ++i) {
    features.keypoints.emplace_back(x[i], y[i], 0.0F, -1.0F, response.empty() ? 0.0F : response[i]);
  }
  features.frames = framesFrom(object.attr("frame"));
  if (!features.frames.empty() && features.frames.size() != features.keypoints.size()) {
    throw std::invalid_argument("points and frame differ in length");
  }
  const py::array descriptors = object.attr("descriptors");
  if (descriptors.ndim() != 2) throw std::invalid_argument("descriptors is not two-dimensional");
  const bool binary = py::isinstance<py::array_t<std::uint8_t>>(descriptors);
  if (!binary && !py::isinstance<py::array_t<float>>(descriptors)) {
    throw std::invalid_argument("descriptors is neither uint8 nor float32");
  }
  features.descriptors.create(static_cast<int>(descriptors.shape(0)), static_cast<int>(descriptors.shape(1)),
                              binary ? CV_8U : CV_32F);
  const auto contiguous = py::array::ensure(descriptors, py::array::c_style);
  if (!features.descriptors.empty()) {
    std::memcpy(features.descriptors.data, contiguous.data(), static_cast<std::size_t>(contiguous.nbytes()));
  }
  const py::object size = object.attr("image_size");
  if (!size.is_none()) features.image_size = sizeFrom(size);
  return features;
}

core::MatchOptions matchOptions(const core::OptionMap& values) {
  core::MatchOptions options;
  core::setOptions(options, values, "match");
  options.check();
  return options;
}

py::dict extract(const core::FeatureExtractor& extractor, const py::array& image, const py::object& mask,
                 const py::object& area, int threads) {
  const cv::Mat pixels = imageFrom(image);
  const Region region(mask, area);
  core::Features features;
  {
    const py::gil_scoped_release released;
    features = extractor.extract(pixels, threads, region.region);
  }
  return toDict(std::move(features));
}

/// What matchGuided() needs besides features.
struct Guidance {
  core::Camera left_camera, right_camera;
  core::MotionGuess guess;
};

/// From (corrsel.Camera, corrsel.Camera, corrsel.MotionGuess), or None.
std::optional<Guidance> guidanceFrom(const py::object& object) {
  if (object.is_none()) return std::nullopt;
  const auto [left, right, guess] = py::cast<std::tuple<py::object, py::object, py::object>>(object);
  return Guidance{cameraFrom(left), cameraFrom(right), guessFrom(guess)};
}

core::Correspondences matchesOf(const core::Features& left, const core::Features& right,
                                const std::optional<Guidance>& guidance, const core::MatchOptions& options,
                                int threads) {
  if (!guidance) return core::matchFeatures(left, right, options, threads);
  return core::matchGuided(left, right, guidance->left_camera, guidance->right_camera, guidance->guess,
                           options, {}, threads)
      .matches;
}

py::dict match(const core::FeatureExtractor& extractor, const py::array& left, const py::array& right,
               const py::object& left_mask, const py::object& right_mask, const py::object& left_area,
               const py::object& right_area, const py::object& guided, const core::OptionMap& options,
               int threads) {
  const cv::Mat left_pixels = imageFrom(left), right_pixels = imageFrom(right);
  const Region left_region(left_mask, left_area), right_region(right_mask, right_area);
  const std::optional<Guidance> guidance = guidanceFrom(guided);
  const core::MatchOptions match_options = matchOptions(options);
  core::Correspondences matches;
  {
    const py::gil_scoped_release released;
    const auto [left_features, right_features] = core::extractPair(
        extractor, left_pixels, right_pixels, threads, left_region.region, right_region.region);
    matches = matchesOf(left_features, right_features, guidance, match_options, threads);
  }
  return python::toDict(std::move(matches));
}

py::dict matchFeatures(const py::object& left, const py::object& right, const py::object& guided,
                       const core::OptionMap& options, int threads) {
  const core::Features left_features = featuresFrom(left), right_features = featuresFrom(right);
  const std::optional<Guidance> guidance = guidanceFrom(guided);
  const core::MatchOptions match_options = matchOptions(options);
  core::Correspondences matches;
  {
    const py::gil_scoped_release released;
    matches = matchesOf(left_features, right_features, guidance, match_options, threads);
  }
  return python::toDict(std::move(matches));
}

/// Dictionaries as from toDicts() by the name of the algorithm, and those of the matching under "match".
py::dict algorithmOptions() {
  py::dict result;
  for (const auto& [name, options] : core::featureAlgorithms()) result[py::str(name)] = toDicts(*options);
  result["match"] = toDicts(core::MatchOptions());
  return result;
}

py::dict extractorOptions(const core::FeatureExtractor& extractor) {
  py::dict result;
  for (const auto& [name, options] : extractor.options()) result[py::str(name)] = toDicts(*options);
  return result;
}

core::GroupMotion groupMotionFrom(const std::string& text) {
  for (const core::GroupMotion motion : {core::GroupMotion::kStatic, core::GroupMotion::kMoving}) {
    if (core::toString(motion) == text) return motion;
  }
  return core::GroupMotion::kUnknown;
}

/// What is drawn of a corrsel.Selection.
core::Selection drawnSelection(const py::object& of) {
  core::Selection selection;
  selection.mask = vectorFrom<std::uint8_t>(of.attr("mask"));
  selection.group = vectorFrom<std::int32_t>(of.attr("group"));
  if (const py::object motion = of.attr("motion"); !motion.is_none()) {
    for (const py::handle text : motion)
      selection.motion.push_back(groupMotionFrom(text.cast<std::string>()));
  }
  selection.status = core::statusFromString(of.attr("status").cast<std::string>());
  selection.scene = core::sceneFromString(of.attr("scene").cast<std::string>());
  selection.n_selected = of.attr("n_selected").cast<std::size_t>();
  return selection;
}

py::array draw(const py::object& left, const py::object& right, const py::object& matches,
               const py::object& selection, int width, std::size_t max_lines, const std::string& title) {
  const cv::Mat left_pixels = left.is_none() ? cv::Mat() : imageFrom(left);
  const cv::Mat right_pixels = right.is_none() ? cv::Mat() : imageFrom(right);
  const core::Correspondences input = correspondencesFrom(matches);
  const core::Selection drawn = drawnSelection(selection);
  const core::SelectionDrawingOptions options{width, max_lines, title};
  cv::Mat picture;
  {
    const py::gil_scoped_release released;
    picture = core::drawSelection(left_pixels, right_pixels, input, drawn, options);
  }
  return pixelsFrom(picture);
}

/// What an NPZ file holds beside the matches.
py::dict npzValues(const MatchAnswer& answer) {
  const core::Selection& selection = answer.selection;
  const bool has_model = selection.model_kind != core::ModelKind::kNone;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto orNone = [](auto values) {
    return values.empty() ? py::object(py::none()) : py::object(python::arrayFrom(std::move(values)));
  };
  py::dict values;
  values["mask"] = python::arrayFrom(std::vector<std::uint8_t>(selection.mask));
  values["score"] = orNone(selection.score);
  values["group"] = orNone(selection.group);
  values["model"] = python::arrayFrom(has_model ? selection.model : cv::Matx33d::all(nan));
  values["model_kind"] = core::toString(selection.model_kind);
  values["status"] = core::toString(selection.status);
  values["image0"] = answer.left.file;
  values["image1"] = answer.right.file;
  return values;
}

/// Calls a function of a corrsel.__main__.Front. Its exceptions become those of C++, with their text alone.
template <class... Arguments>
py::object callFront(const py::object& front, const char* function, const Arguments&... arguments) {
  try {
    return front.attr(function)(arguments...);
  } catch (const py::error_already_set& error) {
    throw std::runtime_error(py::str(error.value()));
  }
}

/// Exit code, output and errors of the program that matches two images, with a corrsel.__main__.Front.
py::tuple matchProgram(const std::string& program, const std::vector<std::string>& words,
                       const py::object& front) {
  MatchFront functions;
  functions.program = program;
  functions.decode = [&front](const std::vector<std::uint8_t>& bytes) {
    const py::bytes data(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const py::object image = callFront(front, "decode", data);
    return image.is_none() ? cv::Mat() : imageFrom(image).clone();
  };
  functions.encode = [&front](const std::string& ending, const cv::Mat& image) {
    const std::string bytes = py::cast<py::bytes>(callFront(front, "encode", ending, pixelsFrom(image)));
    return std::vector<std::uint8_t>(bytes.begin(), bytes.end());
  };
  functions.camera = [&front](const std::string& path, const std::string& name) {
    return cameraFrom(callFront(front, "camera", path, name));
  };
  functions.write_npz = [&front](const std::string& path, const MatchAnswer& answer) {
    callFront(front, "write_npz", path, python::toDict(core::Correspondences(answer.matches)),
              npzValues(answer));
  };
  std::ostringstream out, errors;
  const int code = runMatch(words, functions, out, errors);
  return py::make_tuple(code, out.str(), errors.str());
}

}  // namespace
}  // namespace corrsel::python

PYBIND11_MODULE(_features, module) {
  using namespace corrsel;
  using namespace corrsel::python;
  module.def("extractor_names", &core::extractorNames);
  module.def("detector_names", &core::detectorNames);
  module.def("descriptor_names", &core::descriptorNames);
  module.def("missing_algorithms", &core::missingAlgorithms);
  module.def("algorithms_of", &core::algorithmsOf);
  module.def("algorithm_options", &algorithmOptions);
  module.def("match_features", &matchFeatures);
  module.def("draw", &draw);
  module.def("match_program", &matchProgram);
  py::class_<core::FeatureExtractor>(module, "Extractor")
      .def(py::init([](const std::string& name, const core::AlgorithmOptions& options) {
        return core::createExtractor(name, options);
      }))
      .def("name", &core::FeatureExtractor::name)
      .def("options", &extractorOptions)
      .def("extract", &extract)
      .def("match", &match);
}
