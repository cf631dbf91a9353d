// infuse-import: converts a recording to a drive.

#include "daemon/tools/import/import.hpp"

int main(int argc, char** argv) {
  return infuse::daemon::run_tool("import", infuse::daemon::declare_import, argc, argv);
}
