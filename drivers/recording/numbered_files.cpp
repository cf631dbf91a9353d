#include "drivers/recording/numbered_files.hpp"

#include <algorithm>
#include <optional>

#include "drivers/text/numbers.hpp"

namespace infuse::recording {

namespace fs = std::filesystem;

Result<NumberedFiles> list_numbered_files(const fs::path& folder,
                                          const std::vector<std::string>& extensions) {
  NumberedFiles files;
  std::error_code failed;
  for (fs::directory_iterator entry(folder, failed), end; !failed && entry != end;
       entry.increment(failed)) {
    const fs::path& path = entry->path();
    const std::string extension = path.extension().string();
    if (std::find(extensions.begin(), extensions.end(), extension) == extensions.end()) continue;
    const auto number = text::parse_as<size_t>(path.stem().string());
    if (!number) continue;
    // If two files have the same number, the choice must not depend on the directory order.
    fs::path& chosen = files[*number];
    if (chosen.empty() || path < chosen) chosen = path;
  }
  if (failed) return fail("cannot be listed: " + failed.message(), folder.string());
  return files;
}

std::string numbered_file_name(uint64_t number, std::string_view extension) {
  std::string name = std::to_string(number);
  name.insert(0, name.size() < 6 ? 6 - name.size() : 0, '0');
  return name.append(extension);
}

}  // namespace infuse::recording
