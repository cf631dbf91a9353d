#include "drivers/camera/stamp_delay.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace infuse::camera {
namespace {

using std::chrono::milliseconds;

TEST(StampDelay, SubtractsConstantAndTransferTime) {
  const StampDelay delay{.constant = milliseconds(5), .bandwidth_bytes_s = 100e6};
  const Stamp stamped = Stamp::from_ns(1'000'000'000);
  EXPECT_EQ(stamped - delay.exposure_stamp(stamped, 2'000'000), milliseconds(25));
  EXPECT_EQ(StampDelay{}.exposure_stamp(stamped, 2'000'000), stamped);
}

TEST(StampDelay, RefusesImpossibleNumbers) {
  EXPECT_FALSE(StampDelay{}.invalid());
  EXPECT_TRUE(StampDelay{.bandwidth_bytes_s = -1}.invalid());
  EXPECT_TRUE(StampDelay{.bandwidth_bytes_s = std::numeric_limits<double>::quiet_NaN()}.invalid());
  EXPECT_TRUE(StampDelay{.constant = std::chrono::seconds(11)}.invalid());
}

}  // namespace
}  // namespace infuse::camera
