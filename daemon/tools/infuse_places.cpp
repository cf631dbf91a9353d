// infuse-places: finds images of a drive among those of another.

#include "daemon/tools/places/places.hpp"

int main(int argc, char** argv) {
  return infuse::daemon::run_tool("places", infuse::daemon::declare_places, argc, argv);
}
