#include <pybind11/stl.h>

#include "drivers/measurement/camera_frame.hpp"
#include "drivers/measurement/gyro_readings.hpp"
#include "drivers/measurement/rig.hpp"
#include "drivers/measurement/vehicle_samples.hpp"
#include "packaging/python/arrays.hpp"
#include "packaging/python/bindings.hpp"
#include "packaging/python/sweep_memory.hpp"

namespace infuse::python {
namespace {

/// A property of a sweep: an array in place.
template <class T>
auto field(FieldVector<T> Sweep::*member) {
  return
      [member](const py::object& self) { return view_of(self.cast<const Sweep&>().*member, self); };
}

auto return_kind(const py::object& self) {
  const auto& sweep = self.cast<const Sweep&>();
  static_assert(sizeof(ReturnKind) == 1);
  return view_of(reinterpret_cast<const uint8_t*>(sweep.return_kind.data()),
                 {static_cast<py::ssize_t>(sweep.size())}, self);
}

/// One value for each of `n` returns; zeros if none are given.
template <class T>
FieldVector<T> field_of(const py::object& argument, const char* name, size_t n) {
  FieldVector<T> field(n, T{});
  if (argument.is_none()) return field;
  const std::vector<T> values = to_vector<T>(argument, name);
  if (values.size() != n) {
    throw py::value_error(std::string(name) + ": " + std::to_string(values.size()) +
                          " values for " + std::to_string(n) + " points");
  }
  std::copy(values.begin(), values.end(), field.begin());
  return field;
}

template <class T>
uint32_t count_of(const FieldVector<T>& numbers, const py::object& argument) {
  return argument.is_none() ? 0 : uint32_t{*std::max_element(numbers.begin(), numbers.end())} + 1;
}

Sweep make_sweep(const py::object& given, int64_t stamp_ns, const py::object& time_offset_ns,
                 const py::object& ring, const py::object& column, const py::object& reflectivity) {
  const Points points(given, "points");
  const auto& [x, y, z] = points.view();
  const size_t n = x.size();
  Sweep sweep;
  sweep.stamp = Stamp::from_ns(stamp_ns);
  sweep.x.assign(x.begin(), x.end());
  sweep.y.assign(y.begin(), y.end());
  sweep.z.assign(z.begin(), z.end());
  sweep.range.resize(n);
  for (size_t k = 0; k < n; ++k) sweep.range[k] = std::hypot(x[k], y[k], z[k]);
  sweep.reflectivity = field_of<float>(reflectivity, "reflectivity", n);
  sweep.ring = field_of<uint16_t>(ring, "ring", n);
  sweep.column = field_of<uint16_t>(column, "column", n);
  sweep.rings = static_cast<uint16_t>(std::min(count_of(sweep.ring, ring), 65535u));
  sweep.columns = count_of(sweep.column, column);
  sweep.time_offset_ns = field_of<int32_t>(time_offset_ns, "time_offset_ns", n);
  sweep.has_times = !time_offset_ns.is_none();
  const auto last = std::max_element(sweep.time_offset_ns.begin(), sweep.time_offset_ns.end());
  if (*std::min_element(sweep.time_offset_ns.begin(), sweep.time_offset_ns.end()) < 0) {
    throw py::value_error("time_offset_ns: a return before the sweep's stamp");
  }
  sweep.span = Duration(*last);
  sweep.return_kind = FieldVector<ReturnKind>(n, ReturnKind::kStrongest);
  return sweep;
}

void bind_sweep(py::module_& module) {
  py::class_<Sweep, std::unique_ptr<Sweep, SweepRecycler>>(
      module, "Sweep",
      "One turn of a lidar: arrays of one entry per return, in order of firing, not "
      "writable and not copied.\n\n"
      "x, y, z: (N,) float32, m, lidar frame at the moment of each return. "
      "range: m. reflectivity: 0 ... 1. ring: uint16, beams from below. "
      "column: uint16, firings. time_offset_ns: int32, after stamp_ns. "
      "return_kind: uint8, 0 strongest, 1 last, 2 both, 3 first, 4 second, "
      "5 second strongest.")
      .def(py::init(&make_sweep), py::arg("points"), py::kw_only(), py::arg("stamp_ns") = 0,
           py::arg("time_offset_ns") = py::none(), py::arg("ring") = py::none(),
           py::arg("column") = py::none(), py::arg("reflectivity") = py::none(),
           "A sweep of your own. points: (N, 3) or (N, 4), m, lidar frame; the others: (N,). "
           "Without time_offset_ns it cannot be deskewed, without ring and column it has no "
           "neighbours. ValueError: shapes that do not agree, values that are not finite.")
      .def("__len__", &Sweep::size)
      .def_property_readonly("x", field(&Sweep::x))
      .def_property_readonly("y", field(&Sweep::y))
      .def_property_readonly("z", field(&Sweep::z))
      .def_property_readonly("range", field(&Sweep::range))
      .def_property_readonly("reflectivity", field(&Sweep::reflectivity))
      .def_property_readonly("ring", field(&Sweep::ring))
      .def_property_readonly("column", field(&Sweep::column))
      .def_property_readonly("time_offset_ns", field(&Sweep::time_offset_ns))
      .def_property_readonly("return_kind", &return_kind)
      .def_property_readonly(
          "points",
          [](const Sweep& sweep) {
            return to_array({sweep.x, sweep.y, sweep.z});
          },
          "(N, 3) float32, m: a copy of x, y, z")
      .def_property_readonly("stamp_ns", [](const Sweep& sweep) { return sweep.stamp.ns(); })
      .def_property_readonly("span_ns", [](const Sweep& sweep) { return sweep.span.count(); })
      .def_readonly("rings", &Sweep::rings)
      .def_readonly("columns", &Sweep::columns)
      .def_readonly("has_times", &Sweep::has_times)
      .def_readonly("lost_packets", &Sweep::lost_packets)
      .def("__repr__", [](const Sweep& sweep) {
        return "<infuse.Sweep at " + std::to_string(sweep.stamp.ns()) + " ns, " +
               std::to_string(sweep.size()) + " returns>";
      });
}

/// Pixels of an image, rows from the top: (H, W), or (H, W, 3) blue, green, red; in place.
py::array_t<uint8_t> pixels_of(const py::object& self) {
  const auto& frame = self.cast<const CameraFrame&>();
  std::vector<py::ssize_t> shape{frame.height, frame.width};
  if (channels(frame.format) == 3) shape.push_back(3);
  return view_of(frame.pixels.data(), shape, self);
}

CameraFrame make_image(const py::object& given, int64_t stamp_ns) {
  const py::array pixels = numbers(given, "pixels");
  if (pixels.dtype().kind() != 'u' || pixels.itemsize() != 1) {
    throw py::type_error("pixels: not of uint8");
  }
  const bool colour = pixels.ndim() == 3 && pixels.shape(2) == 3;
  if ((pixels.ndim() != 2 && !colour) || pixels.size() == 0) {
    throw py::value_error("pixels: the shape is not (H, W) or (H, W, 3)");
  }
  if (pixels.shape(0) > 65535 || pixels.shape(1) > 65535) {
    throw py::value_error("pixels: a side is longer than 65535");
  }
  const auto rows = py::array_t<uint8_t, py::array::c_style>::ensure(pixels);
  CameraFrame frame;
  frame.stamp = Stamp::from_ns(stamp_ns);
  frame.height = static_cast<int>(rows.shape(0));
  frame.width = static_cast<int>(rows.shape(1));
  frame.format = colour ? PixelFormat::kBgr8 : PixelFormat::kGrey8;
  frame.pixels.assign(rows.data(), rows.data() + rows.size());
  return frame;
}

void bind_image(py::module_& module) {
  py::class_<CameraFrame>(module, "Image",
                          "An image of a camera. pixels: uint8, (H, W) grey or raw Bayer, or "
                          "(H, W, 3) blue, green, red; not writable and not copied. stamp_ns: "
                          "middle of the exposure.")
      .def(py::init(&make_image), py::arg("pixels"), py::kw_only(), py::arg("stamp_ns") = 0)
      .def_property_readonly("pixels", &pixels_of)
      .def_property_readonly("stamp_ns", [](const CameraFrame& frame) { return frame.stamp.ns(); })
      .def_readonly("sequence", &CameraFrame::sequence);
}

CameraIntrinsics make_intrinsics(int width, int height, double fx, double fy, double cx, double cy,
                                 const std::vector<double>& distortion, const std::string& model) {
  if (model != "pinhole" && model != "fisheye") {
    throw py::value_error("model: '" + model + "' is neither 'pinhole' nor 'fisheye'");
  }
  if (distortion.size() > 5) throw py::value_error("distortion: more than 5 coefficients");
  CameraIntrinsics intrinsics{.model = model == "pinhole" ? CameraIntrinsics::Model::kPinhole
                                                          : CameraIntrinsics::Model::kFisheye,
                              .width = width,
                              .height = height,
                              .fx = fx,
                              .fy = fy,
                              .cx = cx,
                              .cy = cy};
  std::copy(distortion.begin(), distortion.end(), intrinsics.distortion.begin());
  return require_valid(intrinsics);
}

void bind_rig(py::module_& module) {
  py::class_<CameraIntrinsics>(module, "Intrinsics",
                               "Directions to pixels. Pinhole: distortion (k1, k2, p1, p2, k3); "
                               "fisheye: (k1, k2, k3, k4); both as OpenCV has them.")
      .def(py::init(&make_intrinsics), py::arg("width"), py::arg("height"), py::arg("fx"),
           py::arg("fy"), py::arg("cx"), py::arg("cy"),
           py::arg("distortion") = std::vector<double>{}, py::arg("model") = "pinhole")
      .def_readonly("width", &CameraIntrinsics::width)
      .def_readonly("height", &CameraIntrinsics::height)
      .def_readonly("fx", &CameraIntrinsics::fx)
      .def_readonly("fy", &CameraIntrinsics::fy)
      .def_readonly("cx", &CameraIntrinsics::cx)
      .def_readonly("cy", &CameraIntrinsics::cy)
      .def_readonly("distortion", &CameraIntrinsics::distortion)
      .def_property_readonly("model", [](const CameraIntrinsics& intrinsics) {
        return intrinsics.model == CameraIntrinsics::Model::kPinhole ? "pinhole" : "fisheye";
      });
  py::class_<CameraMount>(module, "Camera", "A camera of a rig.")
      .def_readonly("name", &CameraMount::name)
      .def_readonly("lidar", &CameraMount::lidar, "name of the lidar of T_camera_lidar")
      .def_readonly("intrinsics", &CameraMount::intrinsics)
      .def_property_readonly("T_camera_lidar", [](const CameraMount& mount) {
        return to_array(mount.T_camera_lidar);
      });
  py::class_<LidarMount>(module, "Lidar", "A lidar of a rig.")
      .def_readonly("name", &LidarMount::name)
      .def_readonly("model", &LidarMount::model)
      .def_property_readonly("T_vehicle_lidar", [](const LidarMount& mount) {
        return to_array(mount.T_vehicle_lidar);
      });
}

template <class Sample>
py::class_<Sample> bind_sample(py::module_& module, const char* name, const char* doc) {
  return py::class_<Sample>(module, name, doc)
      .def_property_readonly("stamp_ns", [](const Sample& sample) { return sample.stamp.ns(); });
}

void bind_samples(py::module_& module) {
  constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();
  bind_sample<WheelOdometry>(module, "WheelOdometry",
                             "Motion as the vehicle measures it at one moment; NaN: not measured.")
      .def(py::init([](int64_t stamp_ns, std::array<double, 4> wheel_speed, double yaw_rate,
                       double steering_angle, double speed) {
             return WheelOdometry{Stamp::from_ns(stamp_ns), wheel_speed, yaw_rate, steering_angle,
                                  speed};
           }),
           py::arg("stamp_ns"), py::kw_only(),
           py::arg("wheel_speed") =
               std::array<double, 4>{kNotMeasured, kNotMeasured, kNotMeasured, kNotMeasured},
           py::arg("yaw_rate") = kNotMeasured, py::arg("steering_angle") = kNotMeasured,
           py::arg("speed") = kNotMeasured,
           "wheel_speed: m/s, front left, front right, rear left, rear right. yaw_rate: rad/s. "
           "steering_angle: rad at the steering wheel. speed: m/s, of what is not a wheel.")
      .def_readonly("wheel_speed", &WheelOdometry::wheel_speed)
      .def_readonly("yaw_rate", &WheelOdometry::yaw_rate)
      .def_readonly("steering_angle", &WheelOdometry::steering_angle)
      .def_readonly("speed", &WheelOdometry::speed);
  bind_sample<ImuSample>(module, "ImuSample", "Sample of an inertial unit, vehicle axes.")
      .def(py::init([](int64_t stamp_ns, std::array<double, 3> angular_velocity,
                       std::array<double, 3> linear_acceleration) {
             return ImuSample{Stamp::from_ns(stamp_ns), angular_velocity, linear_acceleration};
           }),
           py::arg("stamp_ns"), py::arg("angular_velocity"), py::arg("linear_acceleration"),
           "angular_velocity: rad/s. linear_acceleration: m/s², gravity included.")
      .def_readonly("angular_velocity", &ImuSample::angular_velocity)
      .def_readonly("linear_acceleration", &ImuSample::linear_acceleration);
  bind_sample<GyroReadings>(module, "GyroReadings", "Gyros in a lidar's housing, rad/s.")
      .def_readonly("rate", &GyroReadings::rate);
  bind_sample<GnssFix>(module, "GnssFix", "Fix of a GNSS receiver: rad, m, m/s.")
      .def_readonly("latitude", &GnssFix::latitude)
      .def_readonly("longitude", &GnssFix::longitude)
      .def_readonly("altitude", &GnssFix::altitude)
      .def_readonly("speed", &GnssFix::speed)
      .def_readonly("course", &GnssFix::course)
      .def_readonly("hdop", &GnssFix::hdop)
      .def_readonly("utc_ns", &GnssFix::utc_ns)
      .def_readonly("valid", &GnssFix::valid);
}

}  // namespace

void bind_measurement(py::module_& module) {
  bind_sweep(module);
  bind_image(module);
  bind_rig(module);
  bind_samples(module);
}

}  // namespace infuse::python
