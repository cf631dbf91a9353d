#include "drivers/velodyne/model.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"

#include <gtest/gtest.h>

namespace infuse::velodyne {
namespace {

TEST(Model, IsFoundByNameInAnySpelling) {
  EXPECT_EQ(find_model("VLP-16"), Model::kVlp16);
  EXPECT_EQ(find_model("vlp16"), Model::kVlp16);
  EXPECT_EQ(find_model("puck_hi_res"), Model::kPuckHiRes);
  EXPECT_EQ(find_model("hdl64es3"), Model::kHdl64eS3);
  EXPECT_FALSE(find_model("VLP-1"));
  EXPECT_FALSE(find_model("VLP-160"));
  EXPECT_FALSE(find_model(""));
  for (const ModelInfo& info : models()) EXPECT_EQ(find_model(info.name), info.model);
}

// The vendor's packet rates, single and dual return.
TEST(Model, PacketRatesMatchTheManuals) {
  const auto rate = [](Model model, bool dual) {
    const ModelInfo& info = model_info(model);
    return 1 / to_seconds(packet_period(info, info.cycle, dual));
  };
  EXPECT_NEAR(rate(Model::kHdl32e, false), 1808, 1);
  EXPECT_NEAR(rate(Model::kHdl32e, true), 3617, 1);
  EXPECT_NEAR(rate(Model::kVlp16, false), 754, 1);
  EXPECT_NEAR(rate(Model::kPuckHiRes, true), 1508, 1);
  EXPECT_NEAR(rate(Model::kVlp32c, false), 1507, 1);
  EXPECT_NEAR(rate(Model::kVlp32c, true), 3014, 1);
  EXPECT_NEAR(rate(Model::kHdl64eS2, false), 3472, 1);
  EXPECT_NEAR(rate(Model::kHdl64eS3, false), 2893, 1);
  EXPECT_NEAR(rate(Model::kHdl64eS3, true), 5787, 1);
  EXPECT_NEAR(rate(Model::kVls128, false), 6030, 1);
  EXPECT_NEAR(rate(Model::kVls128, true), 18'100, 20);
}

TEST(Model, AllLasersFireWithinTheSequence) {
  for (const ModelInfo& info : models()) {
    const auto times = firing_times(info, info.cycle);
    for (size_t slot = 0; slot < info.slots(); ++slot) {
      EXPECT_GE(times[slot], 0);
      EXPECT_LT(times[slot], sequence_period(info, info.cycle).count()) << info.name << slot;
    }
  }
  EXPECT_EQ(firing_times(model_info(Model::kHdl32e), Duration(46'080))[31], 35'712);
  EXPECT_EQ(firing_times(model_info(Model::kVlp16), Duration(55'296))[31], 89'856);
  // A slot of 2.665 µs; one slot is dead after eight groups.
  EXPECT_EQ(firing_times(model_info(Model::kVls128), Duration(53'300))[63], 7 * 2665);
  EXPECT_EQ(firing_times(model_info(Model::kVls128), Duration(53'300))[64], 9 * 2665);
  EXPECT_EQ(firing_times(model_info(Model::kVls128), Duration(53'300))[127], 16 * 2665);
}

}  // namespace
}  // namespace infuse::velodyne
