// infuse-calibrate-target: calibrates a camera with checkerboards.

#include "daemon/tools/calibrate_target/calibrate_target.hpp"

int main(int argc, char** argv) {
  return infuse::daemon::run_tool("calibrate-target", infuse::daemon::declare_calibrate_target,
                                  argc, argv);
}
