// infuse-export: converts a drive to another format.

#include "daemon/tools/export/export.hpp"

int main(int argc, char** argv) {
  return infuse::daemon::run_tool("export", infuse::daemon::declare_export, argc, argv);
}
