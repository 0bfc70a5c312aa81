#include "python/arrays.h"

#include <pybind11/stl.h>

#include <algorithm>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

namespace corrsel::python {
namespace {

/// The array with `dimensions` dimensions, of which those after the first have the lengths `lengths`.
py::array_t<float> floats(const py::handle& object, const std::vector<py::ssize_t>& lengths) {
  const py::array_t<float> array(py::reinterpret_borrow<py::object>(object));
  bool fits = array.ndim() == static_cast<py::ssize_t>(lengths.size()) + 1;
  for (std::size_t i = 0; fits && i < lengths.size(); ++i) {
    fits = array.shape(static_cast<py::ssize_t>(i) + 1) == lengths[i];
  }
  if (!fits) throw std::invalid_argument("an array has the wrong shape");
  return array;
}

py::object orNone(bool present, py::array&& array) {
  return present ? py::object(std::move(array)) : py::none();
}

}  // namespace

py::array arrayFrom(std::vector<core::AffineFrame>&& frames) {
  const auto size = static_cast<py::ssize_t>(frames.size());
  return arrayFrom<float>(std::move(frames), {size, 2, 3});
}

py::array positions(const std::vector<float>& x, const std::vector<float>& y) {
  py::array_t<float> result({static_cast<py::ssize_t>(x.size()), static_cast<py::ssize_t>(2)});
  auto rows = result.mutable_unchecked<2>();
  for (py::ssize_t i = 0; i < rows.shape(0); ++i) {
    rows(i, 0) = x[static_cast<std::size_t>(i)];
    rows(i, 1) = y[static_cast<std::size_t>(i)];
  }
  return result;
}

std::pair<std::vector<float>, std::vector<float>> coordinates(const py::handle& object) {
  const py::array_t<float> array = floats(object, {2});
  const auto rows = array.unchecked<2>();
  const auto n = static_cast<std::size_t>(rows.shape(0));
  std::pair<std::vector<float>, std::vector<float>> columns{std::vector<float>(n), std::vector<float>(n)};
  for (std::size_t i = 0; i < n; ++i) {
    columns.first[i] = rows(static_cast<py::ssize_t>(i), 0);
    columns.second[i] = rows(static_cast<py::ssize_t>(i), 1);
  }
  return columns;
}

std::vector<core::AffineFrame> framesFrom(const py::handle& object) {
  if (object.is_none()) return {};
  const py::array_t<float> array = floats(object, {2, 3});
  const auto elements = array.unchecked<3>();
  std::vector<core::AffineFrame> frames(static_cast<std::size_t>(elements.shape(0)));
  for (py::ssize_t i = 0; i < elements.shape(0); ++i) {
    for (py::ssize_t k = 0; k < 6; ++k) {
      frames[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)] = elements(i, k / 3, k % 3);
    }
  }
  return frames;
}

cv::Size sizeFrom(const py::handle& object) {
  const auto size = py::cast<std::pair<int, int>>(object);
  return {size.first, size.second};
}

cv::Matx33d matrixFrom(const py::handle& object) {
  const py::array_t<double> array(py::reinterpret_borrow<py::object>(object));
  const auto elements = array.unchecked<2>();
  if (elements.shape(0) != 3 || elements.shape(1) != 3) throw std::invalid_argument("a matrix is not 3 x 3");
  cv::Matx33d result;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) result(row, column) = elements(row, column);
  }
  return result;
}

core::Camera cameraFrom(const py::handle& object) {
  core::Camera camera;
  camera.model = core::cameraModelFromString(py::cast<std::string>(object.attr("model")));
  const py::object matrix = object.attr("matrix"), size = object.attr("size");
  if (!matrix.is_none()) camera.matrix = matrixFrom(matrix);
  if (!size.is_none()) camera.size = sizeFrom(size);
  const std::vector<double> distortion = vectorFrom<double>(object.attr("distortion"));
  if (distortion.size() > camera.distortion.size()) {
    throw std::invalid_argument("a camera has " + std::to_string(distortion.size()) + " coefficients");
  }
  std::copy(distortion.begin(), distortion.end(), camera.distortion.begin());
  camera.check();
  return camera;
}

cv::Vec3d vectorOfThree(const py::handle& object) {
  const std::vector<double> numbers = vectorFrom<double>(object);
  if (numbers.size() != 3) throw std::invalid_argument("a vector has not three numbers");
  return {numbers[0], numbers[1], numbers[2]};
}

core::PosePrior priorFrom(const py::handle& prior) {
  const py::object rotation = prior.attr("rotation"), vertical = prior.attr("vertical");
  if (!rotation.is_none()) return core::PosePrior::ofRotation(matrixFrom(rotation));
  const auto [first, second] =
      py::cast<std::pair<py::object, py::object>>(vertical.is_none() ? prior.attr("rig") : vertical);
  if (vertical.is_none()) return core::PosePrior::ofRig(matrixFrom(first), vectorOfThree(second));
  return core::PosePrior::ofVertical(vectorOfThree(first), vectorOfThree(second));
}

core::MotionGuess guessFrom(const py::handle& guess) {
  core::MotionGuess result;
  result.rotation = matrixFrom(guess.attr("rotation"));
  const py::object translation = guess.attr("translation");
  if (!translation.is_none()) result.translation = vectorOfThree(translation);
  result.rotation_sigma = py::cast<double>(guess.attr("rotation_sigma"));
  return result;
}

core::Correspondences correspondencesFrom(const py::handle& matches) {
  core::Correspondences result;
  std::tie(result.left_x, result.left_y) = coordinates(matches.attr("left"));
  std::tie(result.right_x, result.right_y) = coordinates(matches.attr("right"));
  result.distance = vectorFrom<float>(matches.attr("distance"));
  result.second_distance = vectorFrom<float>(matches.attr("second_distance"));
  result.probability = vectorFrom<float>(matches.attr("probability"));
  result.left_frame = framesFrom(matches.attr("left_frame"));
  result.right_frame = framesFrom(matches.attr("right_frame"));
  result.left_index = vectorFrom<std::uint32_t>(matches.attr("left_index"));
  result.right_index = vectorFrom<std::uint32_t>(matches.attr("right_index"));
  const py::object left_size = matches.attr("left_size"), right_size = matches.attr("right_size");
  if (!left_size.is_none()) result.left_size = sizeFrom(left_size);
  if (!right_size.is_none()) result.right_size = sizeFrom(right_size);
  const py::object left_camera = matches.attr("left_camera"), right_camera = matches.attr("right_camera");
  if (!left_camera.is_none()) result.left_camera = cameraFrom(left_camera);
  if (!right_camera.is_none()) result.right_camera = cameraFrom(right_camera);
  const py::object prior = matches.attr("prior");
  if (!prior.is_none()) result.prior = priorFrom(prior);
  const py::object guess = matches.attr("guess");
  if (!guess.is_none()) result.guess = guessFrom(guess);
  const std::string inconsistency = result.inconsistency();
  if (!inconsistency.empty()) throw std::invalid_argument(inconsistency);
  return result;
}

py::dict toDict(core::Correspondences&& matches) {
  // Columns that are absent because there is no match at all become arrays without rows.
  const bool none = matches.empty();
  const bool distances = none || !matches.distance.empty();
  const bool second_distances = none || !matches.second_distance.empty();
  const bool probabilities = none || !matches.probability.empty();
  const bool left_frames = none || !matches.left_frame.empty();
  const bool right_frames = none || !matches.right_frame.empty();
  const bool left_indices = none || !matches.left_index.empty();
  const bool right_indices = none || !matches.right_index.empty();
  py::dict result;
  result["left"] = positions(matches.left_x, matches.left_y);
  result["right"] = positions(matches.right_x, matches.right_y);
  result["distance"] = orNone(distances, arrayFrom(std::move(matches.distance)));
  result["second_distance"] = orNone(second_distances, arrayFrom(std::move(matches.second_distance)));
  result["probability"] = orNone(probabilities, arrayFrom(std::move(matches.probability)));
  result["left_frame"] = orNone(left_frames, arrayFrom(std::move(matches.left_frame)));
  result["right_frame"] = orNone(right_frames, arrayFrom(std::move(matches.right_frame)));
  result["left_index"] = orNone(left_indices, arrayFrom(std::move(matches.left_index)));
  result["right_index"] = orNone(right_indices, arrayFrom(std::move(matches.right_index)));
  result["left_size"] = py::make_tuple(matches.left_size.width, matches.left_size.height);
  result["right_size"] = py::make_tuple(matches.right_size.width, matches.right_size.height);
  return result;
}

py::list toDicts(const core::OptionSet& options) {
  py::list result;
  for (const core::OptionField& field : core::optionFields(options)) {
    py::dict choices;
    for (const auto& choice : field.choices) choices[py::str(choice.name)] = choice.meaning;
    py::dict option;
    option["name"] = field.name;
    option["value"] = field.get(options);
    option["range"] = field.range();
    option["unit"] = field.unit;
    option["choices"] = choices;
    option["description"] = field.description;
    result.append(option);
  }
  return result;
}

}  // namespace corrsel::python
