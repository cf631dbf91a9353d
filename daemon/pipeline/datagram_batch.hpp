#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "drivers/measurement/stamp.hpp"

namespace infuse::daemon {

/// Appends a datagram to a batch: its stamp, its length, its payload.
inline void append_datagram(std::vector<uint8_t>& batch, Stamp stamp,
                            std::span<const uint8_t> payload) {
  const int64_t ns = stamp.ns();
  const auto length = static_cast<uint32_t>(payload.size());
  const size_t at = batch.size();
  batch.resize(at + sizeof ns + sizeof length + payload.size());
  std::memcpy(batch.data() + at, &ns, sizeof ns);
  std::memcpy(batch.data() + at + sizeof ns, &length, sizeof length);
  if (!payload.empty())
    std::memcpy(batch.data() + at + sizeof ns + sizeof length, payload.data(), payload.size());
}

/// Calls `on_datagram(Stamp, std::span<const uint8_t>)` with the datagrams of a batch.
template <class OnDatagram>
void for_each_datagram(std::span<const uint8_t> batch, OnDatagram on_datagram) {
  int64_t ns = 0;
  uint32_t length = 0;
  while (batch.size() >= sizeof ns + sizeof length) {
    std::memcpy(&ns, batch.data(), sizeof ns);
    std::memcpy(&length, batch.data() + sizeof ns, sizeof length);
    batch = batch.subspan(sizeof ns + sizeof length);
    if (length > batch.size()) return;
    on_datagram(Stamp::from_ns(ns), batch.first(length));
    batch = batch.subspan(length);
  }
}

}  // namespace infuse::daemon
