#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <opencv2/core/matx.hpp>
#include <string>
#include <utility>
#include <vector>

#include "corrsel/camera.h"
#include "corrsel/correspondences.h"
#include "corrsel/motion_guess.h"
#include "corrsel/options.h"
#include "corrsel/pose_prior.h"

/// Between numpy arrays and the value types of the core. The Python package has checked and converted its
/// arguments before they come here (python/corrsel/_arrays.py); what is checked here again protects memory.
namespace corrsel::python {

namespace py = pybind11;

/// An array that takes over the memory of the vector, without a copy. The elements of the array may be
/// arithmetic parts of the vector's elements: an N x 2 x 3 array of float from a vector of AffineFrame.
template <class Element, class Value>
py::array arrayFrom(std::vector<Value>&& values, const std::vector<py::ssize_t>& shape) {
  auto* kept = new std::vector<Value>(std::move(values));
  const py::capsule owner(kept, [](void* vector) { delete static_cast<std::vector<Value>*>(vector); });
  return py::array(py::dtype::of<Element>(), shape, kept->data(), owner);
}

template <class Value>
py::array arrayFrom(std::vector<Value>&& values) {
  const auto size = static_cast<py::ssize_t>(values.size());
  return arrayFrom<Value>(std::move(values), {size});
}

/// N x 2 x 3, float32.
py::array arrayFrom(std::vector<core::AffineFrame>&& frames);

/// N x 2, float32.
py::array positions(const std::vector<float>& x, const std::vector<float>& y);

/// The elements of a one-dimensional array; none where the object is None.
template <class Value>
std::vector<Value> vectorFrom(const py::handle& object) {
  if (object.is_none()) return {};
  const py::array_t<Value> array(py::reinterpret_borrow<py::object>(object));
  const auto elements = array.template unchecked<1>();
  std::vector<Value> values(static_cast<std::size_t>(elements.shape(0)));
  for (py::ssize_t i = 0; i < elements.shape(0); ++i) values[static_cast<std::size_t>(i)] = elements(i);
  return values;
}

/// The columns x and y of an N x 2 array.
std::pair<std::vector<float>, std::vector<float>> coordinates(const py::handle& object);

/// The frames of an N x 2 x 3 array; none where the object is None.
std::vector<core::AffineFrame> framesFrom(const py::handle& object);

/// From (width, height).
cv::Size sizeFrom(const py::handle& object);

/// Rows x columns, or one-dimensional where there is one column; float64.
template <int rows, int columns>
py::array arrayFrom(const cv::Matx<double, rows, columns>& values) {
  std::vector<py::ssize_t> shape = {rows};
  if (columns > 1) shape.push_back(columns);
  return py::array(py::dtype::of<double>(), shape, values.val);
}

/// The elements of a 3 x 3 array.
cv::Matx33d matrixFrom(const py::handle& object);

/// Reads a corrsel.Camera. Throws std::invalid_argument like Camera::check().
core::Camera cameraFrom(const py::handle& camera);

/// The elements of an array of three numbers.
cv::Vec3d vectorOfThree(const py::handle& object);

/// Reads a corrsel.PosePrior.
core::PosePrior priorFrom(const py::handle& prior);

/// Reads a corrsel.MotionGuess.
core::MotionGuess guessFrom(const py::handle& guess);

/// Reads a corrsel.Matches.
core::Correspondences correspondencesFrom(const py::handle& matches);

/// Keyword arguments for corrsel.Matches.
py::dict toDict(core::Correspondences&& matches);

/// Keyword arguments for corrsel.Option, one dictionary per option.
py::list toDicts(const core::OptionSet& options);

}  // namespace corrsel::python
