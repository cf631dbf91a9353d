#include <gtest/gtest.h>

#include "daemon/mapping/g2o_file.hpp"
#include "fusion/mapping/chordal_initialisation.hpp"
#include "fusion/mapping/optimize.hpp"
#include "tests/read_xz.hpp"
#include "tests/real_data.hpp"

namespace infuse::daemon {
namespace {

struct KnownOptimum {
  const char* graph;
  double optimum;  // of the chordal cost, published or recomputed by a certifiable method
};

class RealPoseGraph : public testing::TestWithParam<KnownOptimum> {};

TEST_P(RealPoseGraph, ReachesTheGlobalOptimumFromChordalInitialisation) {
  INFUSE_REAL_DATA_OR_SKIP(path, std::string("posegraph/") + GetParam().graph + ".g2o.xz");
  const std::string text = read_xz(path);
  if (text.empty()) GTEST_SKIP() << "no program xz";
  const auto file = parse_g2o(text, path.string());
  ASSERT_TRUE(file) << file.error().message();
  std::visit(
      [](auto stated) {
        ASSERT_TRUE(mapping::initialise_chordal(stated.graph));
        mapping::PoseGraphSolver solver(stated.graph);
        const auto result = solver.optimize(stated.graph, {.cost = mapping::Cost::kChordal});
        EXPECT_TRUE(result.usable()) << result.reason;
        EXPECT_NEAR(result.cost, GetParam().optimum, 1e-6 * GetParam().optimum);
      },
      *file);
}

// Those that take seconds are in `infuse-study pose-graphs`.
INSTANTIATE_TEST_SUITE_P(
    KnownOptima, RealPoseGraph,
    testing::Values(KnownOptimum{"tinyGrid3D", 18.51937}, KnownOptimum{"smallGrid3D", 1025.398},
                    KnownOptimum{"MIT", 61.15412}, KnownOptimum{"CSAIL", 31.70372},
                    KnownOptimum{"intel", 52.34823}, KnownOptimum{"manhattan", 6431.391},
                    KnownOptimum{"kitti_00", 125.6935}, KnownOptimum{"kitti_05", 276.5144}),
    [](const auto& tested) { return std::string(tested.param.graph); });

}  // namespace
}  // namespace infuse::daemon
