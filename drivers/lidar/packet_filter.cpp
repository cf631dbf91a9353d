#include "drivers/lidar/packet_filter.hpp"

#include <netinet/in.h>
#include <sys/socket.h>

namespace infuse::lidar {
namespace {

// Replaced by the distance to the instruction.
constexpr uint8_t kToReject = 255;
constexpr uint8_t kToAccept = 254;

uint8_t resolve(uint8_t target, size_t instruction, size_t accept) {
  if (target == kToAccept) return static_cast<uint8_t>(accept - instruction - 1);
  if (target == kToReject) return static_cast<uint8_t>(accept - instruction);
  return target;
}

}  // namespace

void PacketFilter::require_port(uint16_t port) {
  program_.insert(program_.end(),
                  {
                      BPF_STMT(BPF_LD | BPF_B | BPF_ABS, 9),
                      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, IPPROTO_UDP, 0, kToReject),
                      BPF_STMT(BPF_LD | BPF_H | BPF_ABS, 6),
                      // more fragments, offset
                      BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, 0x3FFF, kToReject, 0),
                      BPF_STMT(BPF_LDX | BPF_B | BPF_MSH, 0),
                      BPF_STMT(BPF_LD | BPF_H | BPF_IND, 2),
                      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, port, 0, kToReject),
                  });
}

void PacketFilter::require_sender(std::span<const uint32_t> senders, uint32_t source_address) {
  program_.push_back(BPF_STMT(BPF_LD | BPF_W | BPF_ABS, source_address));
  for (const uint32_t sender : senders) {
    program_.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, sender, kToAccept, 0));
  }
  constexpr auto kRandom = static_cast<uint32_t>(SKF_AD_OFF + SKF_AD_RANDOM);
  program_.push_back(BPF_STMT(BPF_LD | BPF_W | BPF_ABS, kRandom));
  program_.push_back(BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, kOthersPassed - 1, kToReject, 0));
}

bool PacketFilter::attach(int socket) && {
  const size_t accept = program_.size();
  for (size_t i = 0; i < accept; ++i) {
    if (BPF_CLASS(program_[i].code) != BPF_JMP) continue;
    program_[i].jt = resolve(program_[i].jt, i, accept);
    program_[i].jf = resolve(program_[i].jf, i, accept);
  }
  program_.push_back(BPF_STMT(BPF_RET | BPF_K, 0xFFFF));
  program_.push_back(BPF_STMT(BPF_RET | BPF_K, 0));
  const sock_fprog filter{static_cast<unsigned short>(program_.size()), program_.data()};
  return setsockopt(socket, SOL_SOCKET, SO_ATTACH_FILTER, &filter, sizeof(filter)) == 0;
}

}  // namespace infuse::lidar
