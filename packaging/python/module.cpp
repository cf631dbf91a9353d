// The part of the Python module that calls the library. infuse/__init__.py gives it its public
// names.

#include "packaging/python/arrays.hpp"
#include "packaging/python/bindings.hpp"

#include "daemon/command_line/version.hpp"

PYBIND11_MODULE(_infuse, module) {
  namespace py = pybind11;
  using namespace infuse::python;
  module.doc() = "infuse: fusion of lidars, cameras and odometry";
  module.attr("__version__") = infuse::daemon::version();
  py::register_exception<Failure>(module, "Error", PyExc_RuntimeError);
  bind_measurement(module);
  bind_motion(module);
  bind_lidar(module);
  bind_recording(module);
  bind_registration(module);
  bind_dependence(module);
  bind_calibration(module);
  bind_monitoring(module);
  bind_streetmap(module);
  bind_study(module);
}
