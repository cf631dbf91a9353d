#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "drivers/recording/atomic_file.hpp"
#include "drivers/recording/trajectory_file.hpp"
#include "fusion/motion/deskew.hpp"
#include "fusion/motion/odometry_filter.hpp"
#include "packaging/python/arrays.hpp"
#include "packaging/python/bindings.hpp"

namespace infuse::python {
namespace {

using geometry::Trajectory;

std::vector<recording::TrajectoryPose> to_lines(const py::object& stamps_ns,
                                                const py::object& poses) {
  const auto stamps = to_vector<int64_t>(stamps_ns, "stamps_ns");
  const auto given = to_poses(poses);
  if (given.size() != stamps.size()) throw py::value_error("poses: not as many as stamps");
  std::vector<recording::TrajectoryPose> lines;
  for (size_t k = 0; k < stamps.size(); ++k) {
    if (k > 0 && stamps[k] <= stamps[k - 1]) {
      throw py::value_error("stamps_ns: " + std::to_string(k) + " is not after the one before");
    }
    lines.push_back({Stamp::from_ns(stamps[k]), given[k]});
  }
  return lines;
}

void write_text(const std::filesystem::path& path, const std::string& text) {
  const py::gil_scoped_release release;
  value_or_raise(recording::write_file_atomically(path, std::as_bytes(std::span(text))));
}

void write_tum(const std::filesystem::path& path, const py::object& stamps_ns,
               const py::object& poses) {
  write_text(path, recording::format_tum(to_lines(stamps_ns, poses)));
}

void write_kitti(const std::filesystem::path& path, const py::object& poses) {
  std::vector<recording::TrajectoryPose> lines;
  for (const auto& pose : to_poses(poses)) {
    lines.push_back({Stamp::from_ns(static_cast<int64_t>(lines.size())), pose});
  }
  write_text(path, recording::format_kitti(lines));
}

py::tuple read_trajectory(const std::filesystem::path& path) {
  const auto lines = value_or_raise(recording::read_trajectory(path));
  const auto n = static_cast<py::ssize_t>(lines.size());
  py::array_t<int64_t> stamps(n);
  py::array_t<double> poses({n, py::ssize_t{4}, py::ssize_t{4}});
  for (size_t k = 0; k < lines.size(); ++k) {
    stamps.mutable_data()[k] = lines[k].stamp.ns();
    Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(poses.mutable_data() + 16 * k) =
        lines[k].T_frame_body.matrix();
  }
  return py::make_tuple(stamps, poses);
}

std::shared_ptr<Trajectory> make_trajectory(const py::object& stamps_ns, const py::object& given,
                                            int64_t max_gap_ns) {
  const auto lines = to_lines(stamps_ns, given);
  if (lines.empty()) throw py::value_error("stamps_ns: there are none");
  geometry::TrajectoryOptions options;
  options.capacity = lines.size();
  options.max_gap = Duration(max_gap_ns);
  auto trajectory = std::make_shared<Trajectory>(require_valid(options));
  for (const recording::TrajectoryPose& line : lines) {
    trajectory->append({.stamp = line.stamp, .T_odom_vehicle = line.T_frame_body});
  }
  return trajectory;
}

/// (N, 4, 4)
py::array_t<double> poses_of(const Trajectory& trajectory) {
  py::array_t<double> array(
      {static_cast<py::ssize_t>(trajectory.size()), py::ssize_t{4}, py::ssize_t{4}});
  for (size_t k = 0; k < trajectory.size(); ++k) {
    Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(array.mutable_data() + 16 * k) =
        trajectory[k].T_odom_vehicle.matrix();
  }
  return array;
}

py::array_t<int64_t> stamps_of(const Trajectory& trajectory) {
  py::array_t<int64_t> array(static_cast<py::ssize_t>(trajectory.size()));
  for (size_t k = 0; k < trajectory.size(); ++k) {
    array.mutable_data()[k] = trajectory[k].stamp.ns();
  }
  return array;
}

py::tuple pose_at(const Trajectory& trajectory, int64_t stamp_ns) {
  const geometry::PoseAt pose = trajectory.at(Stamp::from_ns(stamp_ns));
  if (!pose.usable()) throw Failure(pose.reason);
  return py::make_tuple(to_array(pose.T_odom_vehicle), to_array(Eigen::MatrixXd(pose.covariance)));
}

std::unique_ptr<motion::DeskewedSweep> deskew(const Sweep& sweep, const Trajectory& trajectory,
                                              const py::object& T_vehicle_lidar,
                                              const std::optional<int64_t>& reference_ns) {
  motion::Deskewer deskewer(to_pose(T_vehicle_lidar, "T_vehicle_lidar"));
  const Stamp reference = reference_ns ? Stamp::from_ns(*reference_ns) : sweep.stamp + sweep.span;
  auto deskewed = std::make_unique<motion::DeskewedSweep>();
  {
    const py::gil_scoped_release release;
    deskewer.deskew(sweep, trajectory, reference, *deskewed);
  }
  if (!deskewed->usable()) throw Failure(deskewed->reason);
  return deskewed;
}

/// Dead reckoning.
class Odometry {
 public:
  Odometry(double wheelbase, double track, double steering_ratio, bool planar, size_t capacity)
      : filter_(options(wheelbase, track, steering_ratio, planar), trajectory_options(capacity)) {}

  template <class Sample>
  void add(const Sample& sample) {
    filter_.add(sample);
  }
  void flush() { filter_.flush(); }
  std::string reason() const { return filter_.reason(); }
  double wheel_scale() const { return filter_.report().wheel_scale.value; }
  std::shared_ptr<Trajectory> trajectory() const {
    return std::make_shared<Trajectory>(filter_.trajectory());
  }

 private:
  static motion::OdometryOptions options(double wheelbase, double track, double steering_ratio,
                                         bool planar) {
    motion::OdometryOptions options;
    options.wheelbase = wheelbase;
    options.track = track;
    options.steering_ratio = steering_ratio;
    options.planar = planar;
    return require_valid(options);
  }
  static geometry::TrajectoryOptions trajectory_options(size_t capacity) {
    geometry::TrajectoryOptions options;
    options.capacity = capacity;
    require_valid(options);
    // A pose takes some 700 bytes.
    if (capacity > 1'000'000) throw py::value_error("capacity: more than 1 000 000 poses");
    return options;
  }

  motion::OdometryFilter filter_;
};

}  // namespace

void bind_motion(py::module_& parent) {
  py::module_ module = parent.def_submodule("motion", "Odometry, and deskewing by it.");
  py::class_<Trajectory, std::shared_ptr<Trajectory>>(
      module, "Trajectory",
      "Poses T_odom_vehicle by time; between two of them the vehicle moves at constant twist.")
      .def(py::init(&make_trajectory), py::arg("stamps_ns"), py::arg("poses"), py::kw_only(),
           py::arg("max_gap_ns") = geometry::TrajectoryOptions{}.max_gap.count(),
           "stamps_ns: (N,), rising. poses: (N, 4, 4). Between two poses further apart than "
           "max_gap_ns the pose is unknown.")
      .def("__len__", &Trajectory::size)
      .def_property_readonly("stamps_ns", &stamps_of, "(N,) int64")
      .def_property_readonly("poses", &poses_of, "(N, 4, 4)")
      .def("at", &pose_at, py::arg("stamp_ns"),
           "(T_odom_vehicle, (6, 6) covariance of a left perturbation). Error: not known then.");
  py::class_<motion::DeskewedSweep>(module, "DeskewedSweep",
                                    "Coordinates of a sweep's returns as if all had been measured "
                                    "at reference_ns; (N,) float32, m, not writable, not copied.")
      .def("__len__", [](const motion::DeskewedSweep& sweep) { return sweep.x.size(); })
      .def_property_readonly(
          "reference_ns", [](const motion::DeskewedSweep& sweep) { return sweep.reference.ns(); })
      .def_property_readonly("x",
                             [](const py::object& self) {
                               return view_of(self.cast<const motion::DeskewedSweep&>().x, self);
                             })
      .def_property_readonly("y",
                             [](const py::object& self) {
                               return view_of(self.cast<const motion::DeskewedSweep&>().y, self);
                             })
      .def_property_readonly("z",
                             [](const py::object& self) {
                               return view_of(self.cast<const motion::DeskewedSweep&>().z, self);
                             })
      .def_property_readonly(
          "points",
          [](const motion::DeskewedSweep& sweep) {
            return to_array({sweep.x, sweep.y, sweep.z});
          },
          "(N, 3) float32: a copy");
  module.def("deskew", &deskew, py::arg("sweep"), py::arg("trajectory"),
             py::arg("T_vehicle_lidar") = py::none(), py::kw_only(),
             py::arg("reference_ns") = py::none(),
             "Moves each return to where it would have been measured at reference_ns (the sweep's "
             "end), in the lidar frame of that time. Error: the trajectory does not cover the "
             "sweep, or it has no times.");
  module.def("write_tum", &write_tum, py::arg("path"), py::arg("stamps_ns"), py::arg("poses"),
             "Writes a trajectory as evo and the TUM benchmark have it: seconds, position, "
             "quaternion. stamps_ns: (N,), rising. poses: (N, 4, 4).");
  module.def("write_kitti", &write_kitti, py::arg("path"), py::arg("poses"),
             "Writes poses, (N, 4, 4), as the KITTI odometry benchmark has them: no stamps.");
  module.def(
      "read_trajectory", &read_trajectory, py::arg("path"),
      "Reads a trajectory in TUM or KITTI format: (stamps_ns (N,), poses (N, 4, 4)). KITTI's "
      "stamps are the poses' numbers. Error: a line that is neither, and which.");
  const motion::OdometryOptions defaults;
  py::class_<Odometry>(module, "Odometry",
                       "Dead reckoning from what there is of wheel speeds, yaw rate, inertial "
                       "unit, steering and GNSS speed.")
      .def(py::init<double, double, double, bool, size_t>(), py::kw_only(),
           py::arg("wheelbase") = defaults.wheelbase, py::arg("track") = defaults.track,
           py::arg("steering_ratio") = defaults.steering_ratio, py::arg("planar") = defaults.planar,
           py::arg("capacity") = 60'000,
           "wheelbase, track: m. steering_ratio: 0: unknown, it is estimated. capacity: poses of "
           "the trajectory that are kept, one each 10 ms.")
      .def("add", &Odometry::add<WheelOdometry>, py::arg("sample"),
           "Adds a sample, roughly in order of time.")
      .def("add", &Odometry::add<ImuSample>, py::arg("sample"))
      .def("add", &Odometry::add<GnssFix>, py::arg("sample"))
      .def("flush", &Odometry::flush, "Processes what waits for earlier samples.")
      .def_property_readonly("reason", &Odometry::reason, "why it is unusable now; or empty")
      .def_property_readonly("wheel_scale", &Odometry::wheel_scale, "true over measured speed")
      .def_property_readonly("trajectory", &Odometry::trajectory, "a copy of the poses so far");
}

}  // namespace infuse::python
