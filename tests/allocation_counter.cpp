#include "tests/allocation_counter.hpp"

#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <new>

namespace {

std::atomic<size_t> count{0};
std::atomic<size_t> streaming_count{0};
std::atomic<bool> streaming_counted{false};  // reading a thread's name is a system call

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

bool is_streaming_thread() {
  thread_local bool known = false;
  if (known) return true;
  char name[16] = {};
  pthread_getname_np(pthread_self(), name, sizeof(name));
  known = std::strcmp(name, "io") == 0 || std::strcmp(name, "fusion") == 0;
  return known;
}

void* allocate(size_t size, size_t alignment) noexcept {
  ++count;
  if (streaming_counted && is_streaming_thread()) ++streaming_count;
  const size_t rounded = (size + alignment - 1) / alignment * alignment;
  return std::aligned_alloc(alignment, std::max(rounded, alignment));
}

void* allocate_or_throw(size_t size, size_t alignment) {
  void* memory = allocate(size, alignment);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

#endif

}  // namespace

namespace infuse {
size_t allocation_count() { return count; }
size_t streaming_allocation_count() {
  streaming_counted = true;
  return streaming_count;
}
}  // namespace infuse

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
// The array forms call these.
void* operator new(size_t size) { return allocate_or_throw(size, alignof(std::max_align_t)); }
void* operator new(size_t size, std::align_val_t alignment) {
  return allocate_or_throw(size, static_cast<size_t>(alignment));
}
void* operator new(size_t size, const std::nothrow_t&) noexcept {
  return allocate(size, alignof(std::max_align_t));
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, size_t, std::align_val_t) noexcept { std::free(memory); }
#endif
