#include "drivers/measurement/ipv4_address.hpp"

#include <arpa/inet.h>

#include <cstdio>

namespace infuse {

std::string address_text(uint32_t address) {
  // What stands for an IPv6 host: see drivers/recording/udp_decoder.hpp.
  if (address >> 28 == 0xF && address != UINT32_MAX) {
    char label[sizeof "IPv6 ...fff:ffff"];
    std::snprintf(label, sizeof label, "IPv6 ...%03x:%04x", address >> 16 & 0xFFF,
                  address & 0xFFFF);
    return label;
  }
  const in_addr network{htonl(address)};
  char text[INET_ADDRSTRLEN];
  return inet_ntop(AF_INET, &network, text, sizeof(text));
}

std::optional<uint32_t> parse_address(const std::string& text) {
  in_addr network{};
  if (inet_pton(AF_INET, text.c_str(), &network) != 1) return std::nullopt;
  return ntohl(network.s_addr);
}

}  // namespace infuse
