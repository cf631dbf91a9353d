#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "daemon/protocol/json.hpp"
#include "tests/daemon/run_program.hpp"
#include "tests/daemon/schema.hpp"
#include "tests/folders.hpp"
#include "tests/scratch_folder.hpp"

namespace infuse::daemon {
namespace {

using testing::HasSubstr;

/// A square of four poses whose last side is measured 0.4 m too long, closed to its first pose.
constexpr const char* kSquare =
    "EDGE_SE2 0 1 1 0 1.5707963267948966 1 0 0 1 0 1\n"
    "EDGE_SE2 1 2 1 0 1.5707963267948966 1 0 0 1 0 1\n"
    "EDGE_SE2 2 3 1 0 1.5707963267948966 1 0 0 1 0 1\n"
    "EDGE_SE2 3 0 1.4 0 1.5707963267948966 1 0 0 1 0 1\n";

class MapCommandTest : public testing::Test {
 protected:
  ProgramResult optimize(const std::string& options) const {
    return run_shell_command(programs_folder() + "/infuse map optimize " +
                             (folder_ / "graph.g2o").string() + " -o " +
                             (folder_ / "out.g2o").string() + " " + options + " 2>&1");
  }

  const ScratchFolder folder_;
};

// The two sides along x share the 0.4 m with what turning the square gives: the cost is less than
// that of leaving all to one side, 0.16, or of halving it, 0.08.
TEST_F(MapCommandTest, OptimisesAGraphWithoutPoses) {
  folder_.write("graph.g2o", kSquare);
  const auto result = optimize("--json");
  ASSERT_EQ(result.code, 0) << result.output;
  EXPECT_TRUE(is_result(result.output, "map-optimize"));
  const Json json = Json::parse(result.output);
  EXPECT_EQ(json["poses"], 4);
  EXPECT_EQ(json["edges"], 4);
  EXPECT_TRUE(json["usable"]);
  EXPECT_LT(json["cost"], 0.08);
  EXPECT_GT(json["cost"], 0.01);
  EXPECT_THAT(folder_.read("out.g2o"), HasSubstr("VERTEX_SE2 3 "));
  EXPECT_EQ(optimize("--start odometry").code, 0);
}

TEST_F(MapCommandTest, SaysWhatIsWrong) {
  folder_.write("graph.g2o", "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\nEDGE_SE2 0 1 1 nan\n");
  EXPECT_EQ(optimize("").code, 3);
  EXPECT_THAT(optimize("").output, HasSubstr("graph.g2o:2: "));
  folder_.write("graph.g2o", kSquare);
  EXPECT_THAT(optimize("--start file").output, HasSubstr("the file states no poses"));
  EXPECT_EQ(optimize("--cost least").code, 2);
}

// Three laps of a square of 1 m, true closures from lap to lap, and one that takes opposite corners
// for one place.
TEST_F(MapCommandTest, RejectsAFalseClosure) {
  std::string text;
  for (int k = 0; k < 11; ++k) {
    text += "EDGE_SE2 " + std::to_string(k) + " " + std::to_string(k + 1) +
            " 1 0 1.5707963267948966 2500 0 0 2500 0 10000\n";
  }
  for (int k = 0; k < 8; ++k) {
    text += "EDGE_SE2 " + std::to_string(k) + " " + std::to_string(k + 4) +
            " 0 0 0 2500 0 0 2500 0 10000\n";
  }
  text += "EDGE_SE2 1 7 0 0 0 2500 0 0 2500 0 10000\n";
  folder_.write("graph.g2o", text);
  const auto result = optimize("--robust --json");
  ASSERT_EQ(result.code, 0) << result.output;
  EXPECT_TRUE(is_result(result.output, "map-optimize"));
  const Json json = Json::parse(result.output);
  EXPECT_EQ(json["closures"], 9);
  ASSERT_EQ(json["rejected"].size(), 1) << result.output;
  EXPECT_EQ(json["rejected"][0]["from"], 1);
  EXPECT_EQ(json["rejected"][0]["to"], 7);
  EXPECT_LT(json["cost"], 1e-6);
  EXPECT_THAT(folder_.read("out.g2o"), Not(HasSubstr("EDGE_SE2 1 7 ")));
  EXPECT_THAT(optimize("--robust").output, HasSubstr("1 of 9 closures rejected"));
}

TEST_F(MapCommandTest, ReadsCompressedGraphsAndNamesTheOthers) {
  folder_.write("graph.g2o", kSquare);
  ASSERT_EQ(optimize("").code, 0);
  const std::string expected = folder_.read("out.g2o");
  const std::string file = (folder_ / "graph.g2o").string();
  ASSERT_EQ(run_shell_command("gzip -f " + file + " && mv " + file + ".gz " + file).code, 0);
  EXPECT_EQ(optimize("").code, 0);
  EXPECT_EQ(folder_.read("out.g2o"), expected);
  folder_.write("graph.g2o", std::string("\xFD"
                                         "7zXZ\0",
                                         6) +
                                 "rest");
  const auto refused = optimize("");
  EXPECT_EQ(refused.code, 3);
  EXPECT_THAT(refused.output, HasSubstr("unxz"));
}

// A file that ends in .g2o is a graph without the word optimize too.
TEST_F(MapCommandTest, TakesAGraphInPlaceOfADrive) {
  folder_.write("graph.g2o", kSquare);
  const std::string infuse = programs_folder() + "/infuse map ";
  ASSERT_EQ(optimize("").code, 0);
  const std::string expected = folder_.read("out.g2o");
  const auto result = run_shell_command(infuse + (folder_ / "graph.g2o").string() + " -o " +
                                        (folder_ / "other.g2o").string() + " 2>&1");
  EXPECT_EQ(result.code, 0) << result.output;
  EXPECT_EQ(folder_.read("other.g2o"), expected);
}

}  // namespace
}  // namespace infuse::daemon
