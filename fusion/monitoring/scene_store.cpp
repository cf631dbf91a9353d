#include "fusion/monitoring/scene_store.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace infuse::monitoring {
namespace {

double mean_grey(const CameraFrame& grey) {
  uint64_t sum = 0;
  size_t count = 0;
  for (size_t i = 0; i < grey.pixels.size(); i += 7, ++count) sum += grey.pixels[i];
  return count == 0 ? 0 : static_cast<double>(sum) / static_cast<double>(count);
}

/// Copies the returns in the image or just outside of it, thinned evenly.
void copy_points(const SweepView& sweep, const MonitorPoints& points, size_t max_points,
                 StoredScene& scene) {
  const std::vector<uint32_t>& candidates = points.near_image();
  const size_t count = std::min(candidates.size(), max_points);
  for (auto* quantity : {&scene.x, &scene.y, &scene.z, &scene.reflectivity, &scene.discontinuity}) {
    quantity->resize(count);
  }
  scene.ring.resize(count);
  for (size_t k = 0; k < count; ++k) {
    const uint32_t i = candidates[k * candidates.size() / count];
    scene.x[k] = sweep.points.x[i];
    scene.y[k] = sweep.points.y[i];
    scene.z[k] = sweep.points.z[i];
    scene.reflectivity[k] = points.reflectivity()[i];
    scene.discontinuity[k] = points.discontinuity()[i];
    scene.ring[k] = sweep.ring[i];
  }
}

}  // namespace

std::optional<std::string> SceneStoreOptions::invalid() const {
  if (capacity < 3 || capacity > 200) return "capacity must lie in 3 … 200";
  if (max_points < 100) return "max_points must be at least 100";
  if (!(min_distance >= 0)) return "min_distance must not be negative";
  if (!(max_angular_rate > 0)) return "max_angular_rate must be positive";
  if (!(min_mean_grey >= 0) || !(max_mean_grey > min_mean_grey))
    return "0 <= min_mean_grey < max_mean_grey must hold";
  if (!(half_life > 0) || !(max_age > 0)) return "half_life and max_age must be positive";
  if (max_pixels < 1) return "max_pixels must be positive";
  return std::nullopt;
}

SceneStore::SceneStore(const SceneStoreOptions& options) : options_(options) {
  slots_.resize(options.capacity);
}

double SceneStore::decayed_information(const StoredScene& scene, Stamp now) const {
  return scene.information *
         std::exp(-std::numbers::ln2 * to_seconds(now - scene.stamp) / options_.half_life);
}

StoredScene* SceneStore::slot_for(double information, Stamp now) {
  if (used_ < slots_.size()) return &slots_[used_++];
  const auto minimum =
      std::min_element(slots_.begin(), slots_.end(), [&](const auto& a, const auto& b) {
        return decayed_information(a, now) < decayed_information(b, now);
      });
  return decayed_information(*minimum, now) < information ? &*minimum : nullptr;
}

bool SceneStore::offer(const CameraFrame& grey, const SweepView& sweep, const MonitorPoints& points,
                       double information, double travelled, double angular_rate) {
  remove_before(grey.stamp - from_seconds(options_.max_age));
  if (!(information > 0) || travelled - last_travelled_ < options_.min_distance ||
      angular_rate > options_.max_angular_rate ||
      grey.pixels.size() > static_cast<size_t>(options_.max_pixels)) {
    return false;
  }
  const double level = mean_grey(grey);
  if (level < options_.min_mean_grey || level > options_.max_mean_grey) return false;
  StoredScene* scene = slot_for(information, grey.stamp);
  if (scene == nullptr) return false;
  scene->stamp = grey.stamp;
  scene->information = information;
  scene->grey = grey;
  copy_points(sweep, points, options_.max_points, *scene);
  last_travelled_ = travelled;
  return true;
}

void SceneStore::remove_before(Stamp stamp) {
  for (size_t i = 0; i < used_;) {
    if (slots_[i].stamp < stamp) {
      std::swap(slots_[i], slots_[--used_]);
    } else {
      ++i;
    }
  }
}

size_t SceneStore::count_since(Stamp stamp) const {
  return static_cast<size_t>(
      std::count_if(slots_.begin(), slots_.begin() + static_cast<ptrdiff_t>(used_),
                    [&](const StoredScene& scene) { return scene.stamp >= stamp; }));
}

void SceneStore::copy(Stamp since, std::vector<StoredScene>& out) const {
  out.resize(count_since(since));
  size_t next = 0;
  for (size_t i = 0; i < used_; ++i) {
    if (slots_[i].stamp >= since) out[next++] = slots_[i];
  }
  std::sort(out.begin(), out.end(),
            [](const StoredScene& a, const StoredScene& b) { return a.stamp < b.stamp; });
}

}  // namespace infuse::monitoring
