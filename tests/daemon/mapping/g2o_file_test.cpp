#include "daemon/mapping/g2o_file.hpp"

#include <gtest/gtest.h>

namespace infuse::daemon {
namespace {

constexpr const char* kPlanar =
    "# a square\nVERTEX_SE2 3 0 0 0\nVERTEX_SE2 4 1 0.5 1.5\nVERTEX_SE2 9 +1 1 -3\nFIX 3\n\n"
    "EDGE_SE2 3 4 1 0.25 1.5 10 1 0 20 0 300\r\nEDGE_SE2 9 4 0.5 0 0 1 0 0 1 0 1\n";

std::string error_of(std::string_view text) {
  const auto file = parse_g2o(text, "a.g2o");
  return file ? "" : file.error().message();
}

TEST(G2oFile, ReadsPosesAndEdgesByTheirIds) {
  const auto file = parse_g2o(kPlanar, "a.g2o");
  ASSERT_TRUE(file) << file.error().message();
  const auto& planar = std::get<G2oGraph<2>>(*file);
  EXPECT_TRUE(planar.has_poses);
  EXPECT_EQ(planar.ids, (std::vector<int64_t>{3, 4, 9}));
  EXPECT_DOUBLE_EQ(planar.graph.poses[2].translation().x(), 1);
  EXPECT_DOUBLE_EQ(planar.graph.poses[1].linear()(1, 0), std::sin(1.5));
  ASSERT_EQ(planar.graph.edges.size(), 2U);
  const auto& edge = planar.graph.edges[0];
  EXPECT_EQ(edge.from, 0U);
  EXPECT_EQ(edge.to, 1U);
  EXPECT_FALSE(edge.closure);
  EXPECT_TRUE(planar.graph.edges[1].closure);
  EXPECT_EQ(edge.information, (Eigen::Matrix3d{{10, 1, 0}, {1, 20, 0}, {0, 0, 300}}));
}

TEST(G2oFile, ReadsThreeDimensionsWithoutPoses) {
  const std::string text =
      "EDGE_SE3:QUAT 7 2 1 2 3 0 0 -0.6 -0.8 1 0 0 0 0 0 2 0 0 0 0 3 0 0 0 4 0 0 5 0.5 6\n";
  const auto file = parse_g2o(text, "a.g2o");
  ASSERT_TRUE(file) << file.error().message();
  const auto& spatial = std::get<G2oGraph<3>>(*file);
  EXPECT_FALSE(spatial.has_poses);
  EXPECT_EQ(spatial.ids, (std::vector<int64_t>{2, 7}));
  const auto& edge = spatial.graph.edges[0];
  EXPECT_EQ(edge.from, 1U);
  EXPECT_TRUE(edge.T_from_to.linear().isApprox(
      Eigen::AngleAxisd(2 * std::atan2(0.6, 0.8), Eigen::Vector3d::UnitZ()).toRotationMatrix()));
  EXPECT_EQ(edge.information(4, 5), 0.5);
  EXPECT_EQ(edge.information(5, 4), 0.5);
  EXPECT_EQ(edge.information(3, 3), 4);
}

TEST(G2oFile, WritesWhatItReadsAgain) {
  const auto file = std::get<G2oGraph<2>>(*parse_g2o(kPlanar, "a.g2o"));
  const std::string text = format_g2o(file);
  const auto again = parse_g2o(text, "b.g2o");
  ASSERT_TRUE(again) << again.error().message();
  const auto& planar = std::get<G2oGraph<2>>(*again);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_TRUE(planar.graph.poses[i].isApprox(file.graph.poses[i], 1e-14));
  }
  EXPECT_EQ(planar.graph.edges[0].information, file.graph.edges[0].information);
  EXPECT_EQ(format_g2o(planar), text);
}

TEST(G2oFile, StatesTheLineAndWhatIsWrong) {
  EXPECT_EQ(error_of(""),
            "a.g2o: no pose graph (expected lines such as EDGE_SE2 or EDGE_SE3:QUAT)");
  EXPECT_THAT(error_of("# x\nVERTEX_XY 1 2 3\n"),
              testing::StartsWith("a.g2o:2: unknown element 'VERTEX_XY'"));
  EXPECT_THAT(error_of("VERTEX_SE2 1 2 3\n"),
              testing::StartsWith("a.g2o:1: not an id and 3 finite numbers"));
  EXPECT_THAT(error_of("VERTEX_SE2 1 2 3 nan\n"), testing::HasSubstr("finite numbers"));
  EXPECT_THAT(error_of("VERTEX_SE2 -1 2 3 4\n"), testing::HasSubstr("not an id"));
  EXPECT_THAT(error_of("VERTEX_SE2 1 2 3 4\nVERTEX_SE2 1 2 3 4\n"),
              testing::HasSubstr("a.g2o:2: pose 1 is stated twice"));
  EXPECT_THAT(error_of("VERTEX_SE3:QUAT 1 2 3 4 0 0 0 2\n"),
              testing::HasSubstr("the norm of the quaternion is not 1"));
  EXPECT_THAT(error_of("EDGE_SE2 1 1 0 0 0 1 0 0 1 0 1\n"),
              testing::HasSubstr("joins pose 1 to itself"));
  EXPECT_THAT(error_of("EDGE_SE2 1 2 0 0 0 1 5 0 1 0 1\n"),
              testing::HasSubstr("not positive semidefinite"));
  EXPECT_THAT(error_of("EDGE_SE2 1 2 0 0 0 1 0 0 1 0 1 7\n"), testing::HasSubstr("not two ids"));
  EXPECT_THAT(error_of("VERTEX_SE2 1 0 0 0\nEDGE_SE2 1 2 0 0 0 1 0 0 1 0 1\n"),
              testing::HasSubstr("a.g2o:2: no pose 2"));
  EXPECT_THAT(error_of("VERTEX_SE2 1 0 0 0\nVERTEX_SE3:QUAT 2 0 0 0 0 0 0 1\n"),
              testing::HasSubstr("a.g2o:2: elements of two and of three dimensions"));
}

}  // namespace
}  // namespace infuse::daemon
