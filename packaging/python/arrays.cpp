#include "packaging/python/arrays.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "drivers/recording/rigid_matrix.hpp"
#include "fusion/motion/deskew.hpp"

namespace infuse::python {
namespace {

template <class T>
using Contiguous = py::array_t<T, py::array::c_style | py::array::forcecast>;

std::string shape_text(const py::array& array) {
  std::string text = "(";
  for (py::ssize_t k = 0; k < array.ndim(); ++k) {
    text += (k == 0 ? "" : ", ") + std::to_string(array.shape(k));
  }
  return text + (array.ndim() == 1 ? ",)" : ")");
}

[[noreturn]] void wrong_shape(const char* name, const char* wanted, const py::array& array) {
  throw py::value_error(std::string(name) + ": the shape is " + shape_text(array) + ", not " +
                        wanted);
}

void require_finite(const double* values, py::ssize_t rows, py::ssize_t columns, const char* name) {
  for (py::ssize_t k = 0; k < rows * columns; ++k) {
    if (!std::isfinite(values[k])) {
      throw py::value_error(std::string(name) + ": row " + std::to_string(k / columns) +
                            " is not finite");
    }
  }
}

}  // namespace

py::array numbers(const py::handle& argument, const char* name) {
  py::array array = py::array::ensure(argument);
  if (!array) {
    PyErr_Clear();
    throw py::type_error(std::string(name) + ": not an array of numbers");
  }
  const char kind = array.dtype().kind();
  if (kind != 'f' && kind != 'i' && kind != 'u' && kind != 'b') {
    throw py::type_error(std::string(name) + ": not an array of numbers, but of " +
                         py::str(array.dtype()).cast<std::string>());
  }
  return array;
}

template <class T>
std::vector<T> to_vector(const py::handle& argument, const char* name, bool allow_infinite) {
  const py::array given = numbers(argument, name);
  if (given.ndim() != 1) wrong_shape(name, "(N,)", given);
  if (std::is_integral_v<T> && given.dtype().kind() == 'f') {
    throw py::type_error(std::string(name) + ": not whole numbers");
  }
  const auto wide = Contiguous<double>::ensure(given);
  if (!std::is_integral_v<T> && !allow_infinite) require_finite(wide.data(), wide.size(), 1, name);
  if constexpr (std::is_integral_v<T>) {
    const auto whole = Contiguous<int64_t>::ensure(given);
    for (py::ssize_t k = 0; k < whole.size(); ++k) {
      if (!std::in_range<T>(whole.data()[k])) {
        throw py::value_error(std::string(name) + ": " + std::to_string(whole.data()[k]) +
                              " is out of range");
      }
    }
  }
  const auto converted = Contiguous<T>::ensure(given);
  return {converted.data(), converted.data() + converted.size()};
}
template std::vector<float> to_vector(const py::handle&, const char*, bool);
template std::vector<double> to_vector(const py::handle&, const char*, bool);
template std::vector<int32_t> to_vector(const py::handle&, const char*, bool);
template std::vector<int64_t> to_vector(const py::handle&, const char*, bool);
template std::vector<uint16_t> to_vector(const py::handle&, const char*, bool);

Points::Points(const py::handle& argument, const char* name) {
  if (py::isinstance<Sweep>(argument)) {
    const auto& sweep = argument.cast<const Sweep&>();
    owner_ = py::reinterpret_borrow<py::object>(argument);
    view_ = {sweep.x, sweep.y, sweep.z};
  } else if (py::isinstance<motion::DeskewedSweep>(argument)) {
    const auto& sweep = argument.cast<const motion::DeskewedSweep&>();
    owner_ = py::reinterpret_borrow<py::object>(argument);
    view_ = {sweep.x, sweep.y, sweep.z};
  } else {
    const py::array given = numbers(argument, name);
    if (given.ndim() != 2 || (given.shape(1) != 3 && given.shape(1) != 4)) {
      wrong_shape(name, "(N, 3) or (N, 4)", given);
    }
    const auto rows = Contiguous<float>::ensure(given);
    const auto n = static_cast<size_t>(rows.shape(0));
    const auto columns = static_cast<size_t>(rows.shape(1));
    for (auto* field : {&x_, &y_, &z_}) field->resize(n);
    const float* at = rows.data();
    for (size_t k = 0; k < n; ++k, at += columns) {
      x_[k] = at[0], y_[k] = at[1], z_[k] = at[2];
    }
    view_ = {x_, y_, z_};
  }
  if (view_.x.empty()) throw py::value_error(std::string(name) + ": there are no points");
  for (size_t k = 0; k < view_.x.size(); ++k) {
    if (!std::isfinite(view_.x[k]) || !std::isfinite(view_.y[k]) || !std::isfinite(view_.z[k])) {
      throw py::value_error(std::string(name) + ": row " + std::to_string(k) + " is not finite");
    }
  }
}

Eigen::Isometry3d to_pose(const py::handle& argument, const char* name) {
  if (argument.is_none()) return Eigen::Isometry3d::Identity();
  const py::array given = numbers(argument, name);
  if (given.ndim() != 2 || given.shape(0) != 4 || given.shape(1) != 4) {
    wrong_shape(name, "(4, 4)", given);
  }
  const auto rows = Contiguous<double>::ensure(given);
  const auto pose = recording::to_rigid(std::span<const double>(rows.data(), 16));
  if (!pose) throw py::value_error(std::string(name) + ": not a rigid motion");
  return *pose;
}

std::vector<Eigen::Isometry3d> to_poses(const py::handle& argument) {
  const py::array given = numbers(argument, "poses");
  if (given.ndim() != 3 || given.shape(1) != 4 || given.shape(2) != 4) {
    throw py::value_error("poses: the shape is not (N, 4, 4)");
  }
  std::vector<Eigen::Isometry3d> out;
  for (py::ssize_t k = 0; k < given.shape(0); ++k) {
    out.push_back(to_pose(given[py::int_(k)], "poses"));
  }
  return out;
}

Eigen::MatrixXd to_matrix(const py::handle& argument, const char* name) {
  const py::array given = numbers(argument, name);
  if (given.ndim() != 1 && given.ndim() != 2) wrong_shape(name, "(N,) or (N, d)", given);
  const auto rows = Contiguous<double>::ensure(given);
  const py::ssize_t columns = rows.ndim() == 1 ? 1 : rows.shape(1);
  if (rows.size() == 0) throw py::value_error(std::string(name) + ": there are no samples");
  require_finite(rows.data(), rows.shape(0), columns, name);
  return Eigen::Map<const Eigen::Matrix<double, -1, -1, Eigen::RowMajor>>(rows.data(),
                                                                          rows.shape(0), columns);
}

template <int n>
Eigen::Matrix<double, n, 1> to_fixed(const py::handle& argument, const char* name) {
  const std::vector<double> values = to_vector<double>(argument, name);
  if (values.size() != n) {
    throw py::value_error(std::string(name) + ": " + std::to_string(values.size()) +
                          " numbers, not " + std::to_string(n));
  }
  return Eigen::Map<const Eigen::Matrix<double, n, 1>>(values.data());
}
template Eigen::Matrix<double, 2, 1> to_fixed<2>(const py::handle&, const char*);
template Eigen::Matrix<double, 3, 1> to_fixed<3>(const py::handle&, const char*);
template Eigen::Matrix<double, 6, 1> to_fixed<6>(const py::handle&, const char*);

template <int n>
Eigen::Matrix<double, n, n> to_covariance(const py::handle& argument, const char* name) {
  const Eigen::MatrixXd matrix = to_matrix(argument, name);
  if (matrix.rows() != n || matrix.cols() != n) {
    throw py::value_error(std::string(name) + ": not " + std::to_string(n) + " by " +
                          std::to_string(n));
  }
  const double rounding = 1e-9 * matrix.norm();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solved(matrix, Eigen::EigenvaluesOnly);
  if (!((matrix - matrix.transpose()).norm() <= rounding) ||
      !(solved.eigenvalues().minCoeff() >= -rounding)) {
    throw py::value_error(std::string(name) + ": no covariance");
  }
  return matrix;
}
template Eigen::Matrix<double, 3, 3> to_covariance<3>(const py::handle&, const char*);

py::array_t<double> to_array(const Eigen::MatrixXd& matrix) {
  py::array_t<double> array({matrix.rows(), matrix.cols()});
  Eigen::Map<Eigen::Matrix<double, -1, -1, Eigen::RowMajor>>(array.mutable_data(), matrix.rows(),
                                                             matrix.cols()) = matrix;
  return array;
}

py::array_t<double> to_array(const Eigen::Isometry3d& pose) {
  return to_array(Eigen::MatrixXd(pose.matrix()));
}

py::array_t<float> to_array(const geometry::PointsView& points) {
  py::array_t<float> array({static_cast<py::ssize_t>(points.x.size()), py::ssize_t{3}});
  float* at = array.mutable_data();
  for (size_t k = 0; k < points.x.size(); ++k) {
    *at++ = points.x[k], *at++ = points.y[k], *at++ = points.z[k];
  }
  return array;
}

}  // namespace infuse::python
