#pragma once

#include <cstddef>
#include <cstdint>
#include <new>
#include <utility>
#include <vector>

#include "drivers/measurement/clock_state.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse {

/// Which of the echoes of one laser pulse a return is.
enum class ReturnKind : uint8_t {
  kStrongest = 0,
  kLast = 1,
  kBoth = 2,  ///< dual-return mode, and the strongest echo was also the last
};

/// Allocator whose default construction leaves memory as it is: growing an array that is about to
/// be overwritten costs nothing. Aligned to a cache line, for the vector units.
template <class T>
struct UninitializedAllocator {
  using value_type = T;
  static constexpr std::align_val_t kAlignment{64};
  UninitializedAllocator() = default;
  template <class U>
  UninitializedAllocator(const UninitializedAllocator<U>&) {}
  T* allocate(size_t n) { return static_cast<T*>(::operator new(n * sizeof(T), kAlignment)); }
  void deallocate(T* p, size_t) { ::operator delete(p, kAlignment); }
  template <class U>
  void construct(U* p) {
    ::new (static_cast<void*>(p)) U;
  }
  template <class U, class... Args>
  void construct(U* p, Args&&... args) {
    ::new (static_cast<void*>(p)) U(std::forward<Args>(args)...);
  }
  bool operator==(const UninitializedAllocator&) const { return true; }
};

/// One quantity of a sweep, an entry a return.
template <class T>
using FieldVector = std::vector<T, UninitializedAllocator<T>>;

/// A stretch of a turn from which nothing arrived. Azimuths in radians, lidar frame
/// (counter-clockwise from x), in the direction of rotation.
struct AzimuthGap {
  double from = 0;
  double to = 0;
};

/// One turn of a lidar (or the part of it that the sensor was told to look at): a structure of
/// arrays, all of length `size()`, an entry a return, in order of firing. Directions without a
/// return have no entry; `ring` and `column` say where an entry's neighbours are.
///
/// Coordinates are in the lidar frame *at the moment of each return*: nothing is corrected for
/// motion.
struct Sweep {
  Stamp stamp;                   ///< first firing
  Duration span{0};              ///< from the first firing to the last
  uint16_t rings = 0;            ///< beams of the sensor
  uint32_t columns = 0;          ///< firings in this sweep: columns are 0 … columns − 1
  bool has_times = true;         ///< false where the source has no per-return time (KITTI)
  ClockState clock;              ///< of the device, when the sweep ended
  uint32_t lost_packets = 0;     ///< data packets missing inside this sweep
  uint64_t sequence = 0;         ///< counts the sweeps of a sensor from 0
  std::vector<AzimuthGap> gaps;  ///< wider than twice the step of a firing; none in a whole turn

  FieldVector<float> x, y, z;       ///< m, lidar frame
  FieldVector<float> range;         ///< m, along the beam
  FieldVector<float> reflectivity;  ///< 0 … 1 as the sensor states it, calibrated diffuse range;
                                    ///< not a physical unit
  FieldVector<uint16_t> ring;           ///< beam, counted by elevation from below
  FieldVector<uint16_t> column;         ///< firing, counted from the sweep's first
  FieldVector<int32_t> time_offset_ns;  ///< after `stamp`
  FieldVector<ReturnKind> return_kind;

  /// Returns in the sweep.
  size_t size() const { return x.size(); }

  /// Sets the length of every array. New entries are not initialised.
  void resize(size_t returns);

  /// Makes room for `returns` so that a later `resize` up to it allocates nothing.
  void reserve(size_t returns);

  /// Empties the sweep and keeps its memory.
  void clear();
};

}  // namespace infuse
