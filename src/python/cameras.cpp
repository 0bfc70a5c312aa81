#include "python/cameras.h"

#include <pybind11/stl.h>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <opencv2/core/matx.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "corrsel/camera.h"
#include "corrsel/camera_formats.h"

namespace corrsel::python {
namespace {

using Numbers = py::array_t<double, py::array::c_style>;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// The number of rows of an array whose rows have `columns` numbers.
std::size_t rowsOf(const Numbers& array, py::ssize_t columns) {
  if (array.ndim() != 2 || array.shape(1) != columns) {
    throw std::invalid_argument("an array has the wrong shape");
  }
  return static_cast<std::size_t>(array.shape(0));
}

/// An array of n rows of the given shape from the elements of all rows.
py::array rowsFrom(std::vector<double>&& values, std::size_t n, std::vector<py::ssize_t> shape) {
  shape.insert(shape.begin(), static_cast<py::ssize_t>(n));
  return arrayFrom<double>(std::move(values), shape);
}

/// From (width, height) or None.
cv::Size sizeOrNone(const py::object& size) { return size.is_none() ? cv::Size() : sizeFrom(size); }

/// Keyword arguments for corrsel.Camera.
py::dict toDict(const core::Camera& camera) {
  const bool panorama = camera.model == core::Camera::Model::kEquirectangular;
  const std::size_t coefficients = panorama ? 0 : camera.model == core::Camera::Model::kFisheye ? 4 : 8;
  py::dict result;
  result["model"] = core::toString(camera.model);
  result["matrix"] = panorama ? py::object(py::none()) : py::object(arrayFrom(camera.matrix));
  result["distortion"] =
      arrayFrom(std::vector<double>(camera.distortion.begin(), camera.distortion.begin() + coefficients));
  result["size"] = camera.size.empty() ? py::object(py::none())
                                       : py::object(py::make_tuple(camera.size.width, camera.size.height));
  return result;
}

py::dict fromOpenCv(const py::object& matrix, const py::object& distortion, const py::object& size,
                    bool fisheye) {
  const auto from = fisheye ? &core::cameraFromOpenCvFisheye : &core::cameraFromOpenCv;
  return toDict(from(matrixFrom(matrix), vectorFrom<double>(distortion), sizeOrNone(size)));
}

py::dict fromInfo(const std::string& model, const py::object& matrix, const py::object& distortion,
                  const py::object& size) {
  return toDict(
      core::cameraFromInfo({sizeFrom(size), model, vectorFrom<double>(distortion), matrixFrom(matrix)}));
}

py::dict fromColmap(const std::string& model, const py::object& size, const py::object& parameters) {
  return toDict(core::cameraFromColmap({model, sizeFrom(size), vectorFrom<double>(parameters)}));
}

py::dict fromKalibr(const std::string& camera_model, const py::object& intrinsics,
                    const std::string& distortion_model, const py::object& distortion,
                    const py::object& resolution) {
  return toDict(core::cameraFromKalibr({camera_model, vectorFrom<double>(intrinsics), distortion_model,
                                        vectorFrom<double>(distortion), sizeOrNone(resolution)}));
}

/// Rays, N x 3, and their Jacobians, N x 3 x 2, or None where they are not asked for.
py::tuple unproject(const py::object& of, const Numbers& points, bool jacobians) {
  const core::Camera camera = cameraFrom(of);
  const std::size_t n = rowsOf(points, 2);
  const double* const pixels = points.data();
  std::vector<double> directions(3 * n, kNone), derivatives(jacobians ? 6 * n : 0, kNone);
  {
    const py::gil_scoped_release released;
    core::Ray ray;
    for (std::size_t i = 0; i < n; ++i) {
      if (!core::unproject(camera, {pixels[2 * i], pixels[2 * i + 1]}, ray)) continue;
      std::copy_n(ray.direction.val, 3, &directions[3 * i]);
      if (jacobians) std::copy_n(ray.jacobian.val, 6, &derivatives[6 * i]);
    }
  }
  py::object of_rays = py::none();
  if (jacobians) of_rays = rowsFrom(std::move(derivatives), n, {3, 2});
  return py::make_tuple(rowsFrom(std::move(directions), n, {3}), of_rays);
}

/// Pixels, N x 2.
py::array project(const py::object& by, const Numbers& points) {
  const core::Camera camera = cameraFrom(by);
  const std::size_t n = rowsOf(points, 3);
  const double* const places = points.data();
  std::vector<double> pixels(2 * n, kNone);
  {
    const py::gil_scoped_release released;
    cv::Point2d pixel;
    for (std::size_t i = 0; i < n; ++i) {
      if (!core::project(camera, cv::Vec3d(&places[3 * i]), pixel)) continue;
      pixels[2 * i] = pixel.x;
      pixels[2 * i + 1] = pixel.y;
    }
  }
  return rowsFrom(std::move(pixels), n, {2});
}

}  // namespace

void addCameras(py::module& module) {
  module.def("checked_camera", [](const py::object& camera) { return toDict(cameraFrom(camera)); });
  module.def("scaled_camera", [](const py::object& camera, double factor) {
    return toDict(cameraFrom(camera).scaled(factor));
  });
  module.def("camera_from_opencv", &fromOpenCv);
  module.def("camera_from_info", &fromInfo);
  module.def("camera_from_colmap", &fromColmap);
  module.def("camera_from_kalibr", &fromKalibr);
  module.def("unproject", &unproject);
  module.def("project", &project);
}

}  // namespace corrsel::python
