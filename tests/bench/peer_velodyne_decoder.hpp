#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace infuse::bench {

/// Decodes the packets of an HDL-32E in a pcap of Ethernet and UDP to sweeps by velodyne_decoder;
/// returns the number of returns.
size_t decode_by_peer(std::span<const uint8_t> pcap);

}  // namespace infuse::bench
