// Arithmetic that libraries do, with random arguments, as bits: what differs between two
// processors, by function.
//
//   infuse-arithmetic FILE           writes the results of every function
//   infuse-arithmetic FILE FILE      compares two such files, and prints a table
#include <Eigen/Dense>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

namespace {

constexpr size_t kArguments = 100'000;  // of each scalar function
constexpr int kMatrices = 200;          // of each size

struct Results {
  std::string name;
  std::vector<double> values;  // floats too: no bit is lost
};

/// Random numbers made of integers alone (splitmix64): the same everywhere.
class Numbers {
 public:
  explicit Numbers(uint64_t seed) : state_(seed) {}

  double uniform(double low, double high) {
    state_ += 0x9E3779B97F4A7C15;
    uint64_t z = (state_ ^ (state_ >> 30)) * 0xBF58476D1CE4E5B9;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EB;
    return low + (high - low) * (static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53);
  }

  template <class Matrix>
  void fill(Matrix& m) {
    using Scalar = typename Matrix::Scalar;
    for (Eigen::Index c = 0; c < m.cols(); ++c) {
      for (Eigen::Index r = 0; r < m.rows(); ++r) m(r, c) = static_cast<Scalar>(uniform(-2, 2));
    }
  }

 private:
  uint64_t state_;
};

template <class Matrix>
void keep(const Matrix& m, Results& out) {
  for (Eigen::Index c = 0; c < m.cols(); ++c) {
    for (Eigen::Index r = 0; r < m.rows(); ++r) out.values.push_back(static_cast<double>(m(r, c)));
  }
}

template <class Scalar>
Results one_argument(const char* name, double low, double high, Scalar (*function)(Scalar)) {
  Results out{name, {}};
  Numbers numbers(1);
  for (size_t i = 0; i < kArguments; ++i) {
    out.values.push_back(
        static_cast<double>(function(static_cast<Scalar>(numbers.uniform(low, high)))));
  }
  return out;
}

template <class Scalar>
Results two_arguments(const char* name, double low, double high,
                      Scalar (*function)(Scalar, Scalar)) {
  Results out{name, {}};
  Numbers numbers(2);
  for (size_t i = 0; i < kArguments; ++i) {
    const auto x = static_cast<Scalar>(numbers.uniform(low, high));
    const auto y = static_cast<Scalar>(numbers.uniform(low, high));
    out.values.push_back(static_cast<double>(function(x, y)));
  }
  return out;
}

template <class Scalar>
void add_scalar_functions(const std::string& suffix, std::vector<Results>& all) {
  const auto add = [&](const char* name, double low, double high, Scalar (*function)(Scalar)) {
    all.push_back(one_argument<Scalar>((name + suffix).c_str(), low, high, function));
  };
  add("sin", -7, 7, [](Scalar x) { return std::sin(x); });
  add("cos", -7, 7, [](Scalar x) { return std::cos(x); });
  add("tan", -1.5, 1.5, [](Scalar x) { return std::tan(x); });
  add("asin", -1, 1, [](Scalar x) { return std::asin(x); });
  add("acos", -1, 1, [](Scalar x) { return std::acos(x); });
  add("atan", -9, 9, [](Scalar x) { return std::atan(x); });
  add("exp", -60, 20, [](Scalar x) { return std::exp(x); });
  add("exp2", -60, 20, [](Scalar x) { return std::exp2(x); });
  add("expm1", -3, 3, [](Scalar x) { return std::expm1(x); });
  add("log", 1e-9, 50, [](Scalar x) { return std::log(x); });
  add("log10", 1e-9, 50, [](Scalar x) { return std::log10(x); });
  add("log1p", -0.9, 9, [](Scalar x) { return std::log1p(x); });
  add("cbrt", -90, 90, [](Scalar x) { return std::cbrt(x); });
  add("erf", -3, 3, [](Scalar x) { return std::erf(x); });
  add("lgamma", 0.1, 90, [](Scalar x) { return std::lgamma(x); });
  add("sqrt", 0, 90, [](Scalar x) { return std::sqrt(x); });
  const auto add_two = [&](const char* name, double low, double high,
                           Scalar (*function)(Scalar, Scalar)) {
    all.push_back(two_arguments<Scalar>((name + suffix).c_str(), low, high, function));
  };
  add_two("atan2", -90, 90, [](Scalar x, Scalar y) { return std::atan2(x, y); });
  add_two("hypot", -90, 90, [](Scalar x, Scalar y) { return std::hypot(x, y); });
  add_two("pow", 1e-3, 20, [](Scalar x, Scalar y) { return std::pow(x, y); });
  add_two("remainder", -90, 90, [](Scalar x, Scalar y) { return std::remainder(x, y); });
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

std::vector<Results> compute() {
  std::vector<Results> all;
  add_scalar_functions<double>("", all);
  add_scalar_functions<float>("f", all);
  add_fixed_sums<double, 3>("double", all);
  add_fixed_sums<double, 6>("double", all);
  add_fixed_sums<double, 15>("double", all);
  add_fixed_sums<float, 3>("float", all);
  add_fixed_sums<float, 6>("float", all);
  add_fixed_sums<float, 8>("float", all);
  add_fixed_sums<float, 20>("float", all);
  add_fixed_matrices<double, 2>("double", all);
  add_fixed_matrices<double, 3>("double", all);
  add_fixed_matrices<double, 4>("double", all);
  add_fixed_matrices<double, 6>("double", all);
  add_fixed_matrices<float, 3>("float", all);
  add_fixed_matrices<float, 4>("float", all);
  add_fixed_matrices<float, 6>("float", all);
  add_dynamic_matrices<double>("double", all);
  add_dynamic_matrices<float>("float", all);
  add_geometry<double>("double", all);
  add_geometry<float>("float", all);
  return all;
}

bool write(const char* path, const std::vector<Results>& all) {
  std::ofstream file(path, std::ios::binary);
  for (const Results& results : all) {
    file << results.name << '\n' << results.values.size() << '\n';
    file.write(reinterpret_cast<const char*>(results.values.data()),
               static_cast<std::streamsize>(results.values.size() * sizeof(double)));
  }
  return static_cast<bool>(file.flush());
}

std::vector<Results> read(const char* path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<Results> all;
  std::string name, count;
  while (std::getline(file, name) && std::getline(file, count)) {
    Results results{name, std::vector<double>(std::stoul(count))};
    file.read(reinterpret_cast<char*>(results.values.data()),
              static_cast<std::streamsize>(results.values.size() * sizeof(double)));
    all.push_back(std::move(results));
  }
  return all;
}

/// Prints a row for what differs; the difference is relative to each number.
bool compare(const Results& a, const Results& b) {
  size_t differ = 0;
  double largest = 0;
  for (size_t i = 0; i < a.values.size(); ++i) {
    const double x = a.values[i], y = b.values[i];
    if (std::bit_cast<uint64_t>(x) == std::bit_cast<uint64_t>(y)) continue;
    if (std::isnan(x) && std::isnan(y)) continue;
    ++differ;
    largest = std::max(largest, std::abs(x - y) / std::max({std::abs(x), std::abs(y), 1e-300}));
  }
  if (differ > 0) {
    std::printf("| %-58s | %7zu | %7zu | %8.2g |\n", a.name.c_str(), a.values.size(), differ,
                largest);
  }
  return differ == 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2) return write(argv[1], compute()) ? 0 : 1;
  if (argc != 3) return 2;
  const auto first = read(argv[1]), second = read(argv[2]);
  if (first.empty() || first.size() != second.size()) return 3;
  std::printf("| %-58s | numbers | differ  | relative |\n|---|---|---|---|\n", "function");
  size_t same = 0;
  for (size_t i = 0; i < first.size(); ++i) {
    if (first[i].name != second[i].name || first[i].values.size() != second[i].values.size())
      return 3;
    same += compare(first[i], second[i]) ? 1 : 0;
  }
  std::printf("\n%zu of %zu functions give the same bits\n", same, first.size());
  return 0;
}
