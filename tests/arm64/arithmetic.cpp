// Arithmetic that libraries do, with random arguments, as bits: what differs between two
// processors, by function.
//
//   infuse-arithmetic FILE           writes the results of every function
//   infuse-arithmetic FILE FILE      compares two such files, and prints a table
#include "tests/arm64/arithmetic.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <fstream>

namespace {

using infuse::arithmetic::Numbers;
using infuse::arithmetic::Results;

constexpr size_t kArguments = 100'000;  // of each function

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

std::vector<Results> compute() {
  std::vector<Results> all = infuse::arithmetic::eigen_results();
  add_scalar_functions<double>("", all);
  add_scalar_functions<float>("f", all);
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
