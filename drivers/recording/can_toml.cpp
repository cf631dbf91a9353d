#include "drivers/recording/can_toml.hpp"

#include "drivers/recording/toml_table.hpp"

namespace infuse::recording {
namespace {

std::optional<Error> read_signal(TomlTable& parent, const std::string& file,
                                 const std::string& quantity, std::vector<CanSignal>& signals) {
  const toml::node* node = parent.node(quantity);
  if (node == nullptr) return std::nullopt;
  CanSignal signal;
  signal.quantity = quantity;
  if (const toml::table* details = node->as_table()) {
    TomlTable table(*details, file, quantity);
    table.require("signal");
    table.read("signal", signal.signal);
    table.read("scale", signal.scale);
    table.read("unit", signal.unit);
    if (auto wrong = table.finish()) return wrong;
  } else {
    parent.read(quantity, signal.signal);
  }
  signals.push_back(std::move(signal));
  return std::nullopt;
}

}  // namespace

std::optional<Error> read_can_signals(const toml::table& source, const std::string& file,
                                      std::vector<CanSignal>& signals) {
  TomlTable map(source, file, "can.signals");
  for (const std::string& quantity : can_quantities()) {
    if (auto wrong = read_signal(map, file, quantity, signals)) return wrong;
  }
  return map.finish();
}

}  // namespace infuse::recording
