// infuse-calibrate: calibrates cameras on drives without targets.

#include "daemon/tools/calibrate/calibrate.hpp"

int main(int argc, char** argv) {
  return infuse::daemon::run_tool("calibrate", infuse::daemon::declare_calibrate, argc, argv);
}
