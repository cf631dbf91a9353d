// The io and fusion threads do not allocate after warm-up: a replay of 12 s allocates on them as
// often as one of 4 s.

#include <gtest/gtest.h>
#include <pthread.h>

#include <atomic>
#include <cstdlib>
#include <cstring>
#include <new>

#include "fixtures/scene/capture.hpp"
#include "tests/daemon/pipeline/run_replay.hpp"

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

namespace {

std::atomic<uint64_t> streaming_allocations{0};

/// Returns true on the io thread and the fusion thread.
bool is_streaming_thread() {
  thread_local bool known = false;
  if (known) return true;
  char name[16] = {};
  pthread_getname_np(pthread_self(), name, sizeof(name));
  known = std::strcmp(name, "io") == 0 || std::strcmp(name, "fusion") == 0;
  return known;
}

void* allocate(std::size_t size, std::size_t alignment) {
  if (is_streaming_thread()) streaming_allocations.fetch_add(1);
  const std::size_t rounded = (size + alignment - 1) / alignment * alignment;
  void* memory = std::aligned_alloc(alignment, rounded == 0 ? alignment : rounded);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

void* operator new(std::size_t size) { return allocate(size, alignof(std::max_align_t)); }
void* operator new[](std::size_t size) { return allocate(size, alignof(std::max_align_t)); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return allocate(size, static_cast<std::size_t>(alignment));
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return allocate(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

namespace infuse::daemon {
namespace {

uint64_t count_allocations(velodyne::Model model, double seconds) {
  const TemporaryFolder folder;
  fixtures::CaptureOptions options;
  options.model = model;
  options.duration = from_seconds(seconds);
  options.loss = 0.01;
  EXPECT_TRUE(fixtures::make_capture(folder / "x.pcap", options));
  const uint64_t before = streaming_allocations;
  const auto result = run_replay(folder / "x.pcap");
  EXPECT_TRUE(result);
  EXPECT_GT(result->totals.counters.at(0).sweeps, static_cast<uint64_t>(seconds) * 9);
  return streaming_allocations - before;
}

TEST(Allocation, NoneOnTheStreamingPathAfterWarmUp) {
  for (const auto model : {velodyne::Model::kHdl32e, velodyne::Model::kVlp16}) {
    const uint64_t brief = count_allocations(model, 4);
    EXPECT_GT(brief, 0U);  // warm-up allocates, and is counted
    EXPECT_EQ(count_allocations(model, 12), brief);
  }
}

}  // namespace
}  // namespace infuse::daemon

#endif
