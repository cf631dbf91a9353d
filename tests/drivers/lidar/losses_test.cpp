#include "drivers/lidar/losses.hpp"

#include <gtest/gtest.h>

namespace infuse::lidar {
namespace {

TEST(Losses, WhatTheKernelDroppedIsNotLostInTheNetwork) {
  PacketCounters counters;
  Losses losses(counters);
  losses.add_kernel_dropped(30, true);
  losses.add_missing(50, true);
  EXPECT_EQ(counters.lost_network, 20U);
  EXPECT_EQ(counters.lost_kernel, 30U);
  EXPECT_EQ(counters.outages, 1U);
  EXPECT_EQ(counters.lost_in_outages, 20U);
  // Drops of position packets are not missing in the data packets.
  losses.add_kernel_dropped(5, false);
  losses.add_missing(5, false);
  EXPECT_EQ(counters.lost_network, 25U);
  EXPECT_EQ(counters.lost_kernel, 35U);
  EXPECT_EQ(counters.lost_in_outages, 25U);
}

TEST(Losses, AFilterDropsDatagramsOfOthersToo) {
  PacketCounters counters;
  Losses losses(counters);
  losses.add_filtered(1000);  // a flood
  EXPECT_EQ(counters.lost_kernel, 0U);
  losses.add_missing(7, false);
  EXPECT_EQ(counters.lost_kernel, 7U);
  EXPECT_EQ(counters.lost_network, 0U);
}

TEST(Losses, NeverShrink) {
  PacketCounters counters;
  Losses losses(counters);
  losses.add_missing(10, false);
  losses.add_kernel_dropped(10, true);
  EXPECT_EQ(counters.lost_network, 10U);
}

}  // namespace
}  // namespace infuse::lidar
