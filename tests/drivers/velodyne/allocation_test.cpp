// Counts calls of operator new in this program.

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "drivers/velodyne/sweep_assembler.hpp"
#include "tests/drivers/velodyne/oracle.hpp"

namespace {
std::atomic<size_t> allocations{0};

void* allocate(size_t size, size_t alignment) {
  ++allocations;
  void* memory = std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  if (memory == nullptr) throw std::bad_alloc();
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
    SweepAssembler assembler({.model = model});
    std::array<Sweep, 2> slots;  // as in a ring: each grows once
    size_t sweeps = 0;
    size_t warm = 0;
    for (const SentPacket& packet : scene.packets) {
      assembler.push(packet.datagram());
      while (assembler.pull(slots[sweeps % 2])) {
        if (++sweeps == 4) warm = allocations;
      }
    }
    ASSERT_GE(sweeps, 6U);
    EXPECT_GT(warm, 0U);
    EXPECT_EQ(allocations, warm) << model_info(model).name;
  }
}

}  // namespace
}  // namespace infuse::velodyne
