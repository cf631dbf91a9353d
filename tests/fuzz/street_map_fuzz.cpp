// A street map file: bytes with a mended checksum, then look-ups all over it.

#include <zlib.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "fusion/streetmap/segment_map.hpp"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  std::vector<std::byte> bytes(size);
  if (size > 0) std::memcpy(bytes.data(), data, size);
  if (size >= 96) {
    std::memset(bytes.data() + 88, 0, 8);
    const uint64_t sum = crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), size);
    std::memcpy(bytes.data() + 88, &sum, 8);
  }
  const auto map = infuse::streetmap::SegmentMap::open(bytes, "fuzz");
  if (!map) return 0;
  std::vector<uint32_t> ids(100);
  for (int row = -1; row <= map->rows(); row += 7) {
    map->read_row(row * 3, row, ids);
    for (int column = -1; column <= map->columns() && column < 4096; column += 5) {
      map->segment(map->id_of_cell(column, row));
    }
  }
  return 0;
}
