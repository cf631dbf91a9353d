#include <pybind11/stl.h>

#include "fusion/registration/gicp.hpp"
#include "fusion/registration/global_guess.hpp"
#include "fusion/registration/lidar_trajectory.hpp"
#include "packaging/python/arrays.hpp"
#include "packaging/python/bindings.hpp"

namespace infuse::python {
namespace {

namespace reg = registration;

std::shared_ptr<reg::PreparedCloud> prepare(const py::object& given, double voxel_size) {
  reg::PrepareOptions options;
  options.voxel_size = voxel_size;
  require_valid(options);
  const Points points(given, "points");
  const py::gil_scoped_release release;
  return std::make_shared<reg::PreparedCloud>(reg::prepare_cloud(points.view(), options));
}

/// A prepared cloud as it is; points prepared as the target's default.
std::shared_ptr<reg::PreparedCloud> prepared(const py::object& cloud, double voxel_size) {
  if (py::isinstance<reg::PreparedCloud>(cloud)) {
    return cloud.cast<std::shared_ptr<reg::PreparedCloud>>();
  }
  return prepare(cloud, voxel_size);
}

reg::RegistrationResult align(const py::object& target, const py::object& source,
                              const py::object& guess, const std::string& factor,
                              double max_correspondence_distance, double robust_width,
                              double voxel_size, int max_iterations) {
  reg::RegistrationOptions options;
  options.max_correspondence_distance = max_correspondence_distance;
  options.steps.max_iterations = max_iterations;
  require_valid(options);
  if (!(robust_width >= 0) || !std::isfinite(robust_width)) {
    throw py::value_error("robust_width: negative or not finite");
  }
  const auto pose = to_pose(guess, "guess");
  const auto to = prepared(target, voxel_size), from = prepared(source, voxel_size);
  const auto run = [&](auto registered_by) {
    registered_by.noise.robust_width = robust_width;
    reg::Registration<decltype(registered_by)> registration(options, registered_by);
    const py::gil_scoped_release release;
    return registration.align(*to, from->cloud, pose);
  };
  if (factor == "gicp") return run(reg::GicpFactor{});
  if (factor == "plane") return run(reg::PointToPlaneFactor{});
  throw py::value_error("factor: '" + factor + "' is neither 'gicp' nor 'plane'");
}

reg::RegistrationResult global_align(const py::object& target, const py::object& source,
                                     double voxel_size) {
  reg::GlobalGuessOptions options;
  options.voxel_size = voxel_size;
  require_valid(options);
  const Points to(target, "target"), from(source, "source");
  const py::gil_scoped_release release;
  return reg::find_global_guess(to.view(), from.view(), options);
}

/// Odometry of the sweeps of one lidar.
class LidarOdometry {
 public:
  explicit LidarOdometry(const py::object& T_vehicle_lidar, double min_range)
      : trajectory_(to_pose(T_vehicle_lidar, "T_vehicle_lidar"), valid_options(min_range)) {}

  reg::LidarOdometryResult add(const Sweep& sweep, const py::object& guess) {
    std::optional<Eigen::Isometry3d> motion;
    if (!guess.is_none()) motion = to_pose(guess, "guess");
    if (sweep.size() == 0) throw py::value_error("sweep: there are no points");
    const Work work(busy_);
    return trajectory_.add(sweep, motion);
  }

  py::array_t<double> T_map_end() const {
    require_idle(busy_);
    return to_array(trajectory_.T_map_end());
  }

  void reset() {
    const Work work(busy_);
    trajectory_.reset();
  }

  /// The last sweep, deskewed to its middle: (N, 3).
  py::array_t<float> deskewed() const {
    require_idle(busy_);
    const motion::DeskewedSweep& sweep = trajectory_.deskewed();
    return to_array({sweep.x, sweep.y, sweep.z});
  }

 private:
  static reg::LidarOdometryOptions valid_options(double min_range) {
    reg::LidarOdometryOptions options;
    options.min_range = min_range;
    return require_valid(options);
  }

  reg::LidarTrajectory trajectory_;
  bool busy_ = false;
};

void bind_results(py::module_& module) {
  using Result = reg::RegistrationResult;
  py::class_<Result>(module, "RegistrationResult",
                     "Pose of one cloud in the frame of another, or the reason why it is not "
                     "known. covariance: (6, 6), (rx, ry, rz, tx, ty, tz), rad and m, of a left "
                     "perturbation in the target frame; 1e4 in the free directions.")
      .def_property_readonly("T_target_source",
                             [](const Result& r) { return to_array(r.T_target_source); })
      .def_property_readonly(
          "covariance", [](const Result& r) { return to_array(Eigen::MatrixXd(r.covariance)); })
      .def_property_readonly(
          "information", [](const Result& r) { return to_array(Eigen::MatrixXd(r.information)); })
      .def_readonly("free_directions", &Result::free_directions)
      .def_property_readonly("free_directions_text", &Result::free_directions_text)
      .def_readonly("rms", &Result::rms, "m, of the inliers' distances from the planes")
      .def_readonly("inliers", &Result::inliers)
      .def_readonly("points", &Result::points)
      .def_readonly("iterations", &Result::iterations)
      .def_readonly("converged", &Result::converged)
      .def_property_readonly("usable", &Result::usable)
      .def_property_readonly("reason", [](const Result& r) { return std::string(r.reason); });
  using Step = reg::LidarOdometryResult;
  py::class_<Step>(module, "OdometryResult",
                   "Pose of the vehicle at the middle of a sweep, in the frame of the vehicle "
                   "at the first one, and its motion since the sweep before.")
      .def_property_readonly("stamp_ns", [](const Step& r) { return r.stamp.ns(); })
      .def_property_readonly("T_map_vehicle",
                             [](const Step& r) { return to_array(r.T_map_vehicle); })
      .def_property_readonly("T_from_to",
                             [](const Step& r) { return to_array(r.motion.T_from_to); })
      .def_property_readonly(
          "information",
          [](const Step& r) { return to_array(Eigen::MatrixXd(r.motion.information)); },
          "(6, 6), of T_from_to; none in directions that the geometry leaves free")
      .def_property_readonly(
          "velocity", [](const Step& r) { return py::array_t<double>(6, r.velocity.data()); },
          "(6,), rad/s and m/s, vehicle frame")
      .def_readonly("registration", &Step::registration)
      .def_readonly("overlap", &Step::overlap)
      .def_property_readonly("usable", &Step::usable)
      .def_property_readonly("reason", [](const Step& r) { return std::string(r.reason); });
}

}  // namespace

void bind_registration(py::module_& parent) {
  py::module_ module = parent.def_submodule(
      "registration", "Poses between point clouds. Points: (N, 3) or (N, 4), m, or a Sweep.");
  bind_results(module);
  py::class_<reg::PreparedCloud, std::shared_ptr<reg::PreparedCloud>>(
      module, "PreparedCloud", "Points with their local planes and their search tree.")
      .def("__len__", [](const reg::PreparedCloud& cloud) { return cloud.cloud.size(); })
      .def_property_readonly(
          "points", [](const reg::PreparedCloud& cloud) { return to_array(cloud.cloud.points()); },
          "(N, 3) float32, in the order of the tree")
      .def_property_readonly(
          "normals",
          [](const reg::PreparedCloud& cloud) {
            return to_array({cloud.cloud.nx, cloud.cloud.ny, cloud.cloud.nz});
          },
          "(N, 3) float32; zeros where there is no plane");
  module.def("prepare", &prepare, py::arg("points"), py::kw_only(), py::arg("voxel_size") = 0.25,
             "Downsamples to one point per voxel (m; 0: all), fits local planes, builds the tree. "
             "ValueError: another shape, no points, one that is not finite.");
  module.def("align", &align, py::arg("target"), py::arg("source"), py::arg("guess") = py::none(),
             py::kw_only(), py::arg("factor") = "gicp",
             py::arg("max_correspondence_distance") =
                 reg::RegistrationOptions{}.max_correspondence_distance,
             py::arg("robust_width") = 0.0, py::arg("voxel_size") = 0.25,
             py::arg("max_iterations") = reg::StepLimits{}.max_iterations,
             "Finds the source's pose in the target's frame near the guess, (4, 4).\n\n"
             "target, source: PreparedCloud, or points, which are prepared with voxel_size. "
             "factor: 'gicp' (P 4.2.2) or 'plane'. robust_width: m, of the Geman-McClure kernel; "
             "0: none. Same numbers as the C++ call, on every processor.");
  module.def("global_align", &global_align, py::arg("target"), py::arg("source"), py::kw_only(),
             py::arg("voxel_size") = reg::GlobalGuessOptions{}.voxel_size,
             "Finds the pose without a guess, or says why not. Points in the frame of their "
             "lidar.");
  py::class_<LidarOdometry>(module, "LidarOdometry",
                            "Odometry from the sweeps of one lidar alone: deskews each, registers "
                            "it to a local map. One thread at a time.")
      .def(py::init<const py::object&, double>(), py::arg("T_vehicle_lidar") = py::none(),
           py::kw_only(), py::arg("min_range") = reg::LidarOdometryOptions{}.min_range)
      .def("add", &LidarOdometry::add, py::arg("sweep"), py::arg("guess") = py::none(),
           "Adds the next sweep, returns an OdometryResult. The first sweep waits for the second. "
           "guess: (4, 4), motion since the middle of the sweep before; without one the motion "
           "before is taken to continue.")
      .def_property_readonly("T_map_end", &LidarOdometry::T_map_end,
                             "pose at the end of the last sweep")
      .def_property_readonly("deskewed", &LidarOdometry::deskewed,
                             "(N, 3) float32: the last sweep, deskewed to its middle")
      .def("reset", &LidarOdometry::reset, "Forgets map and motion.");
}

}  // namespace infuse::python
