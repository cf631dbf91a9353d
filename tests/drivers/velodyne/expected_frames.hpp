#pragma once

// Real captures compared with the results of other decoders. None of the files is in the
// repository.

#include <algorithm>
#include <fstream>
#include <map>
#include <string>

#include "drivers/velodyne/model_inference.hpp"
#include "tests/pcap_packets.hpp"
#include "tests/real_data.hpp"

namespace infuse::velodyne {

inline constexpr uint16_t kDataPort = 2368;

inline std::vector<CapturedDatagram> data_packets(const std::filesystem::path& path) {
  std::vector<CapturedDatagram> packets = read_capture(path);
  std::erase_if(packets, [](const CapturedDatagram& d) { return d.port != kDataPort; });
  return packets;
}

struct ExpectedPoint {
  size_t frame, index;
  double x, y, z, reflectivity;  // vendor axes: x right, y forward
};

struct ExpectedFrames {
  size_t frames = 0;
  std::map<size_t, size_t> counts;
  std::vector<ExpectedPoint> points;
};

inline ExpectedFrames read_expected(const std::filesystem::path& path) {
  ExpectedFrames expected;
  std::ifstream in(path);
  std::string word;
  size_t frame = 0;
  while (in >> word) {
    if (word == "frame_count") in >> expected.frames;
    if (word == "frame") in >> frame;
    if (word == "point_count") in >> expected.counts[frame];
    if (word == "point_values") {
      ExpectedPoint p{frame, 0, 0, 0, 0, 0};
      double flag = 0;
      in >> p.index >> p.x >> p.y >> p.z >> p.reflectivity >> flag;
      expected.points.push_back(p);
    }
  }
  return expected;
}

}  // namespace infuse::velodyne
