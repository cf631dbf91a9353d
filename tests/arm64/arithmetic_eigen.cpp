#include <Eigen/Dense>

#include "tests/arm64/arithmetic.hpp"

namespace infuse::arithmetic {
namespace {

constexpr int kMatrices = 200;  // of each size

template <class Matrix>
void keep(const Matrix& m, Results& out) {
  for (Eigen::Index c = 0; c < m.cols(); ++c) {
    for (Eigen::Index r = 0; r < m.rows(); ++r) out.values.push_back(static_cast<double>(m(r, c)));
  }
}

/// Sums over vectors of a fixed size.
template <class Scalar, int n>
void add_fixed_sums(const char* scalar, std::vector<Results>& all) {
  Results out{std::string("Eigen: sum, norm and dot of ") + std::to_string(n) + " " + scalar, {}};
  Numbers numbers(3);
  Eigen::Matrix<Scalar, n, 1> a, b;
  for (int i = 0; i < kMatrices; ++i) {
    numbers.fill(a);
    numbers.fill(b);
    for (const Scalar value : {a.sum(), a.norm(), a.dot(b)}) {
      out.values.push_back(static_cast<double>(value));
    }
  }
  all.push_back(std::move(out));
}

/// Products of a fixed size, and decompositions.
template <class Scalar, int n>
void add_fixed_matrices(const char* scalar, std::vector<Results>& all) {
  using Matrix = Eigen::Matrix<Scalar, n, n>;
  const std::string size = " of " + std::to_string(n) + " x " + std::to_string(n) + " " + scalar;
  Results product{"Eigen: product" + size, {}}, inverse{"Eigen: inverse, determinant" + size, {}};
  Results solve{"Eigen: LLT, LDLT" + size, {}}, eigen{"Eigen: SelfAdjointEigenSolver" + size, {}};
  Results svd{"Eigen: JacobiSVD" + size, {}};
  Numbers numbers(4);
  Matrix a, b;
  for (int i = 0; i < kMatrices; ++i) {
    numbers.fill(a);
    numbers.fill(b);
    keep(Matrix(a * b), product);
    keep(Matrix(a.transpose() * b), product);
    keep(Matrix(a.inverse()), inverse);
    inverse.values.push_back(static_cast<double>(a.determinant()));
    const Matrix normal = a.transpose() * a + Matrix::Identity();
    keep(Matrix(normal.llt().solve(b)), solve);
    keep(Matrix(normal.ldlt().solve(b)), solve);
    const Eigen::SelfAdjointEigenSolver<Matrix> of(normal);
    keep(of.eigenvectors(), eigen);
    keep(of.eigenvalues(), eigen);
    const Eigen::JacobiSVD<Matrix> values(a, Eigen::ComputeFullU | Eigen::ComputeFullV);
    keep(values.matrixU(), svd);
    keep(values.singularValues(), svd);
  }
  for (Results* results : {&product, &inverse, &solve, &eigen, &svd}) {
    all.push_back(std::move(*results));
  }
}

/// Products and decompositions of sizes that are known at run time.
template <class Scalar>
void add_dynamic_matrices(const char* scalar, std::vector<Results>& all) {
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  for (const int n : {3, 6, 12, 30, 100}) {
    const std::string size =
        " of dynamic " + std::to_string(n) + " x " + std::to_string(n) + " " + scalar;
    Results product{"Eigen: product" + size, {}}, vector{"Eigen: product with a vector" + size, {}};
    Results solve{"Eigen: LLT, LDLT" + size, {}}, eigen{"Eigen: SelfAdjointEigenSolver" + size, {}};
    Results sums{"Eigen: sum, norm and dot" + size, {}};
    Numbers numbers(5);
    for (int i = 0; i < (n > 30 ? 3 : 20); ++i) {
      Matrix a(n, n), b(n, n);
      numbers.fill(a);
      numbers.fill(b);
      keep(Matrix(a * b), product);
      keep(Matrix(a.transpose() * b), product);
      const Vector x = b.col(0);
      keep(Vector(a * x), vector);
      keep(Vector(a.transpose() * x), vector);
      for (const Scalar value : {x.sum(), a.norm(), x.dot(b.col(1))}) {
        sums.values.push_back(static_cast<double>(value));
      }
      const Matrix normal = a.transpose() * a + Matrix::Identity(n, n);
      keep(Vector(normal.llt().solve(x)), solve);
      keep(Vector(normal.ldlt().solve(x)), solve);
      const Eigen::SelfAdjointEigenSolver<Matrix> of(normal);
      keep(of.eigenvalues(), eigen);
    }
    for (Results* results : {&product, &vector, &solve, &eigen, &sums}) {
      all.push_back(std::move(*results));
    }
  }
}

template <class Scalar>
void add_geometry(const char* scalar, std::vector<Results>& all) {
  Results rotation{std::string("Eigen: Quaternion, AngleAxis of ") + scalar, {}};
  Results transform{std::string("Eigen: Isometry of ") + scalar, {}};
  Numbers numbers(6);
  using Vector = Eigen::Matrix<Scalar, 3, 1>;
  using Isometry = Eigen::Transform<Scalar, 3, Eigen::Isometry>;
  for (int i = 0; i < kMatrices; ++i) {
    Vector axis, other, point;
    for (Vector* vector : {&axis, &other, &point}) numbers.fill(*vector);
    const Eigen::AngleAxis<Scalar> turn(axis.norm(), axis.normalized());
    const Eigen::Quaternion<Scalar> a(turn),
        b(Eigen::AngleAxis<Scalar>(other.x(), other.normalized()));
    keep((a * b).coeffs(), rotation);
    keep((a * b).toRotationMatrix(), rotation);
    keep(Vector(a * point), rotation);
    keep(a.slerp(static_cast<Scalar>(0.3), b).coeffs(), rotation);
    Isometry T = Isometry::Identity(), U = T;
    T.linear() = a.toRotationMatrix();
    T.translation() = other;
    U.linear() = b.toRotationMatrix();
    U.translation() = axis;
    keep((T * U).matrix(), transform);
    keep(T.inverse().matrix(), transform);
    keep(Vector(T * point), transform);
  }
  all.push_back(std::move(rotation));
  all.push_back(std::move(transform));
}

}  // namespace

std::vector<Results> eigen_results() {
  std::vector<Results> all;
  add_fixed_sums<double, 3>("double", all);
  add_fixed_sums<double, 6>("double", all);
  add_fixed_sums<float, 3>("float", all);
  add_fixed_sums<float, 6>("float", all);
  add_fixed_sums<float, 8>("float", all);
  add_fixed_sums<float, 20>("float", all);
  add_fixed_matrices<double, 3>("double", all);
  add_fixed_matrices<double, 6>("double", all);
  add_dynamic_matrices<double>("double", all);
  add_dynamic_matrices<float>("float", all);
  add_geometry<double>("double", all);
  add_geometry<float>("float", all);
  return all;
}

}  // namespace infuse::arithmetic
