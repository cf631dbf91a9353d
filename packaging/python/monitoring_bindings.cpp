#include <pybind11/stl.h>

#include "drivers/camera/colour.hpp"
#include "fusion/monitoring/calibration_monitor.hpp"
#include "fusion/monitoring/reestimate.hpp"
#include "packaging/python/arrays.hpp"
#include "packaging/python/bindings.hpp"

namespace infuse::python {
namespace {

using monitoring::MonitorReport;
using monitoring::Reestimate;

const char* drift_name(monitoring::Drift drift) {
  switch (drift) {
    case monitoring::Drift::kLearning:
      return "learning";
    case monitoring::Drift::kHolds:
      return "holds";
    case monitoring::Drift::kSuspected:
      return "suspected";
    case monitoring::Drift::kConfirmed:
      return "confirmed";
  }
  return "";
}

/// Monitoring of one camera.
class Monitor {
 public:
  Monitor(const CameraIntrinsics& intrinsics, const py::object& T_camera_lidar,
          double min_interval_s, double min_distance)
      : intrinsics_(intrinsics),
        monitor_(intrinsics, to_pose(T_camera_lidar, "T_camera_lidar"),
                 options(min_interval_s, min_distance)) {}

  MonitorReport process(const CameraFrame& image, const Sweep& sweep, const py::object& twist) {
    if (image.width != intrinsics_.width || image.height != intrinsics_.height) {
      throw py::value_error("image: has not the intrinsics' size");
    }
    if (sweep.size() == 0) throw py::value_error("sweep: there are no points");
    geometry::Vector6 lidar = geometry::Vector6::Zero();
    if (!twist.is_none()) lidar = to_fixed<6>(twist, "twist");
    const Work work(busy_);
    const Eigen::Isometry3d& T = monitor_.T_camera_lidar();
    const Eigen::Vector3d camera = T.inverse().translation();
    camera::to_grey(image, grey_);
    return monitor_.process(grey_, monitoring::make_sweep_view(sweep),
                            {T.linear() * lidar.head<3>(),
                             T.linear() * (lidar.tail<3>() + lidar.head<3>().cross(camera))});
  }

  void set_calibration(const py::object& T_camera_lidar) {
    const Eigen::Isometry3d pose = to_pose(T_camera_lidar, "T_camera_lidar");
    const Work work(busy_);
    monitor_.set_calibration(pose);
  }

  void inject_miscalibration(const py::object& T_camera_lidar) {
    const Eigen::Isometry3d pose = to_pose(T_camera_lidar, "T_camera_lidar");
    const Work work(busy_);
    monitor_.inject_miscalibration(pose);
  }

  Reestimate reestimate(int64_t since_ns, uint64_t seed) {
    monitoring::ReestimateOptions options;
    options.seed = seed;
    const Work work(busy_);
    const auto scenes = monitor_.scenes().lend(Stamp::from_ns(since_ns));
    auto result = monitoring::reestimate(scenes, intrinsics_, monitor_.T_camera_lidar(), options);
    monitor_.scenes().end_lending();
    return result;
  }

  size_t scenes() const {
    require_idle(busy_);
    return monitor_.scenes().size();
  }

  py::array_t<double> T_camera_lidar() const {
    require_idle(busy_);
    return to_array(monitor_.T_camera_lidar());
  }

 private:
  static monitoring::MonitorOptions options(double min_interval_s, double min_distance) {
    monitoring::MonitorOptions options;
    options.min_interval = min_interval_s;
    options.min_distance = min_distance;
    return require_valid(options);
  }

  CameraIntrinsics intrinsics_;
  monitoring::CalibrationMonitor monitor_;
  CameraFrame grey_;
  bool busy_ = false;
};

void bind_reports(py::module_& module) {
  using Report = MonitorReport;
  py::class_<Report>(module, "MonitorReport",
                     "What the images so far say of a calibration. drift: 'learning', 'holds', "
                     "'suspected' or 'confirmed'.")
      .def_property_readonly("stamp_ns", [](const Report& r) { return r.stamp.ns(); })
      .def_readonly("evaluated", &Report::evaluated)
      .def_property_readonly(
          "reason", [](const Report& r) { return std::string(r.reason); },
          "why this image was not evaluated; or empty")
      .def_readonly("dependence", &Report::dependence, "nats per return, at the calibration")
      .def_property_readonly("drift", [](const Report& r) { return drift_name(r.verdict.drift); })
      .def_property_readonly(
          "axis", [](const Report& r) { return monitoring::name_of(r.verdict.axis); },
          "the axis with the most evidence: 'rotation about y'")
      .def_property_readonly(
          "evidence", [](const Report& r) { return r.verdict.evidence; }, "nats, along that axis")
      .def_property_readonly(
          "threshold", [](const Report& r) { return r.verdict.threshold; },
          "nats, at which a drift is confirmed")
      .def_property_readonly(
          "offset", [](const Report& r) { return py::array_t<double>(6, r.verdict.offset.data()); },
          "(6,): estimated error of T_camera_lidar, (rx, ry, rz, tx, ty, tz), rad and m, left")
      .def_property_readonly(
          "sigma", [](const Report& r) { return py::array_t<double>(6, r.verdict.sigma.data()); },
          "(6,): standard deviation of offset")
      .def_property_readonly(
          "at_least", [](const Report& r) { return r.verdict.at_least; },
          "the offset is a lower bound")
      .def_property_readonly(
          "delay_s", [](const Report& r) { return r.verdict.delay; },
          "of the camera's stamps after its exposures")
      .def_property_readonly(
          "fault", [](const Report& r) { return monitoring::name_of(r.verdict.fault); },
          "'none', 'black', 'frozen', 'dirty', 'out of focus', 'late'")
      .def_property_readonly(
          "since_ns", [](const Report& r) { return r.since.ns(); },
          "last stamp without evidence for the drift")
      .def("__str__", [](const Report& r) { return monitoring::describe_drift(r.verdict); });
  py::class_<Reestimate>(module, "Reestimate",
                         "A calibration from a monitor's scenes, or why there is none. "
                         "covariance: (6, 6), (rx, ry, rz, tx, ty, tz), left.")
      .def_property_readonly("T_camera_lidar",
                             [](const Reestimate& r) { return to_array(r.T_camera_lidar); })
      .def_property_readonly(
          "covariance", [](const Reestimate& r) { return to_array(Eigen::MatrixXd(r.covariance)); })
      .def_readonly("scenes", &Reestimate::scenes)
      .def_readonly("moved", &Reestimate::moved, "Mahalanobis distance from the calibration before")
      .def_property_readonly("usable", &Reestimate::usable)
      .def_readonly("reason", &Reestimate::reason);
}

}  // namespace

void bind_monitoring(py::module_& module) {
  bind_reports(module);
  const monitoring::MonitorOptions defaults;
  py::class_<Monitor>(module, "Monitor",
                      "Monitors the calibration of a camera to a lidar by their dependence, image "
                      "by image, as infused does. One thread at a time.")
      .def(py::init<const CameraIntrinsics&, const py::object&, double, double>(),
           py::arg("intrinsics").none(false), py::arg("T_camera_lidar"), py::kw_only(),
           py::arg("min_interval_s") = defaults.min_interval,
           py::arg("min_distance") = defaults.min_distance,
           "min_interval_s, min_distance (m): between evaluations.")
      .def(
          "process", &Monitor::process, py::arg("image").none(false), py::arg("sweep").none(false),
          py::arg("twist") = py::none(),
          "Adds an Image and its Sweep, deskewed to the exposure and with ring and column; returns "
          "a MonitorReport. twist: (6,), rad/s and m/s, of the lidar in its own frame; an image "
          "without motion is not evaluated. calibration.each_pair() has all three.")
      .def("set_calibration", &Monitor::set_calibration, py::arg("T_camera_lidar"),
           "Sets a new calibration, (4, 4), and restarts the evidence.")
      .def("inject_miscalibration", &Monitor::inject_miscalibration, py::arg("T_camera_lidar"),
           "Replaces the calibration without restarting the evidence: simulates a drift.")
      .def("reestimate", &Monitor::reestimate, py::arg("since_ns") = 0, py::kw_only(),
           py::arg("seed") = monitoring::ReestimateOptions{}.seed,
           "Estimates the calibration from the scenes that were kept since a stamp; a Reestimate. "
           "The monitor's calibration stays.")
      .def_property_readonly("scenes", &Monitor::scenes, "number of scenes that are kept")
      .def_property_readonly("T_camera_lidar", &Monitor::T_camera_lidar, "(4, 4)");
}

}  // namespace infuse::python
