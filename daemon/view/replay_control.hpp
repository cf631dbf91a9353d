#pragma once

#include "daemon/pipeline/pacer.hpp"
#include "daemon/view/view_command.hpp"

namespace infuse::daemon {

/// Does what a page asks for.
void set_pace(Pacer& pacer, const ViewCommand& command);

}  // namespace infuse::daemon
