// infuse-align: finds the pose of one sweep in another's frame.

#include "daemon/tools/align/align.hpp"

int main(int argc, char** argv) {
  return infuse::daemon::run_tool("align", infuse::daemon::declare_align, argc, argv);
}
