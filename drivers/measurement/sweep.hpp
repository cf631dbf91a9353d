#pragma once

#include <cstddef>
#include <cstdint>
#include <new>
#include <utility>
#include <vector>

#include "drivers/measurement/clock_state.hpp"
#include "drivers/measurement/stamp.hpp"

namespace infuse {

/// Echo of a laser pulse that a return is.
enum class ReturnKind : uint8_t {
  kStrongest = 0,
  kLast = 1,
  kBoth = 2,  ///< mode of several returns, and two of them are one echo: the strongest is the last
  kFirst = 3,
  kSecond = 4,           ///< the one after the first
  kSecondStrongest = 5,  ///< the next weaker one after the strongest
};
/// Number of kinds.
inline constexpr int kReturnKinds = 6;

/// Allocator whose default construction leaves memory uninitialised, so that growing an array that
/// is about to be overwritten costs nothing. Aligned to a cache line, for vector instructions.
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

/// One quantity of a sweep, one entry per return.
template <class T>
using FieldVector = std::vector<T, UninitializedAllocator<T>>;

/// Azimuth range of a turn from which no data arrived. Azimuths in radians, lidar frame
/// (counter-clockwise from x), in the direction of rotation.
struct AzimuthGap {
  double from = 0;  ///< rad
  double to = 0;    ///< rad
};

/// One turn of a lidar (or the part of it that the sensor is configured to scan): a structure of
/// arrays, all of length `size()`, one entry per return, in order of firing. Directions without a
/// return have no entry; `ring` and `column` identify an entry's neighbours.
///
/// Coordinates are in the lidar frame *at the moment of each return*: the sweep is not deskewed,
/// unless its source has done so (`deskewed`).
struct Sweep {
  Stamp stamp;                ///< first firing
  Duration span{0};           ///< from the first firing to the last
  uint16_t rings = 0;         ///< number of beams of the sensor
  uint32_t columns = 0;       ///< number of firings in this sweep: columns are 0 … columns − 1
  bool has_times = true;      ///< false if the times of the returns are not known
  bool deskewed = false;      ///< by the source: all returns are as of one time, their offset
  ClockState clock;           ///< state of the device's clock at the end of the sweep
  uint32_t lost_packets = 0;  ///< number of data packets missing inside this sweep
  uint64_t sequence = 0;      ///< number of the sweep, counted from 0 for each sensor
  std::vector<AzimuthGap>
      gaps;  ///< wider than twice the azimuth step of a firing; empty for a whole turn

  FieldVector<float> x, y, z;       ///< m, lidar frame
  FieldVector<float> range;         ///< m, along the beam
  FieldVector<float> reflectivity;  ///< 0 … 1 as the sensor reports it, calibrated diffuse range;
                                    ///< not a physical unit
  FieldVector<uint16_t> ring;       ///< number of the beam by elevation, counted from below
  FieldVector<uint16_t> column;     ///< number of the firing, counted from the sweep's first
  FieldVector<int32_t> time_offset_ns;  ///< after `stamp`
  FieldVector<ReturnKind> return_kind;  ///< which of the beam's echoes

  /// Number of returns in the sweep.
  size_t size() const { return x.size(); }

  /// Sets the length of every array. New entries are not initialised.
  void resize(size_t returns);

  /// Allocates memory for `returns` entries, so that a later `resize` up to it allocates nothing.
  void reserve(size_t returns);

  /// Removes all returns and keeps the memory.
  void clear();
};

}  // namespace infuse
