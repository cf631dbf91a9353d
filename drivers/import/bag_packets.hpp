#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string_view>

#include "drivers/import/bag.hpp"

namespace infuse::importers {

/// True if messages of this type hold packets of a lidar, one or those of a turn: as drivers of
/// Velodyne, Hesai, RoboSense and Ouster publish them.
bool holds_packets(std::string_view type);

/// Calls `on_packet` for each packet of a message of such a type, with the packet's stamp, else the
/// header's, else the message's log time. False: the message is not of its type, or cut.
bool read_packets(const BagMessage& message,
                  const std::function<void(Stamp, std::span<const uint8_t>)>& on_packet);

}  // namespace infuse::importers
