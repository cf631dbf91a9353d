#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/vehicle/can_frame.hpp"
#include "drivers/vehicle/problem_log.hpp"

namespace infuse::vehicle {

/// Bit order of a signal in a frame.
enum class ByteOrder : uint8_t {
  kIntel,     ///< little-endian: `start_bit` is the least significant bit ("@1")
  kMotorola,  ///< big-endian: `start_bit` is the most significant bit ("@0")
};

/// Interpretation of a signal's bits.
enum class SignalType : uint8_t {
  kUnsigned,
  kSigned,   ///< two's complement
  kFloat32,  ///< IEEE 754, 32 bits
  kFloat64,  ///< IEEE 754, 64 bits
};

/// One signal of a message: its bits, and the law physical = raw · scale + offset.
struct DbcSignal {
  std::string name;
  uint16_t start_bit = 0;  ///< byte · 8 + bit, bit 0 the least significant of its byte
  uint16_t length = 0;     ///< bits, 1 … 64
  ByteOrder byte_order = ByteOrder::kIntel;
  SignalType type = SignalType::kUnsigned;
  double scale = 1;
  double offset = 0;
  double minimum = 0;  ///< as the file states it, physical; often wrong, never enforced
  double maximum = 0;  ///< as `minimum`
  std::string unit;
  bool is_multiplexor = false;
  /// Index in the message of the signal that selects this one; −1: always present.
  int multiplexor = -1;
  std::vector<std::pair<uint64_t, uint64_t>>
      multiplexor_values;  ///< ranges of the selector's raw value, ends included; none: never
                           ///< present
};

/// One message: its frame's identifier, and its signals.
struct DbcMessage {
  uint32_t id = 0;
  bool extended = false;
  std::string name;
  uint16_t length = 0;  ///< bytes, ≤ 64
  std::vector<DbcSignal> signals;

  /// Returns the signal of that name, or null.
  const DbcSignal* find_signal(std::string_view signal) const;
};

/// The messages of a bus, as a DBC file describes them.
class Dbc {
 public:
  /// Adds a message unless there is one of that id. Returns whether it was added.
  bool add(DbcMessage message);

  /// Returns the message, or null.
  const DbcMessage* find(uint32_t id, bool extended) const;
  const DbcMessage* find(std::string_view name) const;
  DbcMessage* find(uint32_t id, bool extended);

  /// By id, standard before extended.
  std::span<const DbcMessage> messages() const { return messages_; }

 private:
  std::vector<DbcMessage> messages_;
};

/// Content of a DBC file as far as it could be parsed, and the problems.
struct DbcParseResult {
  Dbc dbc;
  ProblemLog problems;
};

/// Parses the text of a DBC file: messages, signals (also multiplexed ones, also by SG_MUL_VAL_),
/// and float types; the rest is skipped. A malformed statement is left out and
/// reported as a problem at `name`:line; the statements around it are kept.
DbcParseResult parse_dbc(std::string_view text, const std::string& name);

/// Parses a file of at most 64 MiB with `parse_dbc`.
Result<DbcParseResult> read_dbc(const std::filesystem::path& file);

/// The signal's raw bits, least significant first; nothing if the payload is too short.
std::optional<uint64_t> raw_value(const DbcSignal& signal, std::span<const uint8_t> payload);

/// The signal's physical value; nothing if the payload is too short or the message's multiplexor
/// selects other signals. `signal` is one of `message`.
std::optional<double> decode(const DbcMessage& message, const DbcSignal& signal,
                             std::span<const uint8_t> payload);

/// Writes a physical value into a payload: the nearest raw value, clamped to the signal's range.
/// Other signals' bits stay unchanged. False, with nothing written, if the value is NaN or the
/// signal does not fit into the payload. Multiplexors are ordinary signals: the caller sets them.
bool encode(const DbcSignal& signal, double value, std::span<uint8_t> payload);

/// Returns an empty frame of the message, for `encode`: id, length, CAN FD if longer than 8 bytes.
CanFrame make_frame(const DbcMessage& message, Stamp stamp);

}  // namespace infuse::vehicle
