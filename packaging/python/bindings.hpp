#pragma once

#include <pybind11/pybind11.h>

namespace infuse::python {

// Each adds a part of the module `infuse._infuse`, or the submodule of its name.
void bind_measurement(pybind11::module_& module);
void bind_lidar(pybind11::module_& module);
void bind_recording(pybind11::module_& module);
void bind_registration(pybind11::module_& module);
void bind_dependence(pybind11::module_& module);
void bind_motion(pybind11::module_& module);
void bind_calibration(pybind11::module_& module);
void bind_monitoring(pybind11::module_& module);
void bind_streetmap(pybind11::module_& module);
void bind_study(pybind11::module_& module);

}  // namespace infuse::python
