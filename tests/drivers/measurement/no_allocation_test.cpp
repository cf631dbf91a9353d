// Counts the heap allocations of this test program.

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "drivers/measurement/clock_model.hpp"
#include "drivers/measurement/slot_ring.hpp"
#include "drivers/measurement/sweep.hpp"

namespace {
std::atomic<uint64_t> allocations{0};

void* allocate(size_t size, size_t alignment) {
  ++allocations;
  void* memory = nullptr;
  if (posix_memalign(&memory, alignment, size) != 0) throw std::bad_alloc();
  return memory;
}
}  // namespace

void* operator new(size_t size) { return allocate(size, alignof(std::max_align_t)); }
void* operator new(size_t size, std::align_val_t alignment) {
  return allocate(size, static_cast<size_t>(alignment));
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, size_t, std::align_val_t) noexcept { std::free(memory); }

namespace infuse {
namespace {

/// Number of allocations while `work` runs.
template <class Work>
uint64_t count_allocations(Work work) {
  const uint64_t before = allocations;
  work();
  return allocations - before;
}

TEST(NoAllocation, TheCounterCounts) {
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
  const uint64_t allocated = count_allocations([&] {
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
  const uint64_t allocated = count_allocations([&] {
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
