#pragma once

#include "python/arrays.h"

namespace corrsel::python {

/// Adds to the module what corrsel.Camera calls.
void addCameras(py::module& module);

}  // namespace corrsel::python
