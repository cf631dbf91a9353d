#include "drivers/host/message_batch.hpp"

#include <linux/errqueue.h>
#include <linux/net_tstamp.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <ctime>

#include "drivers/host/system_error.hpp"

namespace infuse::host {
namespace {

int64_t to_ns(const timespec& time) { return int64_t{time.tv_sec} * 1'000'000'000 + time.tv_nsec; }

}  // namespace

MessageBatch::MessageBatch(size_t messages, size_t bytes)
    : bytes_each_(bytes),
      bytes_(messages * bytes),
      vectors_(messages),
      senders_(messages),
      controls_(messages),
      headers_(messages),
      stamps_(messages),
      hardware_(messages) {
  for (size_t i = 0; i < messages; ++i) {
    vectors_[i] = {bytes_.data() + i * bytes, bytes};
    headers_[i].msg_hdr.msg_iov = &vectors_[i];
    headers_[i].msg_hdr.msg_iovlen = 1;
    headers_[i].msg_hdr.msg_name = &senders_[i];
    headers_[i].msg_hdr.msg_control = &controls_[i];
  }
}

int MessageBatch::receive(int socket, WallStamps& stamps) {
  for (mmsghdr& header : headers_) {  // the kernel shortens them
    header.msg_hdr.msg_namelen = sizeof(sockaddr_in);
    header.msg_hdr.msg_controllen = kControlBytes;
  }
  dropped_ = 0;
  const int count = recvmmsg(socket, headers_.data(), static_cast<unsigned>(headers_.size()),
                             MSG_DONTWAIT, nullptr);
  if (count < 0) return errno == EAGAIN || errno == EINTR ? 0 : -1;
  stamps.update(ClockReading::now());
  for (int i = 0; i < count; ++i) read_ancillary_data(static_cast<size_t>(i), stamps);
  return count;
}

void MessageBatch::read_ancillary_data(size_t message, const WallStamps& stamps) {
  const AncillaryData ancillary = AncillaryData::parse(headers_[message].msg_hdr);
  stamps_[message] =
      ancillary.wall_ns != 0 ? stamps.stamp_of(ancillary.wall_ns) : stamps.last_update();
  hardware_[message] = {ancillary.hardware_ns, ancillary.interface};
  if (ancillary.dropped != 0) dropped_ = ancillary.dropped;
}

MessageBatch::Message MessageBatch::operator[](size_t i) const {
  const size_t size = std::min<size_t>(headers_[i].msg_len, bytes_each_);
  return {stamps_[i],      {bytes_.data() + i * bytes_each_, size},
          senders_[i],     (headers_[i].msg_hdr.msg_flags & MSG_TRUNC) != 0,
          hardware_[i].ns, hardware_[i].interface};
}

AncillaryData AncillaryData::parse(const msghdr& header) {
  AncillaryData ancillary;
  auto* messages = const_cast<msghdr*>(&header);  // CMSG_NXTHDR only reads it
  for (cmsghdr* c = CMSG_FIRSTHDR(messages); c != nullptr; c = CMSG_NXTHDR(messages, c)) {
    if (c->cmsg_level != SOL_SOCKET) continue;
    if (c->cmsg_type == SCM_TIMESTAMPNS) {
      timespec time{};
      std::memcpy(&time, CMSG_DATA(c), sizeof(time));
      ancillary.wall_ns = to_ns(time);
    } else if (c->cmsg_type == SCM_TIMESTAMPING) {
      std::array<timespec, 3> times{};  // the first is the kernel's stamp, the last the hardware's
      std::memcpy(times.data(), CMSG_DATA(c), sizeof(times));
      if (ancillary.wall_ns == 0) ancillary.wall_ns = to_ns(times[0]);
      ancillary.hardware_ns = to_ns(times[2]);
    } else if (c->cmsg_type == SCM_TIMESTAMPING_PKTINFO) {
      scm_ts_pktinfo about{};
      std::memcpy(&about, CMSG_DATA(c), sizeof(about));
      ancillary.interface = about.if_index;
    } else if (c->cmsg_type == SO_RXQ_OVFL) {
      std::memcpy(&ancillary.dropped, CMSG_DATA(c), sizeof(ancillary.dropped));
    }
  }
  return ancillary;
}

void request_hardware_stamps(int socket) {
  const int requested =
      SOF_TIMESTAMPING_RX_HARDWARE | SOF_TIMESTAMPING_RAW_HARDWARE | SOF_TIMESTAMPING_OPT_PKTINFO;
  setsockopt(socket, SOL_SOCKET, SO_TIMESTAMPING, &requested, sizeof(requested));
}

Result<size_t> prepare_socket(int socket, size_t requested, const std::string& where) {
  const int on = 1;
  if (setsockopt(socket, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof(on)) != 0) {
    return fail_errno("cannot enable receive timestamps", where);
  }
  if (setsockopt(socket, SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof(on)) != 0) {
    return fail_errno("cannot enable the drop counter", where);
  }
  const int bytes = static_cast<int>(std::min<size_t>(requested, 1 << 30));
  // SO_RCVBUFFORCE exceeds net.core.rmem_max and needs a capability that a service does not have.
  setsockopt(socket, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof(bytes));
  setsockopt(socket, SOL_SOCKET, SO_RCVBUFFORCE, &bytes, sizeof(bytes));
  int granted = 0;
  socklen_t size = sizeof(granted);
  if (getsockopt(socket, SOL_SOCKET, SO_RCVBUF, &granted, &size) != 0) {
    return fail_errno("cannot read the receive buffer size", where);
  }
  return static_cast<size_t>(granted) / 2;  // the kernel doubles it for its own bookkeeping
}

}  // namespace infuse::host
