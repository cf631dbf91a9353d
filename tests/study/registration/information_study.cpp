#include "tests/study/registration/information_study.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>

#include "fusion/registration/gicp.hpp"
#include "fusion/registration/visual/information_alignment.hpp"
#include "fusion/registration/visual/k_means.hpp"
#include "fusion/registration/visual/learned_codebook.hpp"
#include "tests/study/registration/learn_codebook.hpp"

namespace infuse::study {
namespace {

using namespace registration;

const std::vector<double> kDistances{0, 1, 2.1, 3.3, 4.6, 6.2, 8, 10};  // m along the drive
const std::vector<ScanFeature> kKinds{ScanFeature::kReflectivityGrey, ScanFeature::kFpfh,
                                      ScanFeature::kSift, ScanFeature::kFpfhSift};

/// An alignment that is tried on every pair; without `codebook` the shipped one.
struct Method {
  std::string name;
  ScanFeature feature = ScanFeature::kFpfhSift;
  std::optional<Codebook> learned;
  InformationAlignmentOptions options;

  const Codebook& codebook() const { return learned ? *learned : learned_codebook(); }
};

InformationAlignmentOptions simplex(double coarse_radius = 1.5) {
  return {.optimizer = InformationOptimizer::kSimplex, .coarse_radius = coarse_radius};
}

std::vector<Method> make_methods(const InformationStudyOptions& options, bool variants) {
  const std::vector<Eigen::MatrixXf> features =
      training_features({.drives = options.training_drives}, kKinds);
  const auto learn = [&](ScanFeature kind, size_t words) {
    return registration::learn_codebook(features[static_cast<size_t>(kind)], words, 1);
  };
  // Reflectivity and grey are of many points: a narrower radius, or every point has a partner.
  std::vector<Method> methods{
      {"fpfh-sift search", ScanFeature::kFpfhSift, {}, {}},
      {"fpfh-sift simplex", ScanFeature::kFpfhSift, {}, simplex()},
      {"sift search", ScanFeature::kSift, learn(ScanFeature::kSift, 100), {}},
      {"sift simplex", ScanFeature::kSift, learn(ScanFeature::kSift, 100), simplex()},
      {"fpfh simplex", ScanFeature::kFpfh, learn(ScanFeature::kFpfh, 100), simplex()},
      {"reflectivity-grey simplex", ScanFeature::kReflectivityGrey,
       learn(ScanFeature::kReflectivityGrey, 100), simplex(0.5)}};
  if (!variants) return methods;
  methods.push_back({"fpfh-sift search, optimal shrinkage",
                     ScanFeature::kFpfhSift,
                     {},
                     {.shrinkage = ShrinkageRule::kOptimal}});
  methods.push_back({"fpfh-sift search, no shrinkage",
                     ScanFeature::kFpfhSift,
                     {},
                     {.shrinkage = ShrinkageRule::kNone}});
  for (const size_t words : {50U, 250U, 500U, 1000U}) {
    methods.push_back({"fpfh-sift search, " + std::to_string(words) + " words",
                       ScanFeature::kFpfhSift,
                       learn(ScanFeature::kFpfhSift, words),
                       {}});
  }
  return methods;
}

/// A scan as every method needs it.
struct PreparedScan {
  std::vector<ScanFeatures> features;  // of kKinds
  PreparedCloud cloud;
  Eigen::Isometry3d T_world_lidar;
};

std::vector<PreparedScan> render(uint64_t seed) {
  const auto drive = render_drive(seed, kDistances);
  if (!drive) throw std::runtime_error(drive.error().message());
  std::vector<PreparedScan> scans;
  for (const PosedScan& scan : drive->scans) {
    PreparedScan& prepared = scans.emplace_back();
    for (const ScanFeature kind : kKinds) {
      prepared.features.push_back(features_of(scan, drive->rig, kind));
    }
    prepared.cloud = prepare_cloud({scan.sweep.x, scan.sweep.y, scan.sweep.z});
    prepared.T_world_lidar = scan.T_world_lidar;
  }
  return scans;
}

CodewordCloud codewords(const PreparedScan& scan, const Method& method) {
  const ScanFeatures& features = scan.features[static_cast<size_t>(method.feature)];
  return {features.points, quantise(method.codebook(), features.vectors)};
}

void write_row(std::ostream& out, uint64_t seed, const std::string& method,
               const Eigen::Isometry3d& truth, const RegistrationResult& result, double seconds) {
  const geometry::Vector6 left = geometry::log(truth * result.T_target_source.inverse());
  const double rotation =
      geometry::rotation_log(truth.linear().transpose() * result.T_target_source.linear()).norm();
  out << seed << ';' << method << ';' << truth.translation().norm() << ';'
      << (truth.translation() - result.T_target_source.translation()).norm() << ';'
      << rotation * 180 / std::numbers::pi << ';' << result.usable() << ';'
      << left.dot(result.information * left) / 6 << ';' << seconds << '\n';
}

void align_pairs(std::ostream& out, uint64_t seed, const std::vector<PreparedScan>& scans,
                 const std::vector<Method>& methods) {
  const auto now = [] { return std::chrono::steady_clock::now(); };
  const auto since = [&](auto start) {
    return std::chrono::duration<double>(now() - start).count();
  };
  for (size_t i = 0; i < scans.size(); ++i) {
    for (size_t j = i + 1; j < scans.size(); ++j) {
      const PreparedScan &target = scans[i], &source = scans[j];
      const Eigen::Isometry3d truth = target.T_world_lidar.inverse() * source.T_world_lidar;
      const auto refine = [&](const std::string& name, const Eigen::Isometry3d& guess) {
        const auto start = now();
        const RegistrationResult result = gicp(target.cloud, source.cloud.cloud, guess);
        write_row(out, seed, name, truth, result, since(start));
      };
      refine("gicp alone", Eigen::Isometry3d::Identity());
      for (const Method& method : methods) {
        const CodewordCloud q = codewords(target, method), p = codewords(source, method);
        const auto start = now();
        const RegistrationResult result =
            align_by_information(method.codebook(), q, p, method.options);
        write_row(out, seed, method.name, truth, result, since(start));
        if (&method == &methods.front()) {
          refine("gicp after " + method.name, result.T_target_source);
        }
      }
    }
  }
}

std::vector<std::vector<std::string>> read_rows(const std::filesystem::path& path) {
  std::vector<std::vector<std::string>> rows;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    std::istringstream text(line);
    std::vector<std::string>& row = rows.emplace_back();
    for (std::string field; std::getline(text, field, ';');) row.push_back(field);
    if (row.size() != 8) throw std::runtime_error(path.string() + ": not rows of this study");
  }
  return rows;
}

/// Pairs of one method and range of distances.
struct Tally {
  int pairs = 0, converged = 0, usable = 0, wrong = 0;
  double error = 0, normalised = 0, seconds = 0;
};

}  // namespace

void run_information_study(const std::filesystem::path& path,
                           const InformationStudyOptions& options) {
  std::set<std::string> done;
  for (const auto& row : read_rows(path)) done.insert(row[0]);
  std::vector<Method> all;
  for (int d = 0; d < options.drives; ++d) {
    const uint64_t seed = options.first_seed + static_cast<uint64_t>(d);
    if (done.contains(std::to_string(seed))) continue;
    if (all.empty()) all = make_methods(options, options.variant_drives > 0);
    std::vector<Method> methods = all;
    if (d >= options.variant_drives) methods.resize(std::min<size_t>(methods.size(), 6));
    std::ostringstream rows;
    align_pairs(rows, seed, render(seed), methods);
    std::ofstream file(path, std::ios::app);
    if (!(file << rows.str()).flush()) throw std::runtime_error("cannot write to " + path.string());
  }
}

void write_information_table(std::ostream& out, const std::filesystem::path& path) {
  std::map<std::pair<std::string, bool>, Tally> tallies;
  for (const auto& row : read_rows(path)) {
    const double distance = std::stod(row[2]), error = std::stod(row[3]);
    Tally& tally = tallies[{row[1], distance > 5}];
    const bool converged = error <= 0.3 && std::stod(row[4]) <= 1, usable = row[5] == "1";
    ++tally.pairs;
    tally.converged += converged;
    tally.usable += usable;
    tally.wrong += usable && !converged;
    tally.error += error;
    if (usable && converged) tally.normalised += std::stod(row[6]);
    tally.seconds += std::stod(row[7]);
  }
  out << "| method | distance, m | pairs | converged | usable | usable but wrong | mean error, m | "
         "normalised error | time, s |\n|---|---|---|---|---|---|---|---|---|\n";
  for (const auto& [key, t] : tallies) {
    char text[200];
    std::snprintf(
        text, sizeof(text), "| %s | %s | %d | %.1f %% | %.1f %% | %d | %.2f | %.1f | %.2f |\n",
        key.first.c_str(), key.second ? "5 … 10" : "1 … 5", t.pairs, 100.0 * t.converged / t.pairs,
        100.0 * t.usable / t.pairs, t.wrong, t.error / t.pairs,
        t.normalised / std::max(1, t.usable - t.wrong), t.seconds / t.pairs);
    out << text;
  }
}

void write_information_profile(std::ostream& out, uint64_t seed) {
  const auto drive = render_drive(seed, {0, 4.6});
  if (!drive) throw std::runtime_error(drive.error().message());
  std::vector<CodewordCloud> clouds;
  for (const PosedScan& scan : drive->scans) {
    const ScanFeatures features = features_of(scan, drive->rig, ScanFeature::kFpfhSift);
    clouds.push_back({features.points, quantise(learned_codebook(), features.vectors)});
  }
  const Eigen::Isometry3d truth =
      drive->scans[0].T_world_lidar.inverse() * drive->scans[1].T_world_lidar;
  CodewordInformation information(learned_codebook(), clouds[0], ShrinkageRule::kByCorrespondences,
                                  0.5 * static_cast<double>(clouds[0].size() + clouds[1].size()));
  information.set_radius(1.5);
  out << "| displacement, m | along x, nats | along y, nats |\n|---|---|---|\n";
  for (int step = -6; step <= 6; ++step) {
    out << "| " << step;
    for (const int axis : {0, 1}) {
      Eigen::Isometry3d T = truth;
      T.translation()[axis] += step;
      char text[32];
      std::snprintf(text, sizeof(text), " | %.4f", information.evaluate(clouds[1], T));
      out << text;
    }
    out << " |\n";
  }
}

}  // namespace infuse::study
