#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/measurement/camera_frame.hpp"
#include "fusion/monitoring/monitor_view.hpp"

namespace infuse::monitoring {

/// Image and the returns in and around its view, stored for a re-estimation.
struct StoredScene {
  Stamp stamp;
  double information = 0;  ///< information of its evaluation, 0 … 1
  CameraFrame grey;        ///< means of `step` × `step` pixels
  int step = 1;
  std::vector<float> x, y, z;        ///< m, lidar frame at the exposure
  std::vector<float> reflectivity;   ///< `features::RelativeReflectivity`
  std::vector<float> discontinuity;  ///< `features::Discontinuity`, √m; NaN: not compared
  std::vector<uint16_t> ring;
};

/// Settings of the choice of scenes.
struct SceneStoreOptions {
  size_t capacity = 36;        ///< maximum number of scenes; P 3.4.1.3: 10 to 20 are needed
  size_t max_points = 20'000;  ///< maximum number of a scene
  double min_distance = 8;     ///< m driven between two scenes: views of one place share a bias
  double max_angular_rate =
      0.25;  ///< rad/s; faster rotations blur the image and amplify errors of the stamps
  double min_mean_grey = 20,
         max_mean_grey = 235;  ///< range of the mean grey level of a well exposed image
  double half_life = 120;      ///< s; age at which the information of a scene counts half
  double max_age = 600;        ///< s; older scenes are removed
  /// Maximum number of pixels of a stored image; larger ones are reduced by whole steps. A
  /// re-estimation takes 4 bytes for each pixel of its scenes (accuracy.md): 1280 × 1024.
  int max_pixels = 1'310'720;

  /// What is wrong with the settings, or nothing.
  std::optional<std::string> invalid() const;
};

/// Bounded set of informative scenes, spread over time: a new one replaces the least informative
/// one. Deterministic; memory is allocated by the first scenes and reused after that. Scenes are
/// lent to a re-estimation on another thread, not copied: until it is over, others take no place of
/// theirs.
class SceneStore {
 public:
  /// `options.invalid()` must be empty.
  explicit SceneStore(const SceneStoreOptions& options);

  /// Offers a scene; returns true if it is stored. `information`: of its evaluation, 0 … 1;
  /// `travelled`: m driven since the beginning; `angular_rate`: rad/s.
  bool offer(const CameraFrame& grey, const SweepView& sweep, const MonitorPoints& points,
             double information, double travelled, double angular_rate);

  /// Removes scenes that are older than the stamp, but those lent.
  void remove_before(Stamp stamp);

  /// Number of scenes that are not older than the stamp.
  size_t count_since(Stamp stamp) const;

  /// Lends the scenes that are not older than the stamp, oldest first: they stay as they are until
  /// `end_lending`.
  std::vector<const StoredScene*> lend(Stamp since);

  /// Ends the lending; the scenes are no longer used by who had them.
  void end_lending();

  size_t size() const { return used_; }

 private:
  /// A place for a scene, which does not move.
  struct Slot {
    std::unique_ptr<StoredScene> scene = std::make_unique<StoredScene>();
    bool lent = false;
  };
  double decayed_information(const Slot& slot, Stamp now) const;
  StoredScene* slot_for(double information, Stamp now);

  SceneStoreOptions options_;
  std::vector<Slot> slots_;
  size_t used_ = 0;
  double last_travelled_ = -1e9;
};

}  // namespace infuse::monitoring
