#include <gtest/gtest.h>

#include <array>

#include "drivers/velodyne/decoder.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"
#include "tests/allocation_counter.hpp"
#include "tests/drivers/velodyne/oracle.hpp"

namespace infuse::velodyne {
namespace {

TEST(Streaming, AllocatesNothingAfterTheFirstSweeps) {
  for (const Model model : {Model::kHdl32e, Model::kVlp16, Model::kHdl64eS3}) {
    Scene scene =
        make_scene({.model = model, .turns = 7, .calibration = built_in_calibration(model)});
    // One of every kind of disturbance.
    for (size_t i = 100; i < scene.packets.size(); i += 50) {
      scene.packets[i].payload[i % 1200] ^= 0x55;
      scene.packets[i + 3] = scene.packets[i + 2];
    }
    Decoder decoder({.model = &lidar_model(model)});
    std::array<Sweep, 2> slots;  // as in a ring: each grows once
    size_t sweeps = 0;
    size_t warm = 0;
    for (const SentPacket& packet : scene.packets) {
      decoder.push(packet.datagram());
      while (decoder.pull(slots[sweeps % 2])) {
        if (++sweeps == 4) warm = allocation_count();
      }
    }
    ASSERT_GE(sweeps, 6U);
    if (kAllocationsCounted) {
      EXPECT_GT(warm, 0U);
    }
    EXPECT_EQ(allocation_count(), warm) << model_info(model).name;
  }
}

}  // namespace
}  // namespace infuse::velodyne
