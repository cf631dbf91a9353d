#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "drivers/vehicle/candump.hpp"

/// Any bytes as a candump log; what is read must be written and read again as the same frame.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace infuse::vehicle;
  std::string_view rest(reinterpret_cast<const char*>(data), size);
  CandumpReader reader("fuzz.log");
  while (!rest.empty()) {
    const size_t end = rest.find('\n');
    const auto frame = reader.read(rest.substr(0, end));
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
    if (!frame || frame->interface_name().find_first_of("#[(") != std::string_view::npos) continue;
    const auto again = parse_candump_line(format_candump_line(*frame));
    if (!again || again->id != frame->id || again->length != frame->length ||
        again->data != frame->data) {
      std::abort();
    }
  }
  return 0;
}
