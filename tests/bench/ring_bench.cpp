// Operations per second of the slot ring and of alternatives. An operation is one object passed
// from the producer to one reader. `ring/slot` also serves any number of readers, which the
// baselines do not.

#include <benchmark/benchmark.h>

#include <array>
#include <boost/lockfree/spsc_queue.hpp>
#include <deque>
#include <mutex>
#include <optional>
#include <semaphore>
#include <thread>

#include "drivers/measurement/slot_ring.hpp"

namespace infuse {
namespace {

constexpr size_t kCapacity = 1024;
constexpr size_t kSlots = 8;
constexpr int kSlotBatch = 4;

/// What stands for a sweep: filling it is not what is measured.
struct Object {
  Stamp stamp;
  std::array<char, 4096> body{};
};

/// Deque of bounded length with a lock, overwrites the oldest entry.
template <class T>
class MutexDeque {
 public:
  void push(T value) {
    const std::lock_guard lock(mutex_);
    if (entries_.size() == kCapacity) entries_.pop_front();
    entries_.push_back(std::move(value));
  }
  std::optional<T> pop() {
    const std::lock_guard lock(mutex_);
    if (entries_.empty()) return std::nullopt;
    T value = std::move(entries_.front());
    entries_.pop_front();
    return value;
  }

 private:
  std::mutex mutex_;
  std::deque<T> entries_;
};

/// A thread that only sleeps: in a single-threaded process the C library's mutex does nothing.
class IdleThread {
 public:
  ~IdleThread() {
    done_.release();
    thread_.join();
  }

 private:
  std::binary_semaphore done_{0};
  std::thread thread_{[this] { done_.acquire(); }};
};

/// Writes and reads alternately, in batches, in one thread: measures the cost of the operations
/// themselves.
template <class Push, class Pop>
void run_alternating(benchmark::State& state, int batch, Push push, Pop pop) {
  const IdleThread idle_thread;
  int64_t stamp = 0;
  int64_t read = 0;
  for (auto _ : state) {
    for (int i = 0; i < batch; ++i) push(stamp++);
    while (pop()) ++read;
  }
  if (read != stamp) state.SkipWithError("entries were lost");
  state.SetItemsProcessed(read);
}

void slot(benchmark::State& state) {
  SlotRing<Object> ring(kSlots, [] { return Object(); });
  auto reader = ring.make_reader();
  run_alternating(
      state, kSlotBatch,
      [&](int64_t i) {
        ring.slot().stamp = Stamp::from_ns(i);
        ring.publish();
      },
      [&] {
        const Pin<Object> found = reader.next();
        benchmark::DoNotOptimize(&*found);
        return static_cast<bool>(found);
      });
}

/// Pool objects travel as pointers and return after they are read.
template <class Queue, class Push, class Pop>
void slot_by_pointer(benchmark::State& state, Queue& filled, Queue& empty, Push push, Pop pop) {
  std::array<Object, kSlots> pool;
  for (Object& object : pool) push(empty, &object);
  run_alternating(
      state, kSlotBatch,
      [&](int64_t i) {
        Object* object = pop(empty);
        object->stamp = Stamp::from_ns(i);
        push(filled, object);
      },
      [&] {
        Object* object = pop(filled);
        benchmark::DoNotOptimize(object);
        if (object != nullptr) push(empty, object);
        return object != nullptr;
      });
}

void slot_spsc_queue(benchmark::State& state) {
  using Queue = boost::lockfree::spsc_queue<Object*, boost::lockfree::capacity<kSlots>>;
  Queue filled, empty;
  slot_by_pointer(
      state, filled, empty, [](Queue& queue, Object* object) { queue.push(object); },
      [](Queue& queue) {
        Object* object = nullptr;
        queue.pop(object);
        return object;
      });
}

void slot_mutex_deque(benchmark::State& state) {
  using Queue = MutexDeque<Object*>;
  Queue filled, empty;
  slot_by_pointer(
      state, filled, empty, [](Queue& queue, Object* object) { queue.push(object); },
      [](Queue& queue) { return queue.pop().value_or(nullptr); });
}

BENCHMARK(slot)->Name("ring/slot");
BENCHMARK(slot_spsc_queue)->Name("ring/slot/baseline:boost_spsc_queue");
BENCHMARK(slot_mutex_deque)->Name("ring/slot/baseline:mutex_deque");

}  // namespace
}  // namespace infuse
