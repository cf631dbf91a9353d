#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <Eigen/Geometry>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "drivers/measurement/error.hpp"
#include "drivers/measurement/sweep.hpp"
#include "fusion/geometry/project_points.hpp"

namespace infuse::python {

namespace py = pybind11;

/// An error of the library, as Python raises it: `infuse.Error`, with the same sentence.
struct Failure : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Raises an exception while another thread works on an object.
inline void require_idle(bool busy) {
  if (busy) throw std::runtime_error("another thread is using this object");
}

/// Work on an object without the interpreter's lock. Another thread that comes to the object
/// meanwhile gets an exception.
class Work {
 public:
  explicit Work(bool& busy) : busy_(busy) {
    require_idle(busy);
    busy = true;
    released_.emplace();
  }
  Work(const Work&) = delete;
  Work& operator=(const Work&) = delete;
  ~Work() {
    released_.reset();
    busy_ = false;
  }

 private:
  bool& busy_;
  std::optional<py::gil_scoped_release> released_;
};

/// The value, or the error as an exception.
template <class T>
T value_or_raise(Result<T>&& result) {
  if (!result) throw Failure(result.error().message());
  if constexpr (!std::is_void_v<T>) return std::move(*result);
}

/// Raises ValueError if settings are invalid.
template <class Options>
const Options& require_valid(const Options& options) {
  if (const auto wrong = options.invalid()) throw py::value_error(*wrong);
  return options;
}

/// Array of numbers that NumPy converts, or TypeError: floats of any width and whole numbers, but
/// no text, no objects, no complex numbers. `name` is the argument's.
py::array numbers(const py::handle& argument, const char* name);

/// Finite values as a flat vector; ValueError states the first that is not. One dimension.
template <class T>
std::vector<T> to_vector(const py::handle& argument, const char* name, bool allow_infinite = false);

/// N × 3 or N × 4 coordinates, m, as a structure of arrays. Of four columns the last is left out.
/// ValueError: another shape, no rows, a coordinate that is not finite.
class Points {
 public:
  /// `argument`: an array, a `Sweep` or a `DeskewedSweep`, whose arrays are used in place.
  Points(const py::handle& argument, const char* name);

  const geometry::PointsView& view() const { return view_; }

 private:
  FieldVector<float> x_, y_, z_;
  py::object owner_;
  geometry::PointsView view_;
};

/// 4 × 4 rigid motion; None is the identity. ValueError: another shape, not rigid.
Eigen::Isometry3d to_pose(const py::handle& argument, const char* name);

/// N × 4 × 4 rigid motions, the argument `poses`.
std::vector<Eigen::Isometry3d> to_poses(const py::handle& argument);

/// N × d matrix of finite numbers, a row for each sample; a vector is one column.
Eigen::MatrixXd to_matrix(const py::handle& argument, const char* name);

/// N × N symmetric matrix without negative eigenvalues: a covariance. ValueError: another.
template <int n>
Eigen::Matrix<double, n, n> to_covariance(const py::handle& argument, const char* name);

/// Vector of n finite numbers.
template <int n>
Eigen::Matrix<double, n, 1> to_fixed(const py::handle& argument, const char* name);

/// 4 × 4 matrix.
py::array_t<double> to_array(const Eigen::Isometry3d& pose);
py::array_t<double> to_array(const Eigen::MatrixXd& matrix);

/// View of memory that `owner` keeps, not writable.
template <class T>
py::array_t<T> view_of(const T* data, std::vector<py::ssize_t> shape, const py::handle& owner) {
  py::array_t<T> array(std::move(shape), data, owner);
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

/// The same of one quantity of a sweep.
template <class T>
py::array_t<T> view_of(const FieldVector<T>& field, const py::handle& owner) {
  return view_of(field.data(), {static_cast<py::ssize_t>(field.size())}, owner);
}

/// N × 3 copy of coordinates.
py::array_t<float> to_array(const geometry::PointsView& points);

}  // namespace infuse::python
