#include "drivers/makers/makers.hpp"

#include <algorithm>

#include "drivers/hesai/hesai_maker.hpp"
#include "drivers/ouster/ouster_maker.hpp"
#include "drivers/robosense/robosense_maker.hpp"
#include "drivers/velodyne/velodyne_maker.hpp"

namespace infuse::makers {
namespace {

/// The list. Where packets of two makers are alike, the one whose `classify` looks at more comes
/// first.
std::vector<const lidar::LidarMaker*>& list() {
  static std::vector<const lidar::LidarMaker*> makers{&hesai::maker(), &ouster::maker(),
                                                      &robosense::maker(), &velodyne::maker()};
  return makers;
}

}  // namespace

lidar::MakerList all() { return list(); }

void add(const lidar::LidarMaker& maker) { list().push_back(&maker); }

const lidar::LidarModel* find_model(std::string_view name) {
  return lidar::find_model(all(), name);
}

lidar::ClassifiedPacket classify(std::span<const uint8_t> payload) {
  return lidar::classify(all(), payload);
}

Result<const lidar::LidarModel*> require_model(const std::string& name, const std::string& where) {
  const lidar::LidarModel* model = find_model(name);
  if (model == nullptr) return fail("unknown model '" + name + "'", where, known_models());
  return model;
}

size_t max_datagram() {
  size_t longest = 0;
  for (const lidar::LidarMaker* maker : all()) longest = std::max(longest, maker->max_datagram());
  return longest;
}

std::string known_models() {
  std::string names;
  for (const lidar::LidarMaker* maker : all()) {
    for (const lidar::LidarModel& model : maker->models()) {
      names += (names.empty() ? "known: " : ", ") + std::string(model.name);
    }
  }
  return names;
}

}  // namespace infuse::makers
