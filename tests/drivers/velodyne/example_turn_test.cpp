#include "drivers/velodyne/example_turn.hpp"

#include <gtest/gtest.h>

#include "drivers/velodyne/packet.hpp"

namespace infuse::velodyne {
namespace {

TEST(ExampleTurn, IsOfPacketsOfItsModel) {
  for (const ModelInfo& info : models()) {
    if (info.banks > 1) continue;
    for (const uint32_t index : {0U, 1U, 75U, 1'000'000U}) {
      const auto packet = parse_packet(info, example_packet(info, index, 10));
      ASSERT_TRUE(packet) << info.name << " " << index;
      EXPECT_FALSE(packet->dual());
    }
  }
}

}  // namespace
}  // namespace infuse::velodyne
