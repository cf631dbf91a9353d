#include <pybind11/stl.h>

#include <future>
#include <numeric>

#include "daemon/tools/calibrate/calibration_comparison.hpp"
#include "daemon/tools/calibrate/calibration_run.hpp"
#include "daemon/tools/calibrate/scene_preparation.hpp"
#include "drivers/measurement/angles.hpp"
#include "packaging/python/arrays.hpp"
#include "packaging/python/bindings.hpp"
#include "tests/study/calibration/compared_measures.hpp"

namespace infuse::python {
namespace {

using daemon::CalibrationRun;
using daemon::ComparedExtrinsics;
using daemon::ScenePairs;

std::shared_ptr<ScenePairs> read_pairs(const std::vector<std::string>& drives,
                                       const std::vector<std::string>& cameras,
                                       const std::string& lidar, int max_scenes) {
  if (drives.empty()) throw py::value_error("drives: there are none");
  if (max_scenes < 1) throw py::value_error("max_scenes: less than 1");
  const py::gil_scoped_release release;
  return std::make_shared<ScenePairs>(value_or_raise(daemon::read_scene_pairs(
      {.drives = drives, .cameras = cameras, .lidar = lidar, .max_scenes = max_scenes},
      [](double) {})));
}

void each_pair(const std::string& drive, const py::function& on_pair, const std::string& camera,
               const std::string& lidar) {
  daemon::SceneRequest request{.drives = {drive}, .cameras = {camera}, .lidar = lidar};
  request.max_scenes = std::numeric_limits<int>::max();
  std::optional<py::error_already_set> raised;
  const auto consume = [&](ScenePairs&, daemon::ScenePair& pair) -> Result<void> {
    const py::gil_scoped_acquire acquire;
    try {
      py::object twist = py::none();
      if (pair.twist) twist = py::array_t<double>(6, pair.twist->data());
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      on_pair(py::cast(std::move(pair.frame)), py::cast(std::move(pair.sweep)), twist);
    } catch (py::error_already_set& error) {
      raised.emplace(std::move(error));
      return fail("stopped");
    }
    pair.release();
    return {};
  };
  Result<ScenePairs> read;
  {
    const py::gil_scoped_release release;
    read = daemon::read_scene_pairs(
        request, [](double) {}, consume);
  }
  if (raised) throw std::move(*raised);
  value_or_raise(std::move(read));
}

std::shared_ptr<ScenePairs> make_pairs(const std::vector<const Sweep*>& sweeps,
                                       const std::vector<const CameraFrame*>& images,
                                       const CameraIntrinsics& intrinsics) {
  if (sweeps.size() != images.size()) throw py::value_error("sweeps, images: not as many of each");
  if (sweeps.empty()) throw py::value_error("sweeps: there are none");
  auto pairs = std::make_shared<ScenePairs>();
  pairs->cameras.push_back({.name = "camera", .intrinsics = intrinsics, .lidar = "lidar"});
  pairs->lidar = "lidar";
  for (size_t k = 0; k < sweeps.size(); ++k) {
    if (sweeps[k] == nullptr || images[k] == nullptr)
      throw py::type_error("None is no measurement");
    if (images[k]->width != intrinsics.width || images[k]->height != intrinsics.height) {
      throw py::value_error("images: " + std::to_string(k) + " has not the intrinsics' size");
    }
    pairs->pairs.push_back({.name = std::to_string(k),
                            .stamp = images[k]->stamp,
                            .frame = *images[k],
                            .sweep = *sweeps[k]});
  }
  return pairs;
}

/// Measures of the programs, then those that are only compared with them.
std::vector<std::pair<std::string, std::string>> all_measures() {
  std::vector<std::pair<std::string, std::string>> names;
  for (const auto& measures : {calibration::named_measures(), study::compared_measures()}) {
    for (const auto& measure : measures) names.emplace_back(measure.name, measure.description);
  }
  return names;
}

const calibration::NamedMeasure& measure_of(const std::string& name) {
  if (const auto* found = study::find_any_measure(name)) return *found;
  std::string names;
  for (const auto& [known, description] : all_measures()) {
    names += (names.empty() ? "" : ", ") + known;
  }
  throw py::value_error("measure: '" + name + "' is none of " + names);
}

Eigen::Isometry3d initial_of(const ScenePairs& pairs, const py::object& initial) {
  return initial.is_none() ? pairs.cameras.front().T_camera_lidar : to_pose(initial, "initial");
}

/// Waits for work on another thread, so that Ctrl-C stops it.
template <class T>
T wait_for(std::future<T> result, std::stop_source& stop) {
  const py::gil_scoped_release release;
  while (result.wait_for(std::chrono::milliseconds(50)) != std::future_status::ready) {
    const py::gil_scoped_acquire acquire;
    if (PyErr_CheckSignals() == 0) continue;
    stop.request_stop();
    {
      const py::gil_scoped_release again;
      result.wait();
    }
    throw py::error_already_set();
  }
  return result.get();
}

/// A calibration as `infuse calibrate` makes it: of scenes without what it does not look at.
Result<CalibrationRun> run_prepared(const ScenePairs& given,
                                    const calibration::NamedMeasure& measure,
                                    const Eigen::Isometry3d& T_initial,
                                    const calibration::CalibrateOptions& options) {
  daemon::ScenePreparation preparation(
      {.measures = {&measure}, .calibrate = options, .T_refcam_lidar = T_initial, .T_old = {}});
  ScenePairs pairs;
  pairs.cameras = given.cameras;
  pairs.lidar = given.lidar;
  pairs.rig = given.rig;
  for (daemon::ScenePair pair : given.pairs) {
    if (auto prepared = preparation.prepare(pairs, pair); !prepared) {
      return tl::unexpected(prepared.error());
    }
    pairs.pairs.push_back(std::move(pair));
  }
  return daemon::run_calibration(pairs, daemon::move_scenes(pairs, 0), measure, T_initial, options);
}

std::shared_ptr<CalibrationRun> calibrate(const std::shared_ptr<ScenePairs>& pairs,
                                          const py::object& initial, const std::string& measure,
                                          double within_deg, uint64_t seed, int splits,
                                          bool check_intrinsics) {
  const auto& named = measure_of(measure);
  const Eigen::Isometry3d T_initial = initial_of(*pairs, initial);
  std::stop_source stop;
  calibration::CalibrateOptions options;
  options.screen.half_width = within_deg * kDegree;
  options.seed = seed;
  options.splits = splits;
  options.check_intrinsics = check_intrinsics;
  options.maximize.stop = stop.get_token();
  require_valid(options);
  auto run = wait_for(std::async(std::launch::async,
                                 [&] { return run_prepared(*pairs, named, T_initial, options); }),
                      stop);
  return std::make_shared<CalibrationRun>(value_or_raise(std::move(run)));
}

std::shared_ptr<ComparedExtrinsics> compare(const ScenePairs& pairs, const py::object& T_old,
                                            const py::object& T_new) {
  const Eigen::Isometry3d before = to_pose(T_old, "T_old"), after = to_pose(T_new, "T_new");
  const py::gil_scoped_release release;
  const auto scenes = value_or_raise(daemon::make_scenes(pairs, measure_of("joint"), before));
  return std::make_shared<ComparedExtrinsics>(daemon::compare_on(pairs, scenes, before, after));
}

/// A user's measure of the samples that a term compares at a pose; those without an image are left
/// out.
double call_measure(const py::function& measure, calibration::Objective& objective,
                    const Eigen::Isometry3d& pose) {
  auto [lidar, image] = [&] {
    const py::gil_scoped_release release;
    return objective.samples(pose, 0);
  }();
  size_t kept = 0;
  for (size_t k = 0; k < image.size(); ++k) {
    if (std::isnan(image[k]) || std::isnan(lidar[k])) continue;
    lidar[kept] = lidar[k], image[kept] = image[k], ++kept;
  }
  const auto n = static_cast<py::ssize_t>(kept);
  return measure(py::array_t<float>(n, lidar.data()), py::array_t<float>(n, image.data()))
      .cast<double>();
}

std::vector<double> evaluate(const ScenePairs& pairs, const py::object& given,
                             const py::object& wanted, const std::string& features, double sigma,
                             size_t max_points) {
  const bool own = py::isinstance<py::function>(wanted);
  const auto& measure = measure_of(own ? features : wanted.cast<std::string>());
  const std::vector<Eigen::Isometry3d> poses = to_poses(given);
  if (poses.empty()) throw py::value_error("poses: there are none");
  if (!(sigma >= 0 && sigma <= 100)) throw py::value_error("sigma: not in 0 ... 100 px");
  std::optional<py::gil_scoped_release> released(std::in_place);
  const auto scenes = value_or_raise(daemon::make_scenes(pairs, measure, poses[poses.size() / 2]));
  const auto cameras = daemon::rig_cameras(pairs);
  calibration::VisibilityOptions visibility;
  visibility.max_points = max_points;
  const auto points = calibration::select_visible(scenes, cameras, poses, visibility);
  if (points.size() == 0) throw Failure("no point is in view at all poses");
  const calibration::BlurredImages images(scenes, cameras, measure.terms,
                                          calibration::ImageBlur::in_angle(sigma));
  calibration::Objective objective(points, images, cameras, scenes, measure.terms);
  if (own) released.reset();
  std::vector<double> values;
  for (const Eigen::Isometry3d& pose : poses) {
    values.push_back(own ? call_measure(wanted, objective, pose)
                         : objective.evaluate(pose, false).estimate.value);
  }
  return values;
}

py::tuple project(const py::object& given, const CameraIntrinsics& intrinsics,
                  const py::object& T_camera_lidar) {
  const Points points(given, "points");
  const Eigen::Isometry3d pose = to_pose(T_camera_lidar, "T_camera_lidar");
  const size_t n = points.view().x.size();
  std::vector<float> u(n), v(n);
  py::array_t<float> pixels({static_cast<py::ssize_t>(n), py::ssize_t{2}});
  py::array_t<float> depth(static_cast<py::ssize_t>(n));
  float *at = pixels.mutable_data(), *depths = depth.mutable_data();
  {
    const py::gil_scoped_release release;
    geometry::project_points(geometry::CameraModel(intrinsics), pose, points.view(),
                             {u, v, {depths, n}});
    for (size_t k = 0; k < n; ++k) at[2 * k] = u[k], at[2 * k + 1] = v[k];
  }
  return py::make_tuple(pixels, depth);
}

void bind_pairs(py::module_& module) {
  py::class_<ScenePairs, std::shared_ptr<ScenePairs>>(
      module, "Pairs", "Images, each with the sweep nearest in time, deskewed to its exposure.")
      .def("__len__", [](const ScenePairs& pairs) { return pairs.pairs.size(); })
      .def_readonly("cameras", &ScenePairs::cameras, "the reference camera first")
      .def_readonly("lidar", &ScenePairs::lidar)
      .def_readonly("notes", &ScenePairs::notes, "what was left out, and why")
      .def_property_readonly(
          "initial",
          [](const ScenePairs& pairs) { return to_array(pairs.cameras.front().T_camera_lidar); },
          "(4, 4): T_refcam_lidar that the rig states")
      .def_property_readonly(
          "truth",
          [](const ScenePairs& pairs) -> py::object {
            if (!pairs.truth) return py::none();
            return to_array(*pairs.truth);
          },
          "(4, 4): T_refcam_lidar of a simulated drive; else None")
      .def(
          "sweep",
          [](const ScenePairs& pairs, size_t k) -> const Sweep& {
            if (k >= pairs.pairs.size()) throw py::index_error("there are fewer pairs");
            return pairs.pairs[k].sweep;
          },
          py::arg("index"), py::return_value_policy::reference_internal)
      .def(
          "image",
          [](const ScenePairs& pairs, size_t k) -> const CameraFrame& {
            if (k >= pairs.pairs.size()) throw py::index_error("there are fewer pairs");
            return pairs.pairs[k].frame;
          },
          py::arg("index"), py::return_value_policy::reference_internal)
      .def(
          "split",
          [](const ScenePairs& pairs) {
            ScenePairs kept = pairs;
            auto held_out = std::make_shared<ScenePairs>(daemon::hold_out(kept));
            return py::make_tuple(std::make_shared<ScenePairs>(std::move(kept)), held_out);
          },
          "Two Pairs, every second image of each camera in the other: to calibrate() with one and "
          "compare() on the other.");
}

void bind_outcomes(py::module_& module) {
  py::class_<CalibrationRun, std::shared_ptr<CalibrationRun>>(
      module, "CalibrationResult",
      "T_refcam_lidar, whether it may be used, and the evidence. covariance: (6, 6), (rx, ry, rz, "
      "tx, ty, tz), rad and m, of a left perturbation in the camera's frame.")
      .def_property_readonly(
          "T_camera_lidar",
          [](const CalibrationRun& run) { return to_array(run.result.T_refcam_lidar); })
      .def_property_readonly("covariance",
                             [](const CalibrationRun& run) {
                               return to_array(Eigen::MatrixXd(run.result.covariance()));
                             })
      .def_property_readonly("usable",
                             [](const CalibrationRun& run) { return run.result.usable(); })
      .def_property_readonly("reason", [](const CalibrationRun& run) { return run.result.reason; })
      .def_property_readonly("value", [](const CalibrationRun& run) { return run.result.value; })
      .def_property_readonly("initial_value",
                             [](const CalibrationRun& run) { return run.result.initial_value; })
      .def_property_readonly("points", [](const CalibrationRun& run) { return run.result.points; })
      .def_property_readonly(
          "support", [](const CalibrationRun& run) { return run.result.support; },
          "mean over the scenes of the share of wrong rotations that each refuses, 0 ... 1")
      .def_property_readonly(
          "effective_scenes",
          [](const CalibrationRun& run) { return run.result.uncertainty.effective_scenes; })
      .def_property_readonly("restarts",
                             [](const CalibrationRun& run) { return run.result.restarts; })
      .def_property_readonly("converged_restarts", [](const CalibrationRun& run) {
        return run.result.converged_restarts;
      });
  py::class_<ComparedExtrinsics, std::shared_ptr<ComparedExtrinsics>>(
      module, "Comparison", "Which of two extrinsics fits scenes better.")
      .def_property_readonly("better", &ComparedExtrinsics::better, "'new', 'old' or 'neither'")
      .def_property_readonly("p_value",
                             [](const ComparedExtrinsics& c) { return c.comparison.p_value; })
      .def_property_readonly("usable",
                             [](const ComparedExtrinsics& c) { return c.comparison.usable(); })
      .def_property_readonly("reason",
                             [](const ComparedExtrinsics& c) { return c.comparison.reason; })
      .def_property_readonly("independent_scenes",
                             [](const ComparedExtrinsics& c) { return c.comparison.independent; });
}

}  // namespace

void bind_calibration(py::module_& parent) {
  py::module_ module =
      parent.def_submodule("calibration", "Extrinsic calibration of cameras to a lidar.");
  bind_pairs(module);
  bind_outcomes(module);
  module.def(
      "measures", &all_measures,
      "(name, description) of every measure, the default first; the last, 'nmi' I(4.2), 'nmi-raw' "
      "and 'levinson-thrun' P(3.23), are for comparison, and no program offers them.");
  module.def("read_pairs", &read_pairs, py::arg("drives"), py::kw_only(),
             py::arg("cameras") = std::vector<std::string>{}, py::arg("lidar") = "",
             py::arg("max_scenes") = 20,
             "Reads Pairs of drives of one rig, as `infuse calibrate` does. cameras: names, the "
             "reference camera first; empty: the only one. Error: what cannot be read.");
  module.def(
      "each_pair", &each_pair, py::arg("drive"), py::arg("on_pair"), py::kw_only(),
      py::arg("camera") = "", py::arg("lidar") = "",
      "Calls on_pair(image, sweep, twist) for each image of a camera, in order of time, with "
      "the sweep nearest to it, deskewed to its exposure. twist: (6,), rad/s and m/s, of the "
      "lidar in its own frame; None: not known. What on_pair raises ends it.");
  module.def("make_pairs", &make_pairs, py::arg("sweeps"), py::arg("images"), py::arg("intrinsics"),
             "Pairs of your own: as many Sweeps, deskewed to the exposures and with ring and "
             "column, as Images of one camera.");
  module.def("calibrate", &calibrate, py::arg("pairs").none(false), py::arg("initial") = py::none(),
             py::kw_only(), py::arg("measure") = "joint", py::arg("within_deg") = 3.5,
             py::arg("seed") = 1, py::arg("splits") = 4, py::arg("check_intrinsics") = true,
             "Estimates T_refcam_lidar by maximising a measure of dependence, from an initial "
             "pose (4, 4), whose rotation is wrong by up to within_deg about each axis; None: the "
             "rig's. A CalibrationResult, as `infuse calibrate` has it.");
  module.def("compare", &compare, py::arg("pairs"), py::arg("T_old"), py::arg("T_new"),
             "Compares two poses on pairs from which neither was estimated: see Pairs.split().");
  module.def("evaluate", &evaluate, py::arg("pairs"), py::arg("poses"), py::kw_only(),
             py::arg("measure") = "joint", py::arg("features") = "mi", py::arg("sigma") = 2.0,
             py::arg("max_points") = 60'000,
             "A measure at poses T_refcam_lidar, (K, 4, 4), on the points in view at all of them, "
             "with images blurred by sigma px. A list of K numbers.\n\n"
             "measure: a name, or a function of (n,) lidar and (n,) image samples, float32, that "
             "returns a number: a measure of your own. features: the named measure whose first "
             "pair of features such a function compares.");
  module.def("project", &project, py::arg("points"), py::arg("intrinsics"),
             py::arg("T_camera_lidar"),
             "((N, 2) float32 pixels u, v, NaN where the camera model does not project; (N,) depth "
             "in m along the optical axis).");
}

}  // namespace infuse::python
