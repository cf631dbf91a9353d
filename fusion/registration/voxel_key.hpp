#pragma once

#include <cstddef>
#include <cstdint>

namespace infuse::registration {

/// One voxel coordinate in a key: three have 63 bits.
inline constexpr int kVoxelBits = 21;
inline constexpr int32_t kVoxelOffset = 1 << (kVoxelBits - 1);

/// True if a coordinate in voxels fits into a key; false if it is not finite.
inline bool is_voxel(double coordinate) {
  return coordinate >= -kVoxelOffset + 2 && coordinate < kVoxelOffset - 2;
}

/// Largest integer not above a coordinate that fits into a key.
inline int32_t floor_to_int(double coordinate) {
  const auto whole = static_cast<int32_t>(coordinate);
  return whole - (coordinate < whole ? 1 : 0);
}

/// Number that identifies a voxel.
inline uint64_t voxel_key(int32_t x, int32_t y, int32_t z) {
  const auto bits = [](int32_t c) { return static_cast<uint64_t>(c + kVoxelOffset); };
  return bits(x) | bits(y) << kVoxelBits | bits(z) << (2 * kVoxelBits);
}

/// Coordinate of a key's voxel on axis 0, 1 or 2.
inline int32_t voxel_coordinate(uint64_t key, int axis) {
  const uint64_t bits = (key >> (axis * kVoxelBits)) & ((1U << kVoxelBits) - 1);
  return static_cast<int32_t>(bits) - kVoxelOffset;
}

/// Spreads keys over all bits (the finaliser of SplitMix64).
inline size_t voxel_hash(uint64_t key) {
  key = (key ^ (key >> 30)) * 0xbf58476d1ce4e5b9ULL;
  key = (key ^ (key >> 27)) * 0x94d049bb133111ebULL;
  return key ^ (key >> 31);
}

}  // namespace infuse::registration
