#include <cstdlib>

#include "drivers/import/folder_import.hpp"

// After a byte that selects: any text as the description of a folder, refused with a place or
// accepted; or as a table of stamps.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace infuse;
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data) + 1, size - 1);
  if (data[0] % 2 == 0) {
    const auto folder = importers::parse_folder(text, "fuzz");
    if (!folder && folder.error().where.empty()) std::abort();
    if (folder && (folder->drive.cameras.size() != folder->cameras.size() ||
                   folder->drive.lidars.size() != folder->lidars.size() || folder->drive.invalid()))
      std::abort();
    return 0;
  }
  for (const char* unit : {"s", "ns"}) {
    for (const char* files : {"", "2", "file"}) {
      importers::StampRule rule{.file = "f", .files_column = files, .unit = unit};
      const auto rows = importers::parse_stamp_rows(text, "fuzz", rule);
      if (!rows && rows.error().where.empty()) std::abort();
      for (size_t k = 0; rows && k < rows->size(); ++k) {
        if ((*rows)[k].stamp < Stamp() || (files[0] != 0 && (*rows)[k].file.size() > text.size()))
          std::abort();
      }
    }
  }
  static_cast<void>(importers::parse_stamp_in_name(text, "us"));
  return 0;
}
