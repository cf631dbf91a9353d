#pragma once

#include <string>

/// Where a test or a benchmark finds what is not compiled into it. The paths are compiled into one
/// small file, so that the compiler's cache serves all others in every checkout.
namespace infuse {

/// Root of the source tree.
std::string source_folder();

/// Folder of the programs of this build.
std::string programs_folder();

}  // namespace infuse
