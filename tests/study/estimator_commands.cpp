#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "tests/study/dependence/estimators.hpp"
#include "tests/study/dependence/gaussian_accuracy.hpp"
#include "tests/study/study_commands.hpp"

namespace infuse::study {
namespace {

/// Reads two columns of numbers separated by a comma or blanks, and scales each to zero mean and
/// unit variance. Throws CLI::ValidationError.
SamplePairs read_pairs(const std::string& path) {
  std::ifstream file(path);
  std::vector<double> values;
  std::string line;
  for (size_t number = 1; std::getline(file, line); ++number) {
    for (char& c : line) c = c == ',' ? ' ' : c;
    std::istringstream row(line);
    double x = 0, y = 0;
    if (!(row >> x >> y)) {
      if (number == 1) continue;  // header
      throw CLI::ValidationError(path + ":" + std::to_string(number), "not two numbers");
    }
    values.insert(values.end(), {x, y});
  }
  if (values.size() < 4) throw CLI::ValidationError(path, "fewer than two pairs");
  SamplePairs pairs =
      Eigen::Map<SamplePairs>(values.data(), 2, static_cast<Eigen::Index>(values.size() / 2));
  pairs.colwise() -= pairs.rowwise().mean().eval();
  const Eigen::Array2d sigma = pairs.array().square().rowwise().mean().sqrt();
  for (int side = 0; side < 2; ++side) {
    if (sigma[side] > 0) pairs.row(side) /= sigma[side];
  }
  return pairs;
}

const Estimator& find_estimator(const std::vector<Estimator>& estimators, const std::string& key) {
  for (const Estimator& estimator : estimators) {
    if (estimator.key == key) return estimator;
  }
  throw CLI::ValidationError("ESTIMATOR", "unknown estimator " + key + "; see infuse-study list");
}

void list(const std::vector<Estimator>& estimators) {
  for (const Estimator& estimator : estimators) {
    std::cout << estimator.key << std::string(std::max<size_t>(26 - estimator.key.size(), 1), ' ')
              << estimator.quantity << " by " << estimator.name << '\n';
  }
}

int run(const Estimator& estimator, const SamplePairs& pairs) {
  const Estimate estimate = estimator.estimate(pairs);
  if (estimate.usable()) {
    std::printf("%s %.6g\n", estimator.quantity.c_str(), estimate.value);
    return 0;
  }
  std::fprintf(stderr, "infuse-study: %s\n", estimate.reason);
  return 1;
}

int compare(const std::vector<Estimator>& estimators, const std::string& folder) {
  std::vector<AccuracyRow> rows;
  for (const Estimator& estimator : estimators) {
    std::cerr << estimator.quantity << ": " << estimator.name << '\n';
    rows.push_back(measure_accuracy(estimator));
  }
  if (folder.empty()) {
    write_table(std::cout, rows);
    return 0;
  }
  std::ofstream table(folder + "/accuracy.md"), plot(folder + "/accuracy.svg");
  write_table(table, rows);
  write_plot(plot, rows);
  if (table.flush() && plot.flush()) return 0;
  std::cerr << "infuse-study: cannot write to " << folder << '\n';
  return 3;
}

}  // namespace

void add_estimator_commands(CLI::App& app, int& status) {
  static std::string key, file, folder;
  app.add_subcommand("list", "list the estimators of I chapter 2 and P 2.4 and what they estimate")
      ->callback([] { list(make_estimators()); });
  CLI::App* run_command = app.add_subcommand("run", "run one estimator on pairs of numbers");
  run_command->add_option("ESTIMATOR", key, "key of the estimator, see list")->required();
  run_command
      ->add_option("FILE", file,
                   "two columns of numbers; each is scaled to zero mean and unit variance")
      ->required()
      ->check(CLI::ExistingFile);
  run_command->callback([&status] {
    const std::vector<Estimator> estimators = make_estimators();
    status = run(find_estimator(estimators, key), read_pairs(file));
  });
  CLI::App* accuracy_command = app.add_subcommand(
      "accuracy", "measure bias and standard deviation on the bivariate Gaussian");
  accuracy_command->add_option("ESTIMATOR", key, "key of the estimator (default: all)");
  accuracy_command
      ->add_option("-o,--output", folder, "write accuracy.md and accuracy.svg to this folder")
      ->check(CLI::ExistingDirectory);
  accuracy_command->callback([&status] {
    const std::vector<Estimator> estimators = make_estimators();
    status = key.empty() ? compare(estimators, folder)
                         : compare({find_estimator(estimators, key)}, folder);
  });
}

}  // namespace infuse::study
