// infuse-map: makes maps of drives.

#include "daemon/tools/map/map.hpp"

int main(int argc, char** argv) {
  return infuse::daemon::run_tool("map", infuse::daemon::declare_map, argc, argv);
}
