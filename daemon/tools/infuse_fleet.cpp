// infuse-fleet: pools the calibrations of many drives.

#include "daemon/tools/fleet/fleet.hpp"

int main(int argc, char** argv) {
  return infuse::daemon::run_tool("fleet", infuse::daemon::declare_fleet, argc, argv);
}
