#include <pybind11/stl.h>

#include "fusion/features/sweep_view.hpp"
#include "fusion/places/visual/scan_words.hpp"
#include "fusion/registration/visual/learned_codebook.hpp"
#include "packaging/python/arrays.hpp"
#include "packaging/python/bindings.hpp"
#include "tests/study/dependence/distance_correlation.hpp"
#include "tests/study/dependence/estimators.hpp"

namespace infuse::python {
namespace {

py::list estimators() {
  py::list list;
  for (const study::Estimator& each : study::make_estimators()) {
    list.append(py::make_tuple(each.key, each.name, each.quantity));
  }
  return list;
}

/// Both sides of pairs, as many of each.
std::pair<Eigen::MatrixXd, Eigen::MatrixXd> sides(const py::object& x, const py::object& y) {
  std::pair<Eigen::MatrixXd, Eigen::MatrixXd> both{to_matrix(x, "x"), to_matrix(y, "y")};
  if (both.first.rows() != both.second.rows()) throw py::value_error("x, y: not as many of each");
  return both;
}

study::Estimate estimate(const std::string& key, const py::object& x, const py::object& y) {
  const auto all = study::make_estimators();
  const auto chosen =
      std::find_if(all.begin(), all.end(), [&](const auto& each) { return each.key == key; });
  if (chosen == all.end()) throw py::value_error("key: '" + key + "' is none of estimators()");
  const auto [a, b] = sides(x, y);
  if (a.cols() != 1 || b.cols() != 1) throw py::value_error("x, y: not of one dimension");
  if (a.rows() < 2) throw py::value_error("x, y: fewer than two pairs");
  study::SamplePairs pairs(2, a.rows());
  pairs << a.transpose(), b.transpose();
  pairs.colwise() -= pairs.rowwise().mean().eval();
  for (int side = 0; side < 2; ++side) {
    const double sigma = std::sqrt(pairs.row(side).squaredNorm() / static_cast<double>(a.rows()));
    if (sigma > 0) pairs.row(side) /= sigma;
  }
  const py::gil_scoped_release release;
  return chosen->estimate(pairs);
}

study::Estimate distance_correlation(const py::object& x, const py::object& y, bool corrected) {
  const auto [a, b] = sides(x, y);
  const py::gil_scoped_release release;
  return corrected ? study::corrected_distance_correlation(a, b)
                   : study::distance_correlation(a, b);
}

/// A scan as P 5.2.1 describes it, without images.
places::MapScan describe(const Sweep& sweep, const Eigen::Isometry3d& T_vehicle_lidar) {
  return places::MapScan(
      places::describe_scan({features::make_sweep_view(sweep), {}}, T_vehicle_lidar));
}

py::tuple place_information(const Sweep& place, const Sweep& query,
                            const py::object& T_vehicle_lidar, double yaw) {
  if (!std::isfinite(yaw)) throw py::value_error("yaw: not finite");
  const auto T = to_pose(T_vehicle_lidar, "T_vehicle_lidar");
  places::InformationAlignment found;
  {
    const py::gil_scoped_release release;
    const auto there = describe(place, T), here = describe(query, T);
    found = places::refine_by_information(
        there, here.words(), places::search_by_information(there, here.words(), yaw, false), false);
  }
  return py::make_tuple(found.information.total(false),
                        py::make_tuple(found.x, found.y, found.yaw));
}

py::tuple codebook() {
  const registration::Codebook& learned = registration::learned_codebook();
  return py::make_tuple(
      to_array(Eigen::MatrixXd(learned.words.transpose().cast<double>())),
      py::array_t<double>(static_cast<py::ssize_t>(learned.size()), learned.frequencies.data()));
}

py::array_t<uint32_t> quantise(const py::object& features, const py::object& words) {
  const Eigen::MatrixXd given = to_matrix(features, "features"), of = to_matrix(words, "words");
  if (given.cols() != of.cols()) throw py::value_error("features, words: not as many columns");
  if (given.rows() == 0 || of.rows() == 0) throw py::value_error("features, words: there are none");
  const registration::Codebook codebook{
      of.transpose().cast<float>(),
      std::vector<double>(static_cast<size_t>(of.rows()), 1 / static_cast<double>(of.rows()))};
  if (const auto wrong = codebook.invalid()) throw py::value_error("words: " + *wrong);
  std::vector<uint32_t> found;
  {
    const py::gil_scoped_release release;
    found = registration::quantise(codebook, given.transpose().cast<float>());
  }
  return py::array_t<uint32_t>(static_cast<py::ssize_t>(found.size()), found.data());
}

}  // namespace

void bind_study(py::module_& parent) {
  py::module_ module = parent.def_submodule(
      "study", "What the methods of the library are compared with; no program uses it.");
  module.def("estimators", &estimators,
             "(key, name, quantity) of every estimator of dependence of P 2.4 and I 2.");
  module.def("estimate", &estimate, py::arg("key"), py::arg("x"), py::arg("y"),
             "An Estimate by one of estimators(). x, y: (N,), each scaled to zero mean and unit "
             "variance.");
  module.def("distance_correlation", &distance_correlation, py::arg("x"), py::arg("y"),
             py::kw_only(), py::arg("corrected") = false,
             "Distance correlation, I 2.3.3, 0 ... 1, an Estimate. x, y: (N,) or (N, d). "
             "corrected: bias-corrected and squared, for four samples and more.");
  module.def("place_information", &place_information, py::arg("place"), py::arg("query"),
             py::kw_only(), py::arg("T_vehicle_lidar") = py::none(), py::arg("yaw") = 0.0,
             "(information, (x, y, yaw)): the total mutual information P(5.6) of two Sweeps, nats, "
             "of reflectivity and normals, and the pose of the query as seen from the place, m and "
             "rad, where it is largest: within 4 m ahead and 6 m aside, at the heading yaw or its "
             "opposite.");
  module.def(
      "codebook", &codebook,
      "(words, frequencies), (K, d) and (K,): the learned codebook of FPFH and SIFT, P 4.3.1.");
  module.def("quantise", &quantise, py::arg("features"), py::arg("words"),
             "(N,) uint32: the nearest of the words, (K, d), of each of the features, (N, d).");
}

}  // namespace infuse::python
