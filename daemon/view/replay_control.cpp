#include "daemon/view/replay_control.hpp"

namespace infuse::daemon {

void set_pace(Pacer& pacer, const ViewCommand& command) {
  switch (command.kind) {
    case ViewCommand::Kind::kOpened:
      return pacer.begin();
    case ViewCommand::Kind::kRate:
      return pacer.set_rate(command.rate);
    case ViewCommand::Kind::kStep:
      return pacer.step();
    case ViewCommand::Kind::kSeek:
      return pacer.seek(command.stamp);
    case ViewCommand::Kind::kSeekAlert:
      return pacer.seek_alert();
  }
}

}  // namespace infuse::daemon
