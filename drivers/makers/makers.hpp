#pragma once

#include <span>
#include <string>
#include <string_view>

#include "drivers/lidar/lidar_maker.hpp"

namespace infuse::makers {

/// All makers of lidars that this program knows.
lidar::MakerList all();

/// Adds a maker that lives elsewhere, for ever: before threads start. It must outlive the program's
/// use of the list.
void add(const lidar::LidarMaker& maker);

/// Finds a model of any maker by name: see `lidar::find_model`.
const lidar::LidarModel* find_model(std::string_view name);

/// Maker and kind of a datagram's payload: see `lidar::classify`.
lidar::ClassifiedPacket classify(std::span<const uint8_t> payload);

/// The model of that name, or an error that lists those that are known. `where`: what names it.
Result<const lidar::LidarModel*> require_model(const std::string& name, const std::string& where);

/// Bytes of the longest payload of a datagram of any maker; a longer one is of nobody.
size_t max_datagram();

/// "known: HDL-32E, VLP-16, …".
std::string known_models();

}  // namespace infuse::makers
