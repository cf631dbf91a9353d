#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <memory>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "daemon/streetmap/street_map_file.hpp"
#include "drivers/measurement/angles.hpp"
#include "drivers/recording/atomic_file.hpp"
#include "fusion/streetmap/draw_map.hpp"
#include "fusion/streetmap/tracker.hpp"
#include "packaging/python/arrays.hpp"
#include "packaging/python/bindings.hpp"

namespace infuse::python {
namespace {

namespace fs = std::filesystem;
using streetmap::SegmentMap;

/// A street map, and the bytes that it reads in place.
struct Map {
  std::variant<std::vector<std::byte>, std::shared_ptr<const std::string>> memory;
  SegmentMap map;
  std::vector<std::string> warnings;
};

std::shared_ptr<Map> open_map(const fs::path& path) {
  const py::gil_scoped_release release;
  auto opened = value_or_raise(daemon::open_street_map_file(path));
  return std::make_shared<Map>(Map{opened.bytes, opened.map, {}});
}

daemon::StreetMapOptions compile_options(double cell_size, const py::object& clip_deg,
                                         const std::optional<double>& metres_per_pixel) {
  daemon::StreetMapOptions options;
  options.raster.cell_size = cell_size;
  require_valid(options.raster);
  if (metres_per_pixel) {
    options.image.emplace().metres_per_pixel = *metres_per_pixel;
    require_valid(*options.image);
  }
  if (clip_deg.is_none()) return options;
  const auto degrees = to_vector<double>(clip_deg, "clip_deg");
  const bool rectangle = degrees.size() == 4 && degrees[0] >= -180 && degrees[0] < degrees[2] &&
                         degrees[2] <= 180 && degrees[1] >= -90 && degrees[1] < degrees[3] &&
                         degrees[3] <= 90;
  if (!rectangle) throw py::value_error("clip_deg: not (west, south, east, north) in degrees");
  options.clip = osm::Bounds{degrees[1] * kDegree, degrees[0] * kDegree, degrees[3] * kDegree,
                             degrees[2] * kDegree};
  return options;
}

std::shared_ptr<Map> compile_map(const fs::path& source, double cell_size,
                                 const py::object& clip_deg,
                                 const std::optional<double>& metres_per_pixel) {
  const auto options = compile_options(cell_size, clip_deg, metres_per_pixel);
  if (daemon::is_image_file(source) != metres_per_pixel.has_value()) {
    throw py::value_error("metres_per_pixel: an image needs it, OpenStreetMap data have none");
  }
  const py::gil_scoped_release release;
  auto made = value_or_raise(daemon::make_street_map(source, options));
  auto map = std::make_shared<Map>(Map{std::move(made.bytes), {}, {}});
  map->map = value_or_raise(
      SegmentMap::open(std::get<std::vector<std::byte>>(map->memory), source.string()));
  for (const Error& warning : made.warnings) map->warnings.push_back(warning.message());
  return map;
}

std::span<const std::byte> bytes_of(const Map& map) {
  if (const auto* bytes = std::get_if<std::vector<std::byte>>(&map.memory)) return *bytes;
  return std::as_bytes(std::span(*std::get<std::shared_ptr<const std::string>>(map.memory)));
}

py::array_t<uint32_t> ids_at(const Map& map, const py::object& places) {
  const Eigen::MatrixXd at = to_matrix(places, "places");
  if (at.cols() != 2) throw py::value_error("places: the shape is not (N, 2)");
  py::array_t<uint32_t> ids(at.rows());
  for (Eigen::Index k = 0; k < at.rows(); ++k) {
    ids.mutable_data()[k] = map.map.id_at(at(k, 0), at(k, 1));
  }
  return ids;
}

py::array_t<double> origin_deg(const Map& map) {
  const streetmap::MapFrame& frame = map.map.frame();
  py::array_t<double> origin(2);
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  origin.mutable_data()[0] = frame.georeferenced ? frame.latitude / kDegree : unknown;
  origin.mutable_data()[1] = frame.georeferenced ? frame.longitude / kDegree : unknown;
  return origin;
}

streetmap::PlanarPose to_planar(const py::object& argument, const char* name) {
  const Eigen::Vector3d pose = to_fixed<3>(argument, name);
  return {pose.x(), pose.y(), pose.z()};
}

py::array_t<double> to_array(const streetmap::PlanarPose& pose) {
  const double values[3] = {pose.x, pose.y, pose.yaw};
  return py::array_t<double>(3, values);
}

/// Particles on a map.
class Tracker {
 public:
  Tracker(std::shared_ptr<Map> map, uint64_t seed)
      : map_(std::move(map)), tracker_(map_->map, options(seed)) {}

  void start(const py::object& pose, const py::object& covariance) {
    const auto at = to_planar(pose, "pose");
    const Eigen::Matrix3d spread = to_covariance<3>(covariance, "covariance");
    const Work work(busy_);
    tracker_.start(at, spread);
  }

  void predict(const py::object& motion, const py::object& covariance, double seconds) {
    const auto moved = to_planar(motion, "motion");
    const Eigen::Matrix3d spread = to_covariance<3>(covariance, "covariance");
    if (!(seconds >= 0 && seconds <= 3600)) throw py::value_error("seconds: not in 0 ... 3600");
    const Work work(busy_);
    tracker_.predict(moved, spread, from_seconds(seconds));
  }

  void add_sweep(const Sweep& sweep, const py::object& T_vehicle_lidar, const CameraFrame* image,
                 const CameraIntrinsics* intrinsics, const py::object& T_camera_lidar,
                 int image_step) {
    const streetmap::DeskewedView view{sweep, sweep.x, sweep.y, sweep.z,
                                       to_pose(T_vehicle_lidar, "T_vehicle_lidar")};
    const Eigen::Isometry3d pose = to_pose(T_camera_lidar, "T_camera_lidar");
    if ((image == nullptr) != (intrinsics == nullptr)) {
      throw py::value_error("image, intrinsics: one without the other");
    }
    if (image_step < 1 || image_step > 64) throw py::value_error("image_step: not in 1 ... 64");
    if (sweep.size() == 0) throw py::value_error("sweep: there are no points");
    if (image != nullptr &&
        (image->width != intrinsics->width || image->height != intrinsics->height)) {
      throw py::value_error("image: has not the intrinsics' size");
    }
    const Work work(busy_);
    if (image == nullptr) return tracker_.add_sweep(view, nullptr);
    if (!streetmap::extract_features(*image, image_step, features_)) return;
    const geometry::CameraModel camera(*intrinsics);
    const streetmap::ImageView seen{features_, camera, pose};
    tracker_.add_sweep(view, &seen);
  }

  void update() {
    const Work work(busy_);
    tracker_.update();
  }

  void add_fix(const py::object& position, const std::optional<double>& yaw, double hdop) {
    const Eigen::Vector2d at = to_fixed<2>(position, "position");
    if (yaw && !std::isfinite(*yaw)) throw py::value_error("yaw: not finite");
    if (!(hdop >= 0 && hdop <= 100)) throw py::value_error("hdop: not in 0 ... 100");
    const Work work(busy_);
    tracker_.add_fix({at, yaw, hdop});
  }

  streetmap::TrackerEstimate estimate() const {
    require_idle(busy_);
    return tracker_.estimate();
  }

  py::array_t<double> particles() const {
    require_idle(busy_);
    const auto all = tracker_.particles();
    Eigen::MatrixXd poses(static_cast<Eigen::Index>(all.size()), 3);
    for (size_t k = 0; k < all.size(); ++k) {
      const auto& pose = all[k].pose;
      poses.row(static_cast<Eigen::Index>(k)) << pose.x, pose.y, pose.yaw;
    }
    return python::to_array(poses);
  }

 private:
  static streetmap::TrackerOptions options(uint64_t seed) {
    streetmap::TrackerOptions options;
    options.seed = seed;
    return options;
  }

  std::shared_ptr<Map> map_;
  streetmap::Tracker tracker_;
  streetmap::ImageFeatures features_;
  bool busy_ = false;
};

void bind_map(py::module_& module) {
  std::vector<std::string> kinds;
  for (int kind = 0; kind < streetmap::kSegmentKindCount; ++kind) {
    kinds.emplace_back(streetmap::name_of(static_cast<streetmap::SegmentKind>(kind)));
  }
  module.attr("KINDS") = py::tuple(py::cast(kinds));
  py::class_<Map, std::shared_ptr<Map>>(
      module, "Map",
      "A street map: a raster of segment ids. Map frame: m, x east, y north of the origin.")
      .def(py::init(&open_map), py::arg("path"),
           "Opens a file of `infuse streetmap` or of save(), in place.")
      .def(
          "save",
          [](const Map& map, const fs::path& path) {
            const py::gil_scoped_release release;
            value_or_raise(recording::write_file_atomically(path, bytes_of(map)));
          },
          py::arg("path"), "Writes the file that `infused` reads.")
      .def("ids_at", &ids_at, py::arg("places"),
           "(N,) uint32: the segment at each of the (N, 2) places, m; 0: open land, outside.")
      .def(
          "kind_of",
          [](const Map& map, uint32_t id) { return streetmap::name_of(map.map.segment(id).kind); },
          py::arg("id"), "Kind of a segment, one of KINDS.")
      .def(
          "image",
          [](const Map& map, int largest) {
            if (largest < 1 || largest > 32768) {
              throw py::value_error("largest: not in 1 ... 32768");
            }
            const py::gil_scoped_release release;
            return streetmap::draw_map(map.map, largest);
          },
          py::arg("largest") = 2000, "The map drawn, north up: an Image of at most largest pixels.")
      .def_property_readonly("segments", [](const Map& map) { return map.map.segment_count(); })
      .def_property_readonly("cell_size", [](const Map& map) { return map.map.frame().cell_size; })
      .def_property_readonly(
          "extent",
          [](const Map& map) {
            const auto& frame = map.map.frame();
            const double west = frame.min_corner.x(), south = frame.min_corner.y();
            return py::make_tuple(west, west + map.map.columns() * frame.cell_size, south,
                                  south + map.map.rows() * frame.cell_size);
          },
          "(west, east, south, north), m: Matplotlib's extent of image()")
      .def_property_readonly("origin_deg", &origin_deg,
                             "(2,): latitude and longitude of the origin; NaN of a map of an image")
      .def_readonly("warnings", &Map::warnings, "defects of what it was compiled from");
}

void bind_estimate(py::module_& module) {
  using Estimate = streetmap::TrackerEstimate;
  py::class_<Estimate>(module, "TrackerEstimate",
                       "Pose on the map. state: 'TRACKING', 'UNSURE' or 'LOST'.")
      .def_property_readonly(
          "pose", [](const Estimate& e) { return to_array(e.pose); }, "(3,): x, y, yaw")
      .def_property_readonly(
          "covariance",
          [](const Estimate& e) { return python::to_array(Eigen::MatrixXd(e.covariance)); },
          "(3, 3), of x, y (m, map frame) and yaw (rad)")
      .def_property_readonly("T_map_vehicle",
                             [](const Estimate& e) { return python::to_array(e.T_map_vehicle()); })
      .def_property_readonly("state", [](const Estimate& e) { return streetmap::name_of(e.state); })
      .def_property_readonly(
          "reason", [](const Estimate& e) { return std::string(e.reason); },
          "why the pose is not certain; empty while TRACKING")
      .def_property_readonly("usable", &Estimate::usable)
      .def_readonly("score", &Estimate::score, "SMI at the pose, last update")
      .def_readonly("p_value", &Estimate::p_value, "of the scores of the last updates")
      .def_readonly("particles", &Estimate::particles, "number of particles");
}

}  // namespace

void bind_streetmap(py::module_& parent) {
  py::module_ module = parent.def_submodule("streetmap", "Localisation on a street map.");
  bind_map(module);
  bind_estimate(module);
  module.def("compile", &compile_map, py::arg("source"), py::kw_only(),
             py::arg("cell_size") = streetmap::RasterOptions{}.cell_size,
             py::arg("clip_deg") = py::none(), py::arg("metres_per_pixel") = py::none(),
             "Makes a Map of OpenStreetMap data (.osm, .osm.bz2, .osm.gz, .osm.pbf) or of a PNG or "
             "JPEG. cell_size: m. clip_deg: (west, south, east, north). metres_per_pixel: of an "
             "image. Error: what cannot be read.");
  py::class_<Tracker>(module, "Tracker",
                      "Tracks a vehicle on a Map by the dependence between segments and sensors: a "
                      "particle filter, I chapter 3. infused does the same of a drive: track(). "
                      "One thread at a time.")
      .def(py::init<std::shared_ptr<Map>, uint64_t>(), py::arg("map").none(false), py::kw_only(),
           py::arg("seed") = streetmap::TrackerOptions{}.seed)
      .def("start", &Tracker::start, py::arg("pose"), py::arg("covariance"),
           "pose: (3,), x, y (m, map frame), yaw (rad). covariance: (3, 3). Without a start all "
           "streets are searched.")
      .def("predict", &Tracker::predict, py::arg("motion"), py::arg("covariance"),
           py::arg("seconds"),
           "Moves the particles by (3,) in the vehicle frame before it, with (3, 3) noise.")
      .def("add_sweep", &Tracker::add_sweep, py::arg("sweep").none(false),
           py::arg("T_vehicle_lidar") = py::none(), py::kw_only(), py::arg("image") = py::none(),
           py::arg("intrinsics") = py::none(), py::arg("T_camera_lidar") = py::none(),
           py::arg("image_step") = 2,
           "Adds a Sweep, deskewed to the time of the particles, and an Image of that time. "
           "image_step: pixels of the image for one of the features.")
      .def("update", &Tracker::update, "Weights the particles by what was added.")
      .def("add_fix", &Tracker::add_fix, py::arg("position"), py::arg("yaw") = py::none(),
           py::kw_only(), py::arg("hdop") = 1.0,
           "Adds a GNSS fix at the time of the particles: (2,), m, map frame.")
      .def_property_readonly("estimate", &Tracker::estimate)
      .def_property_readonly("particles", &Tracker::particles, "(N, 3): x, y, yaw");
}

}  // namespace infuse::python
