#include <pybind11/stl.h>

#include "fusion/dependence/bagged_lsmi.hpp"
#include "fusion/dependence/count_entropy.hpp"
#include "fusion/dependence/directed_information.hpp"
#include "fusion/dependence/histogram_measures.hpp"
#include "fusion/dependence/prepared_dependence.hpp"
#include "fusion/dependence/prepared_histogram.hpp"
#include "fusion/dependence/shrunk_information.hpp"
#include "packaging/python/arrays.hpp"
#include "packaging/python/bindings.hpp"

namespace infuse::python {
namespace {

namespace dep = dependence;

template <class Value>
Value named(const std::string& name, const char* argument,
            const std::vector<std::pair<const char*, Value>>& known) {
  std::string names;
  for (const auto& [text, value] : known) {
    if (name == text) return value;
    names += (names.empty() ? "" : ", ") + std::string(text);
  }
  throw py::value_error(std::string(argument) + ": '" + name + "' is none of " + names);
}

dep::Measure to_measure(const std::string& name) {
  std::vector<std::pair<const char*, dep::Measure>> known;
  for (const auto& [text, measure] : dep::kMeasureNames) known.emplace_back(text, measure);
  return named<dep::Measure>(name, "measure", known);
}

dep::JointHistogramOptions histogram_options(int bins, std::pair<double, double> x_range,
                                             std::pair<double, double> y_range,
                                             const std::string& window) {
  dep::JointHistogramOptions options;
  options.x = {bins, x_range.first, x_range.second};
  options.y = {bins, y_range.first, y_range.second};
  options.window = named<dep::Window>(window, "window",
                                      {{"none", dep::Window::kNone},
                                       {"gaussian", dep::Window::kGaussian},
                                       {"spline", dep::Window::kBSpline}});
  return require_valid(options);
}

/// A histogram whose x side is given once.
class Histogram {
 public:
  Histogram(const py::object& x, int bins, std::pair<double, double> x_range,
            std::pair<double, double> y_range, const std::string& window, const py::object& weights)
      : options_(histogram_options(bins, x_range, y_range, window)), histogram_({}, options_) {
    const auto fixed = to_vector<float>(x, "x");
    std::vector<float> each;
    if (!weights.is_none()) each = to_vector<float>(weights, "weights");
    if (fixed.empty()) throw py::value_error("x: there are no samples");
    if (!each.empty() && each.size() != fixed.size()) {
      throw py::value_error("weights: not as many as samples");
    }
    if (std::any_of(each.begin(), each.end(), [](float weight) { return weight < 0; })) {
      throw py::value_error("weights: negative");
    }
    histogram_ = dep::PreparedHistogram(fixed, options_, each);
  }

  dep::Estimate value(const py::object& y, const std::string& measure) {
    const dep::Measure which = to_measure(measure);
    const auto moving = samples(y);
    const Work work(busy_);
    return histogram_.value(which, moving);
  }

  py::tuple value_and_gradient(const py::object& y, const std::string& measure) {
    const dep::Measure which = to_measure(measure);
    if (options_.window != dep::Window::kBSpline) {
      throw py::value_error("window: only 'spline' has a gradient");
    }
    const auto moving = samples(y);
    py::array_t<float> gradient(static_cast<py::ssize_t>(moving.size()));
    const std::span<float> out(gradient.mutable_data(), moving.size());
    dep::Estimate estimate;
    {
      const Work work(busy_);
      estimate = histogram_.value_and_gradient(which, moving, out);
    }
    return py::make_tuple(estimate, gradient);
  }

  py::array_t<double> table(const py::object& y) {
    const auto moving = samples(y);
    const dep::JointHistogram* table = nullptr;
    {
      const Work work(busy_);
      table = &histogram_.histogram(moving);
    }
    if (!table->usable()) throw Failure(table->reason);
    return py::array_t<double>({py::ssize_t{table->bins_x}, py::ssize_t{table->bins_y}},
                               table->mass.data());
  }

 private:
  /// Samples of y; +inf: left out.
  std::vector<float> samples(const py::object& y) const {
    auto moving = to_vector<float>(y, "y", true);
    if (moving.size() != histogram_.sample_count()) {
      throw py::value_error("y: " + std::to_string(moving.size()) + " samples for " +
                            std::to_string(histogram_.sample_count()) + " of x");
    }
    for (const float value : moving) {
      if (!(value > -std::numeric_limits<float>::infinity())) {
        throw py::value_error("y: a sample is NaN or -inf");
      }
    }
    return moving;
  }

  dep::JointHistogramOptions options_;
  dep::PreparedHistogram histogram_;
  bool busy_ = false;
};

dep::Estimate histogram_measure(const py::object& x, const py::object& y,
                                const std::string& measure, int bins,
                                std::pair<double, double> x_range,
                                std::pair<double, double> y_range, const std::string& window,
                                const py::object& weights) {
  return Histogram(x, bins, x_range, y_range, window, weights).value(y, measure);
}

dep::FitOptions fit_options(int centres, const std::vector<double>& sigmas,
                            const std::vector<double>& lambdas, int folds, uint64_t seed,
                            const std::string& form) {
  dep::FitOptions options;
  options.centres = centres;
  options.folds = folds;
  options.seed = seed;
  options.form = named<dep::SmiForm>(
      form, "form", {{"linear", dep::SmiForm::kLinear}, {"plug-in", dep::SmiForm::kPlugIn}});
  if (!sigmas.empty()) options.sigmas = sigmas;
  if (!lambdas.empty()) options.lambdas = lambdas;
  return require_valid(options);
}

/// LSMI, LSQMI or LSCE with one side prepared.
class LeastSquares {
 public:
  LeastSquares(const py::object& x, const std::string& measure, int centres,
               const std::vector<double>& sigmas, const std::vector<double>& lambdas, int folds,
               uint64_t seed, const std::string& form)
      : samples_(to_matrix(x, "x")),
        measure_(named<dep::FitMeasure>(measure, "measure",
                                        {{"smi", dep::FitMeasure::kSmi},
                                         {"qmi", dep::FitMeasure::kQmi},
                                         {"sce", dep::FitMeasure::kSce}})) {
    const auto options = fit_options(centres, sigmas, lambdas, folds, seed, form);
    const py::gil_scoped_release release;
    fit_ = std::make_unique<dep::PreparedDependence>(measure_, samples_, options);
  }

  dep::FitEstimate evaluate(const py::object& y) {
    const Eigen::MatrixXd moving = samples(y);
    const Work work(busy_);
    return fit_->evaluate(moving);
  }

  dep::FitEstimate evaluate_labels(const py::object& labels) {
    const auto moving = to_vector<int32_t>(labels, "labels");
    if (static_cast<Eigen::Index>(moving.size()) != samples_.rows()) {
      throw py::value_error("labels: not as many as samples of x");
    }
    const auto [low, high] = std::minmax_element(moving.begin(), moving.end());
    // Memory grows with the largest label.
    if (*low < 0 || static_cast<size_t>(*high) >= std::max<size_t>(moving.size(), 1024)) {
      throw py::value_error("labels: negative, or larger than the number of samples");
    }
    const int count = *high + 1;
    const Work work(busy_);
    return fit_->evaluate(moving, count);
  }

  py::tuple value_and_gradient(const py::object& y) {
    if (measure_ != dep::FitMeasure::kSmi) throw py::value_error("only 'smi' has a gradient");
    const Eigen::MatrixXd moving = samples(y);
    Eigen::MatrixXd gradient;
    dep::FitEstimate estimate;
    {
      const Work work(busy_);
      estimate = fit_->evaluate(moving, {}, &gradient);
    }
    return py::make_tuple(estimate, to_array(gradient));
  }

 private:
  Eigen::MatrixXd samples(const py::object& y) const {
    Eigen::MatrixXd moving = to_matrix(y, "y");
    if (moving.rows() != samples_.rows()) {
      throw py::value_error("y: " + std::to_string(moving.rows()) + " samples for " +
                            std::to_string(samples_.rows()) + " of x");
    }
    return moving;
  }

  Eigen::MatrixXd samples_;
  dep::FitMeasure measure_;
  std::unique_ptr<dep::PreparedDependence> fit_;
  bool busy_ = false;
};

/// BLSMI with one side prepared.
class Bagged {
 public:
  Bagged(const py::object& x, int bags, int bag_size, int centres, uint64_t seed)
      : samples_(to_matrix(x, "x")) {
    dep::BagOptions options{.bags = bags, .bag_size = bag_size, .fit = {}};
    options.fit.centres = centres;
    options.fit.seed = seed;
    require_valid(options);
    if (samples_.rows() < bag_size) throw py::value_error("x: fewer samples than bag_size");
    // Each bag keeps its centres' eigenvectors.
    if (int64_t{bags} * centres * centres > int64_t{250'000'000}) {
      throw py::value_error("bags x centres x centres: more than 2 GB");
    }
    const py::gil_scoped_release release;
    fit_ = std::make_unique<dep::BaggedLsmi>(samples_, options);
  }

  py::tuple value_and_gradient(const py::object& y) {
    const Eigen::MatrixXd moving = to_matrix(y, "y");
    if (moving.rows() != samples_.rows()) {
      throw py::value_error("y: not as many samples as x");
    }
    Eigen::MatrixXd gradient;
    dep::FitEstimate estimate;
    {
      const Work work(busy_);
      estimate = fit_->evaluate(moving, &gradient);
    }
    return py::make_tuple(estimate, to_array(gradient));
  }

  dep::FitEstimate evaluate(const py::object& y) {
    const Eigen::MatrixXd moving = to_matrix(y, "y");
    if (moving.rows() != samples_.rows()) {
      throw py::value_error("y: not as many samples as x");
    }
    const Work work(busy_);
    return fit_->evaluate(moving);
  }

 private:
  Eigen::MatrixXd samples_;
  std::unique_ptr<dep::BaggedLsmi> fit_;
  bool busy_ = false;
};

double shrunk_information(const py::object& x, const py::object& y, const py::object& target,
                          const std::optional<double>& shrinkage) {
  const auto a = to_vector<int32_t>(x, "x"), b = to_vector<int32_t>(y, "y");
  std::vector<double> frequencies = to_vector<double>(target, "target");
  if (a.size() != b.size()) throw py::value_error("x, y: not as many of each");
  double sum = 0;
  for (const double frequency : frequencies) {
    if (!(frequency > 0)) throw py::value_error("target: a frequency that is not positive");
    sum += frequency;
  }
  if (!(std::abs(sum - 1) < 1e-6)) throw py::value_error("target: the sum is not 1");
  if (frequencies.size() > 4096) throw py::value_error("target: more than 4096 labels");
  if (shrinkage && !(*shrinkage >= 0 && *shrinkage <= 1)) {
    throw py::value_error("shrinkage: not in 0 ... 1");
  }
  const auto labels = static_cast<int32_t>(frequencies.size());
  dep::ShrunkInformation information(std::move(frequencies));
  for (size_t k = 0; k < a.size(); ++k) {
    if (a[k] < 0 || b[k] < 0 || a[k] >= labels || b[k] >= labels) {
      throw py::value_error("x, y: a label without a frequency");
    }
    information.add(static_cast<uint32_t>(a[k]), static_cast<uint32_t>(b[k]));
  }
  return information.value(shrinkage.value_or(information.optimal_shrinkage()));
}

using CountEstimator = dep::CountEntropyOptions::Estimator;

CountEstimator to_count_estimator(const std::string& name) {
  return named<CountEstimator>(name, "estimator",
                               {{"maximum-likelihood", CountEstimator::kMaximumLikelihood},
                                {"miller-madow", CountEstimator::kMillerMadow},
                                {"james-stein", CountEstimator::kJamesStein},
                                {"chao-shen", CountEstimator::kChaoShen}});
}

dep::Estimate entropy(const py::object& counts, const std::string& estimator) {
  const auto given = to_vector<double>(counts, "counts");
  if (const char* wrong = dep::check_counts(given); *wrong != '\0') {
    throw py::value_error("counts: " + std::string(wrong));
  }
  return dep::entropy(given, {.estimator = to_count_estimator(estimator), .shrinkage = {}});
}

dep::Estimate directed_information(const py::object& x, const py::object& y, int memory,
                                   const std::string& estimator, bool delayed) {
  const auto which = to_count_estimator(estimator);
  if (which == CountEstimator::kJamesStein) {
    throw py::value_error("estimator: 'james-stein' needs a vocabulary");
  }
  const auto a = to_vector<int32_t>(x, "x"), b = to_vector<int32_t>(y, "y");
  if (a.size() != b.size()) throw py::value_error("x, y: not as many of each");
  if (memory < 0 || memory > 16) throw py::value_error("memory: not in 0 ... 16");
  const py::gil_scoped_release release;
  return dep::directed_information_rate(a, b, memory, which, delayed);
}

void bind_estimates(py::module_& module) {
  py::class_<dep::Estimate>(module, "Estimate",
                            "Value of an estimator, finite, and the reason where it is unusable. "
                            "float(estimate) is the value.")
      .def_readonly("value", &dep::Estimate::value)
      .def_property_readonly("usable", &dep::Estimate::usable)
      .def_property_readonly("reason", [](const dep::Estimate& e) { return std::string(e.reason); })
      .def("__float__", [](const dep::Estimate& e) { return e.value; })
      .def("__repr__", [](const dep::Estimate& e) {
        return "<infuse Estimate " + std::to_string(e.value) +
               (e.usable() ? "" : ", unusable: " + std::string(e.reason)) + ">";
      });
  py::class_<dep::FitEstimate, dep::Estimate>(
      module, "FitEstimate",
      "Estimate with the kernel's width sigma, in the unit of "
      "the samples, and the ridge lambda_ of its fit.")
      .def_property_readonly("sigma",
                             [](const dep::FitEstimate& e) { return e.hyper_parameters.sigma; })
      .def_property_readonly("lambda_",
                             [](const dep::FitEstimate& e) { return e.hyper_parameters.lambda; });
}

}  // namespace

void bind_dependence(py::module_& parent) {
  py::module_ module = parent.def_submodule(
      "dependence", "Statistical dependence between two sets of samples; natural logarithms.");
  bind_estimates(module);
  constexpr std::pair<double, double> kUnit{0, 1};
  const dep::FitOptions fit;
  const dep::BagOptions bag;
  module.def("histogram_measure", &histogram_measure, py::arg("x"), py::arg("y"), py::kw_only(),
             py::arg("measure") = "mi", py::arg("bins") = 32, py::arg("x_range") = kUnit,
             py::arg("y_range") = kUnit, py::arg("window") = "spline",
             py::arg("weights") = py::none(),
             "A measure of the joint histogram of pairs of scalars: Histogram(x, ...).value(y).");
  py::class_<Histogram>(module, "Histogram",
                        "Joint histogram whose x side is binned once and compared with many y.\n\n"
                        "x: (N,), finite. bins: of each axis. Values outside a range count as its "
                        "nearer end. window: 'spline' (cubic B-spline), 'gaussian' (Silverman, "
                        "P(3.15)), 'none'. weights: (N,), not negative.")
      .def(py::init<const py::object&, int, std::pair<double, double>, std::pair<double, double>,
                    const std::string&, const py::object&>(),
           py::arg("x"), py::kw_only(), py::arg("bins") = 32, py::arg("x_range") = kUnit,
           py::arg("y_range") = kUnit, py::arg("window") = "spline",
           py::arg("weights") = py::none())
      .def("value", &Histogram::value, py::arg("y"), py::arg("measure") = "mi",
           "y: (N,); +inf leaves a sample out. measure: 'mi' P(2.13), 'nmi' I(4.2), 'chi2' "
           "P(3.25), 'smi' I(4.3). Returns an Estimate, nats for 'mi'.")
      .def("value_and_gradient", &Histogram::value_and_gradient, py::arg("y"),
           py::arg("measure") = "mi",
           "The same with its derivative by every y, (N,) float32; only for window 'spline'.")
      .def("table", &Histogram::table, py::arg("y"),
           "(bins, bins) float64: the masses, x by row. Error: there is no histogram.");
  py::class_<LeastSquares>(module, "LeastSquares",
                           "SMI by LSMI I(2.7-2.8), QMI by LSQMI or conditional entropy by LSCE, "
                           "with x prepared once.\n\n"
                           "x: (N,) or (N, d), finite. measure: 'smi', 'qmi', 'sce'. sigmas, "
                           "lambdas: the grid of the cross-validation; the default suits unit "
                           "variance. form: 'linear' or 'plug-in'.")
      .def(py::init<const py::object&, const std::string&, int, const std::vector<double>&,
                    const std::vector<double>&, int, uint64_t, const std::string&>(),
           py::arg("x"), py::kw_only(), py::arg("measure") = "smi",
           py::arg("centres") = fit.centres, py::arg("sigmas") = fit.sigmas,
           py::arg("lambdas") = fit.lambdas, py::arg("folds") = fit.folds,
           py::arg("seed") = fit.seed, py::arg("form") = "linear")
      .def("evaluate", &LeastSquares::evaluate, py::arg("y"), "y: (N,) or (N, d').")
      .def("evaluate_labels", &LeastSquares::evaluate_labels, py::arg("labels"),
           "labels: (N,) whole numbers from 0.")
      .def("value_and_gradient", &LeastSquares::value_and_gradient, py::arg("y"),
           "The same with its derivative by y, (N, d'), at fixed sigma and lambda; (0, 0) where "
           "the estimate is unusable.");
  py::class_<Bagged>(module, "BaggedLsmi",
                     "BLSMI I(2.9): the mean of LSMI over bags of the samples, a smooth function "
                     "of y for one seed. The first evaluation chooses sigma and lambda.")
      .def(py::init<const py::object&, int, int, int, uint64_t>(), py::arg("x"), py::kw_only(),
           py::arg("bags") = bag.bags, py::arg("bag_size") = bag.bag_size,
           py::arg("centres") = bag.fit.centres, py::arg("seed") = bag.fit.seed)
      .def("evaluate", &Bagged::evaluate, py::arg("y"))
      .def("value_and_gradient", &Bagged::value_and_gradient, py::arg("y"));
  module.def("entropy", &entropy, py::arg("counts"), py::arg("estimator") = "maximum-likelihood",
             "Entropy, nats, of a discrete variable, an Estimate. counts: (K,) one of every word. "
             "estimator: 'maximum-likelihood', 'miller-madow', 'james-stein' P(4.8), 'chao-shen' "
             "P(5.4).");
  module.def("directed_information", &directed_information, py::arg("x"), py::arg("y"),
             py::kw_only(), py::arg("memory") = 1, py::arg("estimator") = "chao-shen",
             py::arg("delayed") = false,
             "Directed information rate from x to y, P(6.1), nats a step, an Estimate. x, y: (N,) "
             "labels, whole numbers. memory: labels of the past that are conditioned on, 0 ... 16; "
             "0: mutual information. delayed: without the present of x.");
  module.def("shrunk_information", &shrunk_information, py::arg("x"), py::arg("y"),
             py::arg("target"), py::arg("shrinkage") = py::none(),
             "Mutual information (nats) of few pairs of labels, James-Stein P(4.8). target: "
             "frequency of each label, sum 1. shrinkage: 0 ... 1; None: the optimal one, P(4.10).");
}

}  // namespace infuse::python
