// The shipped JSON Schemas are those of the descriptions. With INFUSE_WRITE_SCHEMAS in the
// environment they are written instead of compared.

#include <gtest/gtest.h>

#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "tests/daemon/protocol/schema_writer.hpp"
#include "tests/folders.hpp"

namespace infuse::daemon {
namespace {

template <class Report>
class SchemaTest : public testing::Test {};

using Messages = testing::Types<VersionReport, DevicesReport, SweepReport, FrameReport, PoseReport,
                                CalibrationReport, HealthReport, AlertReport, RecordReport,
                                LostReport, AckReply, ErrorReply>;
TYPED_TEST_SUITE(SchemaTest, Messages);

TYPED_TEST(SchemaTest, ShippedFileIsThatOfTheDescription) {
  const OrderedJson schema = schema_of(TypeParam{});
  std::string name = schema["title"];
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  const std::filesystem::path path =
      std::filesystem::path(source_folder()) / "daemon/protocol" / (name + ".schema.json");
  const std::string text = pretty(schema) + "\n";
  if (std::getenv("INFUSE_WRITE_SCHEMAS") != nullptr) {
    std::ofstream(path) << text;
    GTEST_SKIP() << "written: " << path;
  }
  std::stringstream shipped;
  shipped << std::ifstream(path).rdbuf();
  EXPECT_EQ(shipped.str(), text) << path << ": update it with INFUSE_WRITE_SCHEMAS=1";
}

}  // namespace
}  // namespace infuse::daemon
