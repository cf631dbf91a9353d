#include "tests/study/mapping/pose_graph_study.hpp"

#include <spdlog/fmt/fmt.h>

#include <cmath>
#include <ctime>
#include <ostream>
#include <stdexcept>

#include "daemon/mapping/g2o_file.hpp"
#include "fusion/mapping/chordal_initialisation.hpp"
#include "fusion/mapping/robust.hpp"
#include "tests/read_xz.hpp"
#include "tests/study/mapping/false_closures.hpp"

namespace infuse::study {
namespace {

using namespace mapping;

daemon::G2oFile read(const std::string& file) {
  const auto graph =
      file.ends_with(".xz") ? daemon::parse_g2o(read_xz(file), file) : daemon::read_g2o(file);
  if (!graph) throw std::runtime_error(graph.error().message());
  return *graph;
}

std::string name_of(const std::string& file) {
  const std::string name = std::filesystem::path(file).filename();
  return name.substr(0, name.find('.'));
}

/// Processor time, s.
double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

template <int D>
void optimize_graph(std::ostream& out, const std::string& name, PoseGraph<D> graph, Cost cost,
                    bool chordal) {
  const double start = cpu_seconds();
  if (chordal) {
    if (!initialise_chordal(graph)) throw std::runtime_error(name + " is not determined");
  } else {
    compose_odometry(graph);
  }
  const OptimizeResult result = PoseGraphSolver<D>(graph).optimize(graph, {.cost = cost});
  out << fmt::format("| {} | {} | {} | {:.8g} | {:.10g} | {} | {:.2f} | {} |\n", name,
                     cost == Cost::kChordal ? "chordal" : "information",
                     chordal ? "chordal" : "odometry", result.initial_cost, result.cost,
                     result.iterations, cpu_seconds() - start, result.reason)
      << std::flush;
}

/// Counts over all seeds of one setting.
struct Rejection {
  size_t true_closures = 0, true_rejected = 0, false_closures = 0, false_rejected = 0;
  size_t within = 0, unusable = 0;
  double max_rms_percent = 0, max_cpu = 0;
};

template <int D>
double extent(const std::vector<Pose<D>>& poses) {
  Eigen::Matrix<double, D, 1> low = poses[0].translation(), high = low;
  for (const Pose<D>& pose : poses) {
    low = low.cwiseMin(pose.translation());
    high = high.cwiseMax(pose.translation());
  }
  return (high - low).norm();
}

template <int D>
void reject(const PoseGraph<D>& clean, double fraction, bool groups, uint32_t seed,
            Rejection& counts) {
  std::mt19937 random(seed);
  PoseGraph<D> graph = clean;
  size_t closures = 0;
  for (const PoseEdge<D>& edge : graph.edges) closures += edge.closure;
  const auto count = static_cast<size_t>(std::ceil(fraction * static_cast<double>(closures)));
  add_false_closures(graph, count, groups, random);
  const double start = cpu_seconds();
  const RobustResult result = optimize_robustly(graph);
  counts.max_cpu = std::max(counts.max_cpu, cpu_seconds() - start);
  counts.unusable += !result.usable();
  for (size_t e = 0; e < graph.edges.size(); ++e) {
    if (!graph.edges[e].closure) continue;
    const bool is_true = e < clean.edges.size(), rejected = result.accepted[e] == 0;
    ++(is_true ? counts.true_closures : counts.false_closures);
    (is_true ? counts.true_rejected : counts.false_rejected) += rejected;
  }
  double sum = 0;
  for (size_t i = 0; i < graph.poses.size(); ++i) {
    sum += (graph.poses[i].translation() - clean.poses[i].translation()).squaredNorm();
  }
  const double rms_percent =
      100 * std::sqrt(sum / static_cast<double>(graph.poses.size())) / extent<D>(clean.poses);
  counts.within += rms_percent <= 1;
  counts.max_rms_percent = std::max(counts.max_rms_percent, rms_percent);
}

}  // namespace

void optimize_graphs(std::ostream& out, const std::vector<std::string>& files) {
  out << "| graph | cost | from | initially | at the end | factorisations | cpu s | reason |\n"
         "|---|---|---|---|---|---|---|---|\n";
  for (const std::string& file : files) {
    const daemon::G2oFile graph = read(file);
    for (const Cost cost : {Cost::kChordal, Cost::kInformation}) {
      for (const bool chordal : {true, false}) {
        std::visit(
            [&](const auto& stated) {
              optimize_graph(out, name_of(file), stated.graph, cost, chordal);
            },
            graph);
      }
    }
  }
}

void reject_false_closures(std::ostream& out, const std::vector<std::string>& files, int seeds) {
  out << "| graph | false | groups | seeds with rms <= 1 % | largest rms % | false rejected % | "
         "true "
         "rejected % | not usable | cpu s |\n|---|---|---|---|---|---|---|---|---|\n";
  for (const std::string& file : files) {
    std::visit(
        [&](auto stated) {
          auto& clean = stated.graph;
          initialise_chordal(clean);
          PoseGraphSolver(clean).optimize(clean);
          for (const double fraction : {0.1, 0.5}) {
            for (const bool groups : {false, true}) {
              Rejection counts;
              for (int seed = 1; seed <= seeds; ++seed) {
                reject(clean, fraction, groups, static_cast<uint32_t>(seed), counts);
              }
              const auto percent = [](size_t part, size_t all) {
                return 100 * static_cast<double>(part) / static_cast<double>(all);
              };
              out << fmt::format(
                         "| {} | {:.0f} % | {} | {} of {} | {:.3f} | {:.2f} | {:.2f} | {} | {:.1f} "
                         "|\n",
                         name_of(file), 100 * fraction, groups ? "yes" : "no", counts.within, seeds,
                         counts.max_rms_percent,
                         percent(counts.false_rejected, counts.false_closures),
                         percent(counts.true_rejected, counts.true_closures), counts.unusable,
                         counts.max_cpu)
                  << std::flush;
            }
          }
        },
        read(file));
  }
}

}  // namespace infuse::study
