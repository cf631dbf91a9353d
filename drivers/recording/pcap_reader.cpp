#include "drivers/recording/pcap_reader.hpp"

#include <pcap/pcap.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "drivers/recording/decompress.hpp"
#include "drivers/recording/link_layer.hpp"
#include "drivers/recording/record_scan.hpp"
#include "drivers/recording/steady_stamps.hpp"
#include "drivers/recording/udp_decoder.hpp"
#include "drivers/text/text_file.hpp"

namespace infuse::recording {
namespace {

constexpr size_t kFileBufferBytes = 1 << 18;

// Saturates: the seconds of a damaged file can have any value.
Stamp to_stamp(const timeval& time) {
  int64_t ns = 0;
  if (__builtin_mul_overflow(static_cast<int64_t>(time.tv_sec), int64_t{1'000'000'000}, &ns)) {
    return time.tv_sec > 0 ? Stamp::latest() : Stamp::earliest();
  }
  return Stamp::from_ns(ns) + Duration(time.tv_usec);  // nanoseconds, as requested when opening
}

bool passes(const std::vector<uint16_t>& ports, uint16_t port) {
  return ports.empty() || std::find(ports.begin(), ports.end(), port) != ports.end();
}

bool passes(const std::vector<uint32_t>& senders, uint32_t sender) {
  return senders.empty() || std::find(senders.begin(), senders.end(), sender) != senders.end();
}

}  // namespace

std::optional<std::string> PcapOptions::invalid() const {
  if (max_fragmented_datagrams > 1024) return "max_fragmented_datagrams must be at most 1024";
  if (fragment_timeout < Duration::zero()) return "fragment_timeout must not be negative";
  return std::nullopt;
}

struct PcapReader::State {
  State(std::string file_name, PcapOptions filter, pcap_t* handle,
        std::unique_ptr<char[]> file_buffer)
      : name(std::move(file_name)),
        options(std::move(filter)),
        buffer(std::move(file_buffer)),
        pcap(handle),
        decoder(pcap_datalink(handle), options.max_fragmented_datagrams, options.fragment_timeout) {
  }
  ~State() { pcap_close(pcap); }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  static Result<PcapReader> make(FILE* file, const std::string& name, const PcapOptions& options);
  bool resume_reading();
  void stop_reading(int status);
  void count_outcome(FrameOutcome outcome);

  std::string name;
  PcapOptions options;
  std::unique_ptr<char[]> buffer;  // of the FILE inside `pcap`
  pcap_t* pcap;
  UdpDecoder decoder;
  PcapCounters counters;
  SteadyStamps stamps;
  std::optional<RecordScan> scan;  // nothing: the file has no records that could be found again
  bool ended = false;
  int64_t offset = 0;          // of the next packet
  uint64_t first_skipped = 0;  // number of the packet before which bytes were skipped first
  std::optional<Error> damage;
};

Result<PcapReader> PcapReader::State::make(FILE* file, const std::string& name,
                                           const PcapOptions& options) {
  if (const char* unpack = unknown_compression(file)) {
    std::fclose(file);
    return fail("is compressed in a way that is not read", name,
                std::string("unpack it first: ") + unpack);
  }
  file = decompress(file);
  if (file == nullptr) return fail("out of memory", name);
  auto buffer = std::make_unique_for_overwrite<char[]>(kFileBufferBytes);
  std::setvbuf(file, buffer.get(), _IOFBF, kFileBufferBytes);
  std::array<char, PCAP_ERRBUF_SIZE> reason{};
  pcap_t* pcap =
      pcap_fopen_offline_with_tstamp_precision(file, PCAP_TSTAMP_PRECISION_NANO, reason.data());
  if (pcap == nullptr) {
    std::fclose(file);
    return fail("cannot be read as pcap or pcapng: " + std::string(reason.data()), name,
                "expected a capture as written by tcpdump or Wireshark");
  }
  auto state = std::make_unique<State>(name, options, pcap, std::move(buffer));
  const int link_type = pcap_datalink(pcap);
  if (!is_supported_link_type(link_type)) {
    const char* link_name = pcap_datalink_val_to_name(link_type);
    return fail("link type " + std::to_string(link_type) + " (" +
                    (link_name != nullptr ? link_name : "unknown") + ") is not supported",
                name, "supported: Ethernet, Linux cooked, raw IP, BSD loopback");
  }
  state->offset = ftello(file);
  state->scan = RecordScan::of(file);
  return PcapReader(std::move(state));
}

/// Goes on at the next record that is one, after a record whose length cannot be.
bool PcapReader::State::resume_reading() {
  if (!scan || offset < 0) return false;
  const auto found = scan->find_next(pcap_file(pcap), offset);
  if (!found) return false;
  if (counters.skipped_bytes == 0) first_skipped = counters.packets + 1;
  counters.skipped_bytes += static_cast<uint64_t>(*found - offset);
  offset = *found;
  return true;
}

void PcapReader::State::stop_reading(int status) {
  ended = true;
  decoder.finish();
  if (status == PCAP_ERROR_BREAK) return;  // the end of the file
  const uint64_t number = counters.packets + 1;
  const std::string reason = pcap_geterr(pcap);
  const bool interfaces = reason.find("type of the first interface") != std::string::npos;
  damage = Error{
      "the capture cannot be read beyond packet " + std::to_string(counters.packets) + ": " +
          reason,
      name + ", packet " + std::to_string(number) +
          (offset >= 0 ? ", byte " + std::to_string(offset) : std::string()),
      interfaces
          ? "it was recorded at interfaces of different kinds: extract one, tshark -r FILE -Y "
            "'frame.interface_id == 0' -w ONE"
          : "earlier packets were read; the file was probably truncated while being written "
            "or copied"};
}

void PcapReader::State::count_outcome(FrameOutcome outcome) {
  switch (outcome) {
    case FrameOutcome::kIpv6:
      ++counters.ipv6;
      break;
    case FrameOutcome::kNotUdp:
      ++counters.not_udp;
      break;
    case FrameOutcome::kTruncated:
      ++counters.truncated;
      break;
    case FrameOutcome::kMalformed:
      ++counters.malformed;
      break;
    case FrameOutcome::kDatagram:
    case FrameOutcome::kFragment:
      break;
  }
}

Result<PcapReader> PcapReader::open(const std::filesystem::path& path, const PcapOptions& options) {
  if (const auto wrong = options.invalid()) return fail(*wrong, "PcapOptions");
  auto file = text::open_regular_file(path);
  if (!file) return tl::unexpected(file.error());
  return State::make(file->release(), path.string(), options);
}

Result<PcapReader> PcapReader::from_bytes(std::span<const uint8_t> bytes, const std::string& name,
                                          const PcapOptions& options) {
  if (const auto wrong = options.invalid()) return fail(*wrong, "PcapOptions");
  if (bytes.empty()) return fail("is empty", name);
  // Mode "r": fmemopen does not write.
  FILE* file = fmemopen(const_cast<uint8_t*>(bytes.data()), bytes.size(), "rb");
  if (file == nullptr) return fail(std::string("cannot be opened: ") + std::strerror(errno), name);
  return State::make(file, name, options);
}

PcapReader::PcapReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
PcapReader::PcapReader(PcapReader&&) noexcept = default;
PcapReader& PcapReader::operator=(PcapReader&&) noexcept = default;
PcapReader::~PcapReader() = default;

bool PcapReader::next(Datagram& datagram) {
  State& s = *state_;
  while (!s.ended) {
    pcap_pkthdr* header = nullptr;
    const u_char* bytes = nullptr;
    const int status = pcap_next_ex(s.pcap, &header, &bytes);
    if (status != 1) {
      if (status == PCAP_ERROR && s.resume_reading()) continue;
      s.stop_reading(status);
      break;
    }
    s.offset = ftello(pcap_file(s.pcap));
    ++s.counters.packets;
    const FrameOutcome outcome = s.decoder.decode(s.stamps.steady(to_stamp(header->ts)),
                                                  {bytes, header->caplen}, header->len, datagram);
    s.count_outcome(outcome);
    if (outcome != FrameOutcome::kDatagram) continue;
    if (passes(s.options.ports, datagram.destination_port) &&
        passes(s.options.senders, datagram.sender)) {
      ++s.counters.datagrams;
      return true;
    }
    ++s.counters.filtered;
  }
  return false;
}

const std::optional<Error>& PcapReader::damage() const { return state_->damage; }

void PcapReader::append_notes(std::vector<Error>& notes) const {
  if (state_->damage) notes.push_back(*state_->damage);
  const PcapCounters& c = counters();
  const auto add = [&](uint64_t count, const char* what, const char* hint) {
    if (count > 0) notes.push_back({std::to_string(count) + what, state_->name, hint});
  };
  add(c.truncated, " packets are cut short by the capture's snapshot length",
      "capture whole packets: tcpdump -s 0");
  add(c.malformed, " packets have contradictory lengths, and were not used",
      "the program that wrote the capture may have changed them");
  if (c.skipped_bytes > 0) {
    notes.push_back({std::to_string(c.skipped_bytes) + " bytes are no packets, and were skipped",
                     state_->name + ", packet " + std::to_string(state_->first_skipped),
                     "the file was damaged while being written or copied"});
  }
  if (const SteadyStamps& stamps = state_->stamps; stamps.steps() > 0) {
    char step[32];
    std::snprintf(step, sizeof step, "%.3f s", to_seconds(stamps.largest()));
    notes.push_back({"the clock of the recording host was set back " +
                         std::to_string(stamps.steps()) + " time(s), by up to " + step,
                     state_->name, "the stamps behind are read as if it had not been"});
  }
  add(c.fragments_dropped, " IPv4 fragments belong to datagrams that are not complete",
      "the fragments between were lost");
}

const PcapCounters& PcapReader::counters() const {
  state_->counters.fragments = state_->decoder.fragments();
  state_->counters.fragments_dropped = state_->decoder.fragments_dropped();
  return state_->counters;
}

}  // namespace infuse::recording
