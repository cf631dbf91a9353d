#include "tests/folders.hpp"

namespace infuse {

std::string source_folder() { return INFUSE_SOURCE_DIR; }
std::string programs_folder() { return INFUSE_BINARIES; }

}  // namespace infuse
