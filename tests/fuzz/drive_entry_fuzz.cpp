// Entries of drives (infuse fleet drive), through to the summary and the page.

#include <cstdint>

#include "daemon/tools/fleet/fleet_page.hpp"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace infuse::daemon;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  auto entry = parse_drive_entry(text, "entry.json");
  if (!entry) return 0;
  DriveEntry later = *entry;
  later.drive += "2";
  const FleetSummary fleet = summarise_fleet({*entry, later}, {}, {});
  json_text(to_json(fleet));
  make_fleet_page(fleet);
  return 0;
}
