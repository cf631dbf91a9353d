#include "drivers/import/import_files.hpp"

#include "drivers/recording/numbered_files.hpp"

namespace infuse::importers {

namespace fs = std::filesystem;

namespace {

/// Extension of a file in a drive: ".jpg" of ".JPEG".
std::string drive_extension(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension == ".jpeg" ? ".jpg" : extension;
}

}  // namespace

Result<void> make_empty_folder(const fs::path& drive) {
  std::error_code failed;
  if (fs::exists(drive, failed) && !fs::is_empty(drive, failed))
    return fail("exists and is not empty", drive.string(), "choose a new folder");
  fs::create_directories(drive, failed);
  if (failed) return fail("cannot be created: " + failed.message(), drive.string());
  return {};
}

Result<void> link_file(const fs::path& from, const fs::path& to) {
  std::error_code failed;
  if (fs::exists(to, failed)) {
    if (fs::equivalent(from, to, failed)) return {};
    return fail("exists already", to.string(), "from " + from.string());
  }
  fs::create_directories(to.parent_path(), failed);
  if (failed) return fail("cannot be created: " + failed.message(), to.parent_path().string());
  fs::create_hard_link(from, to, failed);
  if (failed) fs::copy_file(from, to, failed);
  if (failed) return fail("cannot be copied: " + failed.message(), from.string());
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
        folder / recording::numbered_file_name(rows.size(), drive_extension(file.path));
    if (auto linked = link_file(file.path, target); !linked) return linked;
    rows.push_back(file.times);
    sources.push_back(file.path.filename().string());
  }
  return recording::write_times(folder / "times.csv", rows, sources);
}

}  // namespace infuse::importers
