#include <cstddef>
#include <cstdint>
#include <string_view>

#include "drivers/vehicle/dbc.hpp"

/// Any bytes as a DBC file; every signal that comes out is decoded from and encoded into a frame.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace infuse::vehicle;
  const DbcParseResult read = parse_dbc({reinterpret_cast<const char*>(data), size}, "fuzz.dbc");
  for (const DbcMessage& message : read.dbc.messages()) {
    CanFrame frame = make_frame(message, {});
    for (const DbcSignal& signal : message.signals) {
      const auto payload = std::span(frame.data).first(frame.length);
      for (const double value : {-1e300, -1.5, 0.0, 1e300}) {
        if (encode(signal, value, payload)) (void)decode(message, signal, payload);
      }
    }
  }
  return 0;
}
