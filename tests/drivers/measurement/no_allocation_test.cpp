#include <gtest/gtest.h>

#include "drivers/measurement/clock_model.hpp"
#include "drivers/measurement/slot_ring.hpp"
#include "drivers/measurement/sweep.hpp"
#include "tests/allocation_counter.hpp"

namespace infuse {
namespace {

/// Number of allocations while `work` runs.
template <class Work>
size_t count_allocations(Work work) {
  const size_t before = allocation_count();
  work();
  return allocation_count() - before;
}

TEST(NoAllocation, CounterCounts) {
  if (!kAllocationsCounted) GTEST_SKIP() << "the sanitizer has its own allocator";
  EXPECT_GE(count_allocations([] { Sweep().reserve(1); }), 9u);
}

TEST(NoAllocation, InASlotRingOfSweeps) {
  SlotRing<Sweep> ring(4, [] {
    Sweep sweep;
    sweep.reserve(1000);
    return sweep;
  });
  auto reader = ring.make_reader();
  size_t returns = 0;
  const size_t allocated = count_allocations([&] {
    for (int64_t i = 0; i < 1000; ++i) {
      Sweep& sweep = ring.slot();
      sweep.clear();
      sweep.resize(static_cast<size_t>(i) % 1000);
      sweep.stamp = Stamp::from_ns(i);
      ring.publish();
      while (const Pin<Sweep> pin = reader.next()) returns += pin->size();
    }
  });
  EXPECT_EQ(allocated, 0u);
  EXPECT_GT(returns, 0u);
}

TEST(NoAllocation, InTheClockModel) {
  ClockModel model{{}};
  const size_t allocated = count_allocations([&] {
    for (int64_t i = 0; i < 200'000; ++i) {
      // with a jump in between
      const Duration device((i * 1'000'000 + (i > 150'000 ? 77'000'000'000 : 0)) %
                            3'600'000'000'000);
      model.update(device, Stamp::from_ns(i * 1'000'000 + i % 977));
    }
  });
  EXPECT_EQ(allocated, 0u);
  EXPECT_EQ(model.state().jumps, 1u);
}

}  // namespace
}  // namespace infuse
