#include "drivers/import/import_files.hpp"

#include "drivers/recording/numbered_files.hpp"

namespace infuse::importers {

namespace fs = std::filesystem;

Result<void> make_empty_folder(const fs::path& drive) {
  std::error_code failed;
  if (fs::exists(drive, failed) && !fs::is_empty(drive, failed))
    return fail("exists and is not empty", drive.string(), "choose a new folder");
  fs::create_directories(drive, failed);
  if (failed) return fail("cannot be created: " + failed.message(), drive.string());
  return {};
}

Result<void> link_sequence(const std::vector<StampedFile>& files, const fs::path& folder) {
  std::error_code failed;
  fs::create_directories(folder, failed);
  if (failed) return fail("cannot be created: " + failed.message(), folder.string());
  std::vector<recording::TimesRow> rows;
  std::vector<std::string> sources;
  for (const StampedFile& file : files) {
    const fs::path target =
        folder / recording::numbered_file_name(rows.size(), file.path.extension().string());
    fs::create_hard_link(file.path, target, failed);
    if (failed) fs::copy_file(file.path, target, failed);
    if (failed) return fail("cannot be copied: " + failed.message(), file.path.string());
    rows.push_back(file.times);
    sources.push_back(file.path.filename().string());
  }
  return recording::write_times(folder / "times.csv", rows, sources);
}

}  // namespace infuse::importers
