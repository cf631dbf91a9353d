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

/// How a signal's bits are counted in a frame.
enum class ByteOrder : uint8_t {
  kIntel,     ///< little-endian: `start_bit` is the least significant bit ("@1")
  kMotorola,  ///< big-endian: `start_bit` is the most significant bit ("@0")
};

/// How a signal's bits are read.
enum class SignalType : uint8_t {
  kUnsigned,
  kSigned,   ///< two's complement
  kFloat32,  ///< IEEE 754, 32 bits
  kFloat64,  ///< IEEE 754, 64 bits
};

/// One signal of a message: bits, and the law physical = raw · scale + offset.
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
  int multiplexor = -1;  ///< index in the message of the signal that selects this one; −1: always
                         ///< there
  std::vector<std::pair<uint64_t, uint64_t>>
      multiplexor_values;  ///< ranges of the selector's raw value, ends included; none: never there
  std::vector<std::pair<int64_t, std::string>> value_names;  ///< raw value and its meaning
};

/// One message: which frame, and the signals in it.
struct DbcMessage {
  uint32_t id = 0;
  bool extended = false;
  std::string name;
  uint16_t length = 0;  ///< bytes, ≤ 64
  std::vector<DbcSignal> signals;

  /// Null where there is none of that name.
  const DbcSignal* find_signal(std::string_view signal) const;
};

/// The messages of a bus, as a DBC file describes them.
class Dbc {
 public:
  /// Adds a message unless there is one of that id already; says whether it did.
  bool add(DbcMessage message);

  /// Null where there is none.
  const DbcMessage* find(uint32_t id, bool extended) const;
  const DbcMessage* find(std::string_view name) const;
  DbcMessage* find(uint32_t id, bool extended);

  /// By id, standard before extended.
  std::span<const DbcMessage> messages() const { return messages_; }

 private:
  std::vector<DbcMessage> messages_;
};

/// A DBC file as far as it could be understood, and what could not.
struct DbcParseResult {
  Dbc dbc;
  ProblemLog problems;
};

/// Reads the text of a DBC file: messages, signals (multiplexed ones too, also by SG_MUL_VAL_),
/// float types and value tables; the rest is skipped. A statement that is wrong is left out and
/// reported as a problem at `name`:line; what stands around it is kept.
DbcParseResult parse_dbc(std::string_view text, const std::string& name);

/// `parse_dbc` of a file of at most 64 MiB.
Result<DbcParseResult> read_dbc(const std::filesystem::path& file);

/// The signal's raw bits, least significant first; nothing where the payload is too short.
std::optional<uint64_t> raw_value(const DbcSignal& signal, std::span<const uint8_t> payload);

/// The signal's physical value; nothing where the payload is too short for it or the message's
/// multiplexor selects other signals. `signal` is one of `message`.
std::optional<double> decode(const DbcMessage& message, const DbcSignal& signal,
                             std::span<const uint8_t> payload);

/// The meaning of the signal's raw value by its value table; empty where it has none.
std::string_view value_name(const DbcSignal& signal, std::span<const uint8_t> payload);

/// Writes a physical value into a payload: the nearest raw value, held to what the bits can say.
/// Other signals' bits stay as they are. False, and nothing written, where the value is NaN or the
/// signal does not fit into the payload. A multiplexor is a signal like others: the caller sets it.
bool encode(const DbcSignal& signal, double value, std::span<uint8_t> payload);

/// An empty frame of the message, for `encode`: id, length, CAN FD where it is longer than 8 bytes.
CanFrame make_frame(const DbcMessage& message, Stamp stamp);

}  // namespace infuse::vehicle
