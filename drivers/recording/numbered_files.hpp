#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/measurement/error.hpp"

namespace infuse::recording {

/// Files of a folder by number.
using NumberedFiles = std::map<size_t, std::filesystem::path>;

/// Lists the files NUMBER.<one of `extensions`> of a folder. Extensions include the dot.
Result<NumberedFiles> list_numbered_files(const std::filesystem::path& folder,
                                          const std::vector<std::string>& extensions);

/// Name of a numbered file: "000012.png". `extension` includes the dot.
std::string numbered_file_name(uint64_t number, std::string_view extension);

}  // namespace infuse::recording
