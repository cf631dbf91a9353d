#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/camera_frame.hpp"
#include "fusion/monitoring/monitor_view.hpp"

namespace infuse::monitoring {

/// A picture and the returns around its view, kept for a later re-estimation.
struct StoredScene {
  Stamp stamp;
  double information = 0;  ///< information that its look brought, 0 … 1
  CameraFrame grey;
  std::vector<float> x, y, z;        ///< m, lidar frame at the exposure
  std::vector<float> reflectivity;   ///< relative, `features::RelativeReflectivity`
  std::vector<float> discontinuity;  ///< √m, or not compared
  std::vector<uint16_t> ring;
};

/// How scenes are chosen and forgotten.
struct SceneStoreOptions {
  size_t capacity = 36;        ///< P 3.4.1.3: 10 to 20 are needed, of a large picture
  size_t max_points = 20'000;  ///< of a scene
  double min_distance = 8;     ///< m driven between two scenes: views of one place share its bias
  double max_angular_rate = 0.25;  ///< rad/s; above it, stamps and exposure smear
  double min_mean_grey = 20,
         max_mean_grey = 235;  ///< mean grey level outside of which exposure failed
  double half_life = 120;      ///< s; a scene so old is worth half
  double max_age = 600;        ///< s; older scenes are forgotten
  int max_pixels = 4'000'000;  ///< of a picture

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// A bounded set of informative scenes, spread over time: a new one takes the place of what is
/// worth least by now. Deterministic; its memory is taken as the first scenes come and then reused.
class SceneStore {
 public:
  /// `options.invalid()` must be empty.
  explicit SceneStore(const SceneStoreOptions& options);

  /// Offers a scene; true where it was kept. `worth`: what the watch learned from it, 0 … 1;
  /// `travelled`: m driven since the beginning; `angular_rate`: rad/s.
  bool offer(const CameraFrame& grey, const SweepView& sweep, const MonitorPoints& points,
             double information, double travelled, double angular_rate);

  /// Forgets scenes that are older than the stamp.
  void remove_before(Stamp stamp);

  /// How many scenes are not older than the stamp.
  size_t count_since(Stamp stamp) const;

  /// Copies the scenes that are not older than the stamp, oldest first; `out` keeps its memory.
  void copy(Stamp since, std::vector<StoredScene>& out) const;

  size_t size() const { return used_; }

 private:
  double decayed_information(const StoredScene& scene, Stamp now) const;
  StoredScene* slot_for(double information, Stamp now);

  SceneStoreOptions options_;
  std::vector<StoredScene> slots_;
  size_t used_ = 0;
  double last_travelled_ = -1e9;
};

}  // namespace infuse::monitoring
