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

/// Step of a reduction to at most so many pixels.
int reduction_to(size_t pixels, size_t max_pixels) {
  int step = 1;
  while (pixels / (static_cast<size_t>(step) * static_cast<size_t>(step)) > max_pixels) ++step;
  return step;
}

/// Means of `step` × `step` pixels.
void reduce(const CameraFrame& grey, int step, CameraFrame& out) {
  out.stamp = grey.stamp;
  out.format = grey.format;
  out.width = grey.width / step;
  out.height = grey.height / step;
  out.pixels.resize(static_cast<size_t>(out.width) * static_cast<size_t>(out.height));
  const int count = step * step;
  for (int v = 0; v < out.height; ++v) {
    for (int u = 0; u < out.width; ++u) {
      int sum = count / 2;
      for (int dv = 0; dv < step; ++dv) {
        const uint8_t* pixel = grey.pixels.data() +
                               static_cast<size_t>(v * step + dv) * grey.row_bytes() +
                               static_cast<size_t>(u) * static_cast<size_t>(step);
        for (int du = 0; du < step; ++du) sum += pixel[du];
      }
      out.pixels[static_cast<size_t>(v) * static_cast<size_t>(out.width) + static_cast<size_t>(u)] =
          static_cast<uint8_t>(sum / count);
    }
  }
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
  if (capacity < 3 || capacity > 200) return "capacity must be between 3 and 200";
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

double SceneStore::decayed_information(const Slot& slot, Stamp now) const {
  return slot.scene->information *
         std::exp(-std::numbers::ln2 * to_seconds(now - slot.scene->stamp) / options_.half_life);
}

StoredScene* SceneStore::slot_for(double information, Stamp now) {
  if (used_ < slots_.size()) return slots_[used_++].scene.get();
  const auto minimum =
      std::min_element(slots_.begin(), slots_.end(), [&](const Slot& a, const Slot& b) {
        if (a.lent != b.lent) return b.lent;
        return decayed_information(a, now) < decayed_information(b, now);
      });
  const bool free = !minimum->lent && decayed_information(*minimum, now) < information;
  return free ? minimum->scene.get() : nullptr;
}

bool SceneStore::offer(const CameraFrame& grey, const SweepView& sweep, const MonitorPoints& points,
                       double information, double travelled, double angular_rate) {
  remove_before(grey.stamp - from_seconds(options_.max_age));
  if (!(information > 0) || travelled - last_travelled_ < options_.min_distance ||
      angular_rate > options_.max_angular_rate) {
    return false;
  }
  const double level = mean_grey(grey);
  if (level < options_.min_mean_grey || level > options_.max_mean_grey) return false;
  StoredScene* scene = slot_for(information, grey.stamp);
  if (scene == nullptr) return false;
  scene->stamp = grey.stamp;
  scene->information = information;
  scene->step = reduction_to(grey.pixels.size(), static_cast<size_t>(options_.max_pixels));
  reduce(grey, scene->step, scene->grey);
  copy_points(sweep, points, options_.max_points, *scene);
  last_travelled_ = travelled;
  return true;
}

void SceneStore::remove_before(Stamp stamp) {
  for (size_t i = 0; i < used_;) {
    if (slots_[i].scene->stamp < stamp && !slots_[i].lent) {
      std::swap(slots_[i], slots_[--used_]);
    } else {
      ++i;
    }
  }
}

size_t SceneStore::count_since(Stamp stamp) const {
  return static_cast<size_t>(
      std::count_if(slots_.begin(), slots_.begin() + static_cast<ptrdiff_t>(used_),
                    [&](const Slot& slot) { return slot.scene->stamp >= stamp; }));
}

std::vector<const StoredScene*> SceneStore::lend(Stamp since) {
  std::vector<const StoredScene*> lent;
  for (size_t i = 0; i < used_; ++i) {
    slots_[i].lent = slots_[i].scene->stamp >= since;
    if (slots_[i].lent) lent.push_back(slots_[i].scene.get());
  }
  std::sort(lent.begin(), lent.end(),
            [](const StoredScene* a, const StoredScene* b) { return a->stamp < b->stamp; });
  return lent;
}

void SceneStore::end_lending() {
  for (Slot& slot : slots_) slot.lent = false;
}

}  // namespace infuse::monitoring
