#pragma once

#include "drivers/recording/pcap_reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/drivers/recording/capture_bytes.hpp"

namespace infuse::recording::testing {

struct Received {
  int64_t ns;
  uint32_t sender;
  uint16_t port;
  Bytes payload;
};

struct PcapOutcome {
  std::vector<Received> datagrams;
  PcapCounters counters;
  std::optional<Error> damage;
};

inline PcapOutcome read_pcap(PcapReader reader) {
  PcapOutcome outcome;
  Datagram datagram;
  while (reader.next(datagram)) {
    outcome.datagrams.push_back({datagram.stamp.ns(), datagram.sender, datagram.destination_port,
                                 Bytes(datagram.payload.begin(), datagram.payload.end())});
  }
  EXPECT_FALSE(reader.next(datagram)) << "next() must keep returning false at the end";
  outcome.counters = reader.counters();
  outcome.damage = reader.damage();
  return outcome;
}

inline PcapOutcome read_pcap(const Bytes& file, const PcapOptions& options = {}) {
  auto reader = PcapReader::from_bytes(file, "test.pcap", options);
  if (!reader) {
    ADD_FAILURE() << reader.error().message();
    return {};
  }
  return read_pcap(std::move(*reader));
}

// Cuts a UDP datagram into fragments of `size` bytes (a multiple of 8).
inline std::vector<Bytes> make_fragments(const Bytes& datagram, size_t size,
                                         uint16_t identification, uint32_t sender = kSender) {
  std::vector<Bytes> result;
  for (size_t at = 0; at < datagram.size(); at += size) {
    const size_t end = std::min(at + size, datagram.size());
    result.push_back(ethernet(ipv4(Bytes(datagram.begin() + static_cast<ptrdiff_t>(at),
                                         datagram.begin() + static_cast<ptrdiff_t>(end)),
                                   {.sender = sender,
                                    .identification = identification,
                                    .offset = at,
                                    .more = end < datagram.size()})));
  }
  return result;
}

}  // namespace infuse::recording::testing
