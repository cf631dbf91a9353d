#include "drivers/lidar/losses.hpp"

#include <algorithm>

namespace infuse::lidar {

void Losses::add_missing(uint64_t packets, bool outage) {
  missing_ += packets;
  if (outage) {
    ++counters_.outages;
    missing_in_outages_ += packets;
  }
  settle();
}

void Losses::add_kernel_dropped(uint64_t datagrams, bool data) {
  counters_.lost_kernel += datagrams;
  if (data) kernel_dropped_ += datagrams;
  settle();
}

void Losses::add_filtered(uint64_t datagrams) {
  filtered_ = true;
  kernel_dropped_ += datagrams;
  settle();
}

void Losses::settle() {
  const uint64_t before_kernel = missing_ - std::min(missing_, kernel_dropped_);
  counters_.lost_network = std::max(counters_.lost_network, before_kernel);
  counters_.lost_in_outages = std::min(missing_in_outages_, counters_.lost_network);
  if (filtered_) counters_.lost_kernel = std::max(counters_.lost_kernel, missing_ - before_kernel);
}

}  // namespace infuse::lidar
