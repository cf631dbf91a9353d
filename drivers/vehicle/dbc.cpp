#include "drivers/vehicle/dbc.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <tuple>

namespace infuse::vehicle {
namespace {

auto key(uint32_t id, bool extended) { return std::make_tuple(extended, id); }

bool key_less(const DbcMessage& message, const std::tuple<bool, uint32_t>& other) {
  return key(message.id, message.extended) < other;
}

/// Calls visit(byte, bit in byte) for each bit of the signal, least significant first; false if the
/// payload is too short.
template <class Visit>
bool for_each_bit(const DbcSignal& signal, size_t bytes, Visit&& visit) {
  if (signal.length == 0 || signal.length > 64) return false;
  // Motorola bits run down within a byte and on into the next byte's most significant bit; counted
  // from the top of byte 0 they are consecutive.
  const bool intel = signal.byte_order == ByteOrder::kIntel;
  const size_t first = intel ? signal.start_bit
                             : static_cast<size_t>(signal.start_bit / 8) * 8 +
                                   static_cast<size_t>(7 - signal.start_bit % 8);
  const size_t last = first + signal.length - 1;
  if (last >= bytes * 8) return false;
  for (size_t i = 0; i < signal.length; ++i) {
    const size_t position = intel ? first + i : last - i;
    visit(position / 8, intel ? position % 8 : 7 - position % 8);
  }
  return true;
}

int64_t sign_extended(uint64_t raw, int bits) {
  const int shift = 64 - bits;
  return static_cast<int64_t>(raw << shift) >> shift;
}

/// The nearest integer that fits into `bits`.
uint64_t to_raw_integer(double raw, int bits, bool is_signed) {
  const double rounded = std::nearbyint(raw);
  const double span = std::ldexp(1.0, is_signed ? bits - 1 : bits);
  const uint64_t mask = bits == 64 ? ~uint64_t{0} : (uint64_t{1} << bits) - 1;
  if (rounded >= span) return is_signed ? mask >> 1 : mask;
  if (is_signed) {
    const double lowest = -span;
    return static_cast<uint64_t>(static_cast<int64_t>(std::max(rounded, lowest))) & mask;
  }
  return rounded <= 0 ? 0 : static_cast<uint64_t>(rounded);
}

bool is_selected(const DbcMessage& message, const DbcSignal& signal,
                 std::span<const uint8_t> payload) {
  const DbcSignal* at = &signal;
  // A chain of selectors cannot be longer than the message's number of signals.
  for (size_t depth = 0; at->multiplexor >= 0; ++depth) {
    if (depth > message.signals.size()) return false;
    const DbcSignal& selector = message.signals[static_cast<size_t>(at->multiplexor)];
    const auto raw = raw_value(selector, payload);
    const bool chosen =
        raw && std::any_of(at->multiplexor_values.begin(), at->multiplexor_values.end(),
                           [&](const auto& r) { return r.first <= *raw && *raw <= r.second; });
    if (!chosen) return false;
    at = &selector;
  }
  return true;
}

}  // namespace

const DbcSignal* DbcMessage::find_signal(std::string_view signal) const {
  const auto at = std::find_if(signals.begin(), signals.end(),
                               [&](const DbcSignal& s) { return s.name == signal; });
  return at == signals.end() ? nullptr : &*at;
}

bool Dbc::add(DbcMessage message) {
  const auto wanted = key(message.id, message.extended);
  const auto at = std::lower_bound(messages_.begin(), messages_.end(), wanted, key_less);
  if (at != messages_.end() && key(at->id, at->extended) == wanted) return false;
  messages_.insert(at, std::move(message));
  return true;
}

const DbcMessage* Dbc::find(uint32_t id, bool extended) const {
  const auto wanted = key(id, extended);
  const auto at = std::lower_bound(messages_.begin(), messages_.end(), wanted, key_less);
  return at != messages_.end() && key(at->id, at->extended) == wanted ? &*at : nullptr;
}

DbcMessage* Dbc::find(uint32_t id, bool extended) {
  return const_cast<DbcMessage*>(std::as_const(*this).find(id, extended));
}

const DbcMessage* Dbc::find(std::string_view name) const {
  const auto at = std::find_if(messages_.begin(), messages_.end(),
                               [&](const DbcMessage& m) { return m.name == name; });
  return at == messages_.end() ? nullptr : &*at;
}

std::optional<uint64_t> raw_value(const DbcSignal& signal, std::span<const uint8_t> payload) {
  uint64_t raw = 0;
  int i = 0;
  const bool fits = for_each_bit(signal, payload.size(), [&](size_t byte, size_t bit) {
    raw |= static_cast<uint64_t>((payload[byte] >> bit) & 1) << i++;
  });
  return fits ? std::optional(raw) : std::nullopt;
}

std::optional<double> decode(const DbcMessage& message, const DbcSignal& signal,
                             std::span<const uint8_t> payload) {
  const auto raw = raw_value(signal, payload);
  if (!raw || !is_selected(message, signal, payload)) return std::nullopt;
  double value = 0;
  switch (signal.type) {
    case SignalType::kUnsigned:
      value = static_cast<double>(*raw);
      break;
    case SignalType::kSigned:
      value = static_cast<double>(sign_extended(*raw, signal.length));
      break;
    case SignalType::kFloat32:
      value = static_cast<double>(std::bit_cast<float>(static_cast<uint32_t>(*raw)));
      break;
    case SignalType::kFloat64:
      value = std::bit_cast<double>(*raw);
      break;
  }
  return value * signal.scale + signal.offset;
}

bool encode(const DbcSignal& signal, double value, std::span<uint8_t> payload) {
  const double scaled = (value - signal.offset) / signal.scale;
  if (std::isnan(scaled) || signal.length == 0 || signal.length > 64) return false;
  uint64_t raw = 0;
  switch (signal.type) {
    case SignalType::kUnsigned:
    case SignalType::kSigned:
      raw = to_raw_integer(scaled, signal.length, signal.type == SignalType::kSigned);
      break;
    case SignalType::kFloat32:
      raw = std::bit_cast<uint32_t>(
          static_cast<float>(std::clamp(scaled, -3.4028234e38, 3.4028234e38)));
      break;
    case SignalType::kFloat64:
      raw = std::bit_cast<uint64_t>(scaled);
      break;
  }
  return for_each_bit(signal, payload.size(), [&](size_t byte, size_t bit) {
    const auto mask = static_cast<uint8_t>(1u << bit);
    payload[byte] = static_cast<uint8_t>((payload[byte] & ~mask) | ((raw & 1) != 0 ? mask : 0));
    raw >>= 1;
  });
}

CanFrame make_frame(const DbcMessage& message, Stamp stamp) {
  CanFrame frame;
  frame.stamp = stamp;
  frame.id = message.id;
  frame.extended = message.extended;
  frame.fd = message.length > 8;
  frame.length = static_cast<uint8_t>(std::min<size_t>(message.length, frame.data.size()));
  return frame;
}

}  // namespace infuse::vehicle
