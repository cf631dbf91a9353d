#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "drivers/import/bag_import.hpp"
#include "drivers/import/kitti_import.hpp"
#include "packaging/python/arrays.hpp"
#include "packaging/python/bindings.hpp"
#include "packaging/python/player.hpp"

namespace infuse::python {
namespace {

namespace fs = std::filesystem;

template <class Mounts>
std::optional<size_t> find(const Mounts& mounts, const std::string& name, const char* kind) {
  if (name.empty()) return std::nullopt;
  std::string known;
  for (size_t k = 0; k < mounts.size(); ++k) {
    if (mounts[k].name == name) return k;
    known += (k == 0 ? "" : ", ") + mounts[k].name;
  }
  throw Failure(std::string("there is no ") + kind + " '" + name + "' (known: " + known + ")");
}

/// Iterator over what a recording holds.
class Items {
 public:
  Items(daemon::SensorSetup setup, const PlayerOptions& options, bool named)
      : player_(std::make_unique<Player>(std::move(setup), options)), named_(named) {}

  py::object next() {
    std::optional<Result<std::optional<Player::Item>>> item;
    {
      const Work work(busy_);
      item = player_->next();
    }
    std::optional<Player::Item> found = value_or_raise(std::move(*item));
    if (!found) throw py::stop_iteration();
    py::object value = std::visit(
        [](auto& measurement) { return py::cast(std::move(measurement)); }, found->second);
    return named_ ? py::make_tuple(found->first, value) : value;
  }

 private:
  std::unique_ptr<Player> player_;
  bool named_;  // (name of the sensor, item)
  bool busy_ = false;
};

/// A drive or a capture, which each iteration opens anew.
class Recording {
 public:
  Recording(fs::path path, const std::string& model, const std::string& calibration)
      : path_(std::move(path)) {
    overrides_.model = value_or_raise(daemon::requested_model(model));
    overrides_.calibration = calibration;
    const daemon::SensorSetup setup = open();
    rig_ = setup.rig;
  }

  const fs::path& path() const { return path_; }
  const Rig& rig() const { return rig_; }

  Items sweeps(const std::string& lidar, bool deskew) const {
    PlayerOptions options{.sweeps = true, .lidar = find(rig_.lidars, lidar, "lidar")};
    options.deskew = deskew;
    if (!options.lidar && rig_.lidars.size() == 1) options.lidar = 0;
    if (!options.lidar && !rig_.lidars.empty()) {
      throw Failure("there are several lidars: name one");
    }
    if (!options.lidar) throw Failure("there is no lidar");
    return {open(), options, false};
  }

  Items images(const std::string& camera) const {
    PlayerOptions options{.images = true, .camera = find(rig_.cameras, camera, "camera")};
    if (!options.camera && rig_.cameras.size() == 1) options.camera = 0;
    if (!options.camera) {
      throw Failure(rig_.cameras.empty() ? "there is no camera"
                                         : "there are several cameras: name one");
    }
    return {open(), options, false};
  }

  Items samples() const { return {open(), {.samples = true}, false}; }
  Items all() const { return {open(), {.sweeps = true, .images = true, .samples = true}, true}; }

 private:
  daemon::SensorSetup open() const {
    const py::gil_scoped_release release;
    return value_or_raise(daemon::open_drive(path_, {}, overrides_));
  }

  fs::path path_;
  daemon::LidarOverrides overrides_;
  Rig rig_;
};

}  // namespace

void bind_recording(py::module_& module) {
  py::class_<Items>(module, "Items", "Iterator over what a recording holds.")
      .def("__iter__", [](py::object self) { return self; })
      .def("__next__", &Items::next);
  py::class_<Recording>(module, "Recording",
                        "A drive or a capture. Each iterator reads it from its beginning; items "
                        "come in the order of their stamps.")
      .def(py::init<fs::path, const std::string&, const std::string&>(), py::arg("path"),
           py::kw_only(), py::arg("model") = "", py::arg("calibration") = "")
      .def_property_readonly("path", &Recording::path)
      .def_property_readonly("lidars", [](const Recording& self) { return self.rig().lidars; })
      .def_property_readonly("cameras", [](const Recording& self) { return self.rig().cameras; })
      .def("sweeps", &Recording::sweeps, py::arg("lidar") = "", py::kw_only(),
           py::arg("deskew") = false,
           "Iterator of Sweep of one lidar. deskew: each return moved to the end of its sweep, by "
           "the sensors that infused would use.")
      .def("images", &Recording::images, py::arg("camera") = "", "Iterator of Image of one camera.")
      .def("samples", &Recording::samples,
           "Iterator of WheelOdometry, ImuSample, GnssFix and GyroReadings.")
      .def("__iter__", &Recording::all,
           "Iterator of (name of the sensor, Sweep or Image or sample); samples are those of "
           "'vehicle'.");
  module.def(
      "import_kitti",
      [](const fs::path& folder, const fs::path& drive) {
        const py::gil_scoped_release release;
        value_or_raise(importers::import_kitti(folder, drive));
      },
      py::arg("folder"), py::arg("drive"));
  module.def(
      "import_bags",
      [](const std::vector<fs::path>& paths, const fs::path& drive) {
        const py::gil_scoped_release release;
        value_or_raise(importers::import_bags(paths, drive, {}));
      },
      py::arg("paths"), py::arg("drive"));
}

}  // namespace infuse::python
