#include "drivers/measurement/ipv4_address.hpp"

#include <arpa/inet.h>

namespace infuse {

std::string address_text(uint32_t address) {
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
