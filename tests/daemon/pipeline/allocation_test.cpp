// After warm-up the streaming threads allocate nothing: a replay of 20 s allocates on them as often
// as one of 12 s.

#include <gtest/gtest.h>

#include "drivers/velodyne/velodyne_maker.hpp"
#include "fixtures/scene/capture.hpp"
#include "tests/allocation_counter.hpp"
#include "tests/daemon/pipeline/run_replay.hpp"

namespace infuse::daemon {
namespace {

size_t count_allocations(velodyne::Model model, double seconds) {
  const TemporaryFolder folder;
  fixtures::CaptureOptions options;
  options.model = &velodyne::lidar_model(model);
  options.duration = from_seconds(seconds);
  options.loss = 0.01;
  EXPECT_TRUE(fixtures::make_capture(folder / "x.pcap", options));
  const size_t before = streaming_allocation_count();
  const auto result = run_replay(folder / "x.pcap");
  EXPECT_TRUE(result);
  EXPECT_GT(result->totals.counters.lidars.at(0).sweeps, static_cast<uint64_t>(seconds) * 9);
  return streaming_allocation_count() - before;
}

TEST(Allocation, NoneOnTheStreamingPathAfterWarmUp) {
  if (!kAllocationsCounted) GTEST_SKIP() << "the sanitizer has its own allocator";
  for (const auto model : {velodyne::Model::kHdl32e, velodyne::Model::kVlp16}) {
    // Warm-up ends when every slot of the ring has held a sweep; items of samples lie between them.
    const size_t brief = count_allocations(model, 12);
    EXPECT_GT(brief, 0U) << "warm-up allocates";
    // How many slots the warm-up uses depends on the threads' timing; an allocation for every sweep
    // would be 80 more.
    EXPECT_LT(count_allocations(model, 20), brief + 40);
  }
}

}  // namespace
}  // namespace infuse::daemon
