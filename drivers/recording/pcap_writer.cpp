#include "drivers/recording/pcap_writer.hpp"

#include <pcap/pcap.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

namespace infuse::recording {
namespace {

constexpr size_t kHeaderBytes = 14 + 20 + 8;
constexpr size_t kMaxPayloadBytes = 65535 - 20 - 8;
constexpr int kSnapLength = 262144;
constexpr int64_t kNsPerSecond = 1'000'000'000;
constexpr uint64_t kFileHeaderBytes = 24, kRecordHeaderBytes = 16;

void put_u16(std::vector<uint8_t>& frame, size_t at, size_t value) {
  frame[at] = static_cast<uint8_t>(value >> 8);
  frame[at + 1] = static_cast<uint8_t>(value);
}
void put_u32(std::vector<uint8_t>& frame, size_t at, uint32_t value) {
  put_u16(frame, at, value >> 16);
  put_u16(frame, at + 2, value & 0xFFFF);
}

// RFC 1071 checksum of a 20-byte IPv4 header whose checksum field is 0.
uint16_t header_checksum(const std::vector<uint8_t>& frame) {
  uint32_t sum = 0;
  for (size_t at = 14; at < 34; at += 2) {
    sum += static_cast<uint32_t>(frame[at] << 8 | frame[at + 1]);
  }
  while (sum >> 16 != 0) sum = (sum & 0xFFFF) + (sum >> 16);
  return static_cast<uint16_t>(~sum);
}

}  // namespace

struct PcapWriter::State {
  State(std::string name, pcap_t* handle, pcap_dumper_t* out)
      : path(std::move(name)), pcap(handle), dumper(out) {
    frame.reserve(kHeaderBytes + kMaxPayloadBytes);
  }
  ~State() {
    if (dumper != nullptr) pcap_dump_close(dumper);
    pcap_close(pcap);
  }
  State(const State&) = delete;
  State& operator=(const State&) = delete;

  void build_frame(const Datagram& datagram, uint32_t receiver);
  tl::unexpected<Error> close_and_truncate(int reason);

  std::string path;
  pcap_t* pcap;
  pcap_dumper_t* dumper;
  uint16_t identification = 0;
  uint64_t bytes = kFileHeaderBytes;
  uint64_t flushed_bytes = 0;  // size of the file after the last flush
  std::vector<uint8_t> frame;
};

// libpcap may write part of its buffer when it closes the file: truncate afterwards.
tl::unexpected<Error> PcapWriter::State::close_and_truncate(int reason) {
  pcap_dump_close(std::exchange(dumper, nullptr));
  std::error_code ignored;
  std::filesystem::resize_file(path, flushed_bytes, ignored);
  return fail(std::string("cannot be written: ") + std::strerror(reason), path,
              "is the disk full?");
}

void PcapWriter::State::build_frame(const Datagram& datagram, uint32_t receiver) {
  const size_t payload = datagram.payload.size();
  frame.assign(kHeaderBytes, 0);
  std::fill_n(frame.begin(), 6, uint8_t{0xFF});              // broadcast
  const std::array<uint8_t, 3> vendor = {0x60, 0x76, 0x88};  // Velodyne's
  std::copy(vendor.begin(), vendor.end(), frame.begin() + 6);
  put_u16(frame, 12, 0x0800);
  frame[14] = 0x45;  // IPv4, 20-byte header
  put_u16(frame, 16, 20 + 8 + payload);
  put_u16(frame, 18, identification++);
  put_u16(frame, 20, 0x4000);  // do not fragment
  frame[22] = 128;             // time to live
  frame[23] = 17;              // UDP
  put_u32(frame, 26, datagram.sender);
  put_u32(frame, 30, receiver);
  put_u16(frame, 24, header_checksum(frame));
  put_u16(frame, 34, datagram.sender_port);
  put_u16(frame, 36, datagram.destination_port);
  put_u16(frame, 38, 8 + payload);  // UDP checksum 0: not used
  frame.insert(frame.end(), datagram.payload.begin(), datagram.payload.end());
}

Result<PcapWriter> PcapWriter::create(const std::filesystem::path& path) {
  pcap_t* pcap =
      pcap_open_dead_with_tstamp_precision(DLT_EN10MB, kSnapLength, PCAP_TSTAMP_PRECISION_NANO);
  if (pcap == nullptr) return fail("out of memory", path.string());
  pcap_dumper_t* dumper = pcap_dump_open(pcap, path.c_str());
  if (dumper == nullptr) {
    const std::string reason = pcap_geterr(pcap);
    pcap_close(pcap);
    return fail("cannot be written: " + reason, path.string());
  }
  return PcapWriter(std::make_unique<State>(path.string(), pcap, dumper));
}

PcapWriter::PcapWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
PcapWriter::PcapWriter(PcapWriter&&) noexcept = default;
PcapWriter& PcapWriter::operator=(PcapWriter&&) noexcept = default;
PcapWriter::~PcapWriter() = default;

Result<void> PcapWriter::write(const Datagram& datagram, uint32_t receiver) {
  State& s = *state_;
  if (s.dumper == nullptr) return fail("is already closed", s.path);
  if (datagram.payload.size() > kMaxPayloadBytes) {
    return fail("a payload of " + std::to_string(datagram.payload.size()) +
                    " bytes does not fit a UDP datagram",
                s.path);
  }
  const int64_t ns = datagram.stamp.ns();
  if (ns < 0 || ns / kNsPerSecond > 0xFFFF'FFFF) {
    return fail("the stamp " + std::to_string(ns) + " ns lies outside 1970 to 2106", s.path);
  }
  s.build_frame(datagram, receiver);
  pcap_pkthdr header{};
  header.ts.tv_sec = ns / kNsPerSecond;
  header.ts.tv_usec = ns % kNsPerSecond;  // nanoseconds: the precision of the file
  header.caplen = header.len = static_cast<bpf_u_int32>(s.frame.size());
  pcap_dump(reinterpret_cast<u_char*>(s.dumper), &header, s.frame.data());
  if (std::ferror(pcap_dump_file(s.dumper)) != 0) return s.close_and_truncate(errno);
  s.bytes += kRecordHeaderBytes + s.frame.size();
  return {};
}

uint64_t PcapWriter::bytes() const { return state_->bytes; }

Result<void> PcapWriter::flush() {
  State& s = *state_;
  if (s.dumper == nullptr) return fail("is already closed", s.path);
  if (pcap_dump_flush(s.dumper) != 0) return s.close_and_truncate(errno);
  s.flushed_bytes = s.bytes;
  return {};
}

Result<void> PcapWriter::close() {
  State& s = *state_;
  if (s.dumper == nullptr) return {};
  if (auto flushed = flush(); !flushed) return flushed;
  pcap_dump_close(std::exchange(s.dumper, nullptr));
  return {};
}

}  // namespace infuse::recording
