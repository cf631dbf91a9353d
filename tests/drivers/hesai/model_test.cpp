#include "drivers/hesai/model.hpp"

#include <gtest/gtest.h>

#include "tests/drivers/hesai/made_packet.hpp"

namespace infuse::hesai {
namespace {

TEST(HesaiModel, IsRecognisedFromAPacket) {
  for (const ModelInfo& info : models()) {
    for (const bool has_number : {false, true}) {
      const auto bytes = make_packet({.model = info.model, .has_number = has_number});
      EXPECT_EQ(recognise(bytes), info.model) << info.name;
      EXPECT_TRUE(looks_like_hesai(bytes)) << info.name;
    }
  }
}

TEST(HesaiModel, HasTheSizesOfTheManuals) {
  const auto size = [](Model model) { return make_packet({.model = model}).size(); };
  const auto size_without_number = [](Model model) {
    return make_packet({.model = model, .has_number = false}).size();
  };
  EXPECT_EQ(size_without_number(Model::kPandar40p), 1262u);
  EXPECT_EQ(size(Model::kPandar64), 1198u);
  EXPECT_EQ(size(Model::kQt64), 1072u);
  EXPECT_EQ(size(Model::kQt128), 1127u);
  EXPECT_EQ(size(Model::kXt16), 568u);
  EXPECT_EQ(size(Model::kXt32), 1080u);
  EXPECT_EQ(size(Model::kXt32m), 820u);
}

TEST(HesaiModel, IsNotRecognisedInOtherBytes) {
  EXPECT_FALSE(recognise({}));
  auto velodyne = std::vector<uint8_t>(1206);
  for (size_t block = 0; block < 12; ++block) {
    velodyne[100 * block] = 0xFF;
    velodyne[100 * block + 1] = 0xEE;
  }
  EXPECT_FALSE(recognise(velodyne));
  auto wrong_blocks = make_packet({.model = Model::kXt32});
  wrong_blocks[7] = 200;
  EXPECT_FALSE(recognise(wrong_blocks));
  EXPECT_TRUE(looks_like_hesai(wrong_blocks));
}

}  // namespace
}  // namespace infuse::hesai
