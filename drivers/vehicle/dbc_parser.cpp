#include <algorithm>
#include <charconv>
#include <cmath>

#include "drivers/text/text_file.hpp"
#include "drivers/vehicle/dbc.hpp"
#include "drivers/vehicle/dbc_statement.hpp"

namespace infuse::vehicle {
namespace {

using Kind = DbcToken::Kind;

// Maximum number of messages, more than any bus has; bounds the quadratic time of a corrupt file.
constexpr size_t kMaxMessages = 16384;
constexpr size_t kMaxSignals = 1024;  // maximum per message
constexpr uint32_t kExtendedBit = 0x80000000u;
constexpr std::string_view kNoMessage = "VECTOR__INDEPENDENT_SIG_MSG";

DbcSignal* find_signal(DbcMessage& message, std::string_view name) {
  return const_cast<DbcSignal*>(std::as_const(message).find_signal(name));
}

/// One `SG_` line, its multiplexing not yet linked to the selector.
struct SignalLine {
  DbcSignal signal;
  std::optional<uint64_t> selector_value;
};

class Parser {
 public:
  Parser(std::string_view text, const std::string& name) : in_(text), name_(name) {}

  DbcParseResult parse() {
    while (in_.peek().kind != Kind::kEnd) {
      const DbcToken opening = in_.open();
      parse_statement(opening);
      if (in_.ok()) continue;
      report(opening.line, *in_.error());
      in_.skip_to_next();
    }
    resolve_multiplexors();
    return std::move(result_);
  }

 private:
  void parse_statement(const DbcToken& opening) {
    if (opening.is("BO_")) return parse_message();
    if (opening.is("SG_")) return parse_signal();
    if (opening.is("SIG_VALTYPE_")) return parse_value_type();
    if (opening.is("SG_MUL_VAL_")) return parse_extended_multiplexing();
    if (opening.is("NS_") || opening.is("BS_") || opening.is("BU_") || opening.is("VERSION")) {
      return in_.skip_lines();
    }
    if (opening.kind == Kind::kWord && is_dbc_keyword(opening.text)) return in_.skip_to_semicolon();
    return in_.fail("'" + std::string(opening.text.substr(0, 40)) + "' does not open a statement");
  }

  // BO_ 2364540158 Name: 8 Transmitter
  void parse_message() {
    has_message_ = false;
    DbcMessage parsed;
    const uint32_t id = parse_message_id();
    parsed.extended = (id & kExtendedBit) != 0;
    parsed.id = id & ~kExtendedBit;
    parsed.name = in_.expect(Kind::kWord, "the message's name").text;
    in_.expect(":");
    const uint64_t length = in_.whole_number("the message's length");
    if (in_.peek().kind == Kind::kWord && !in_.peek().first_on_line) in_.next();
    if (!in_.ok() || parsed.name == kNoMessage) return;
    if (parsed.id > (parsed.extended ? 0x1FFFFFFFu : 0x7FFu)) {
      return in_.fail("message " + parsed.name + ": id out of range");
    }
    if (length > 64) return in_.fail("message " + parsed.name + " is longer than 64 bytes");
    parsed.length = static_cast<uint16_t>(length);
    if (result_.dbc.messages().size() >= kMaxMessages) return in_.fail("too many messages");
    const std::string label = parsed.name;
    current_message_ = {parsed.id, parsed.extended};
    if (!result_.dbc.add(std::move(parsed))) {
      return in_.fail("message " + label + ": another message has the same id");
    }
    has_message_ = true;
  }

  // SG_ NAME m3M : 7|16@0+ (0.01,-67.67) [0|250] "kph" RECEIVER,RECEIVER
  void parse_signal() {
    SignalLine parsed;
    DbcSignal& s = parsed.signal;
    s.name = in_.expect(Kind::kWord, "the signal's name").text;
    if (!in_.peek().is(":")) {
      parse_multiplexing(in_.expect(Kind::kWord, "':' or a multiplexor indicator").text, parsed);
    }
    in_.expect(":");
    const uint64_t start = in_.whole_number("the start bit");
    in_.expect("|");
    const uint64_t length = in_.whole_number("the length");
    in_.expect("@");
    parse_byte_order_and_sign(s);
    in_.expect("(");
    s.scale = in_.number("the factor");
    in_.expect(",");
    s.offset = in_.number("the offset");
    in_.expect(")");
    in_.expect("[");
    s.minimum = in_.number("the minimum");
    in_.expect("|");
    s.maximum = in_.number("the maximum");
    in_.expect("]");
    s.unit = in_.expect(Kind::kString, "the unit").text;
    in_.skip_rest_of_line();
    if (!in_.ok() || !has_message_) return;  // a message that was refused has been reported
    DbcMessage& owner = *result_.dbc.find(current_message_.first, current_message_.second);
    const std::string label = owner.name + "." + s.name;
    if (length < 1 || length > 64 || start >= 512) {
      return in_.fail(label + ": start bit or length out of range");
    }
    s.start_bit = static_cast<uint16_t>(start);
    s.length = static_cast<uint16_t>(length);
    const CanFrame frame = make_frame(owner, {});
    if (!raw_value(s, frame.payload())) return in_.fail(label + " does not fit into its message");
    if (s.scale == 0) return in_.fail(label + ": the factor is 0");
    if (owner.find_signal(s.name) != nullptr) return in_.fail(label + " is defined twice");
    if (owner.signals.size() >= kMaxSignals) return in_.fail(label + ": too many signals");
    if (parsed.selector_value) {
      s.multiplexor_values.emplace_back(*parsed.selector_value, *parsed.selector_value);
    }
    owner.signals.push_back(std::move(s));
  }

  void parse_multiplexing(std::string_view indicator, SignalLine& parsed) {
    std::string_view rest = indicator;
    if (rest.ends_with('M')) {
      parsed.signal.is_multiplexor = true;
      rest.remove_suffix(1);
    }
    if (rest.empty()) return;
    uint64_t value = 0;
    const auto [end, error] = std::from_chars(rest.data() + 1, rest.data() + rest.size(), value);
    if (rest[0] != 'm' || error != std::errc() || end != rest.data() + rest.size()) {
      return in_.fail("'" + std::string(indicator.substr(0, 40)) +
                      "' is not a multiplexor indicator (M, m<value> or m<value>M)");
    }
    parsed.selector_value = value;
  }

  void parse_byte_order_and_sign(DbcSignal& s) {
    const uint64_t order = in_.whole_number("the byte order");
    if (order > 1) return in_.fail("the byte order of " + s.name + " is neither 0 nor 1");
    s.byte_order = order == 1 ? ByteOrder::kIntel : ByteOrder::kMotorola;
    const DbcToken sign = in_.next();
    if (!sign.is("+") && !sign.is("-")) in_.fail("expected + or - after the byte order");
    s.type = sign.is("-") ? SignalType::kSigned : SignalType::kUnsigned;
  }

  // SIG_VALTYPE_ 100 NAME : 1;
  void parse_value_type() {
    DbcSignal* s = parse_signal_reference();
    in_.accept(":");
    const uint64_t type = in_.whole_number("the value type");
    if (type > 2) return in_.fail("the value type is not 0, 1 or 2");
    if (in_.ok() && s != nullptr && type > 0) {
      if (s->length != (type == 1 ? 32 : 64)) {
        return in_.fail(s->name + ": a float has 32 bits, a double 64");
      }
      s->type = type == 1 ? SignalType::kFloat32 : SignalType::kFloat64;
    }
    in_.expect(";");
  }

  // SG_MUL_VAL_ 100 NAME SELECTOR 1-3, 5-5;
  void parse_extended_multiplexing() {
    const int line = in_.peek().line;
    DbcSignal* s = parse_signal_reference();
    const std::string selector(in_.expect(Kind::kWord, "the multiplexor's name").text);
    std::vector<std::pair<uint64_t, uint64_t>> ranges;
    do {
      const uint64_t from = in_.whole_number("a value");
      in_.accept("-");
      const double to = std::abs(in_.number("the end of a range"));  // "1-3" is read as 1, −3
      if (!(to <= 1.8e19)) return in_.fail("the end of a range is too large");
      ranges.emplace_back(from, static_cast<uint64_t>(to));
    } while (in_.accept(","));
    in_.expect(";");
    if (!in_.ok() || s == nullptr) return;
    s->multiplexor_values = std::move(ranges);
    named_selectors_.push_back({signal_message_, s->name, selector, line});
  }

  /// Links each multiplexed signal to its selector: the one that SG_MUL_VAL_ names, or the only
  /// multiplexor of the message that is always present.
  void resolve_multiplexors() {
    for (const NamedSelector& named : named_selectors_) {
      DbcMessage& owner = *result_.dbc.find(named.message.first, named.message.second);
      const DbcSignal* selector = owner.find_signal(named.selector);
      DbcSignal& s = *find_signal(owner, named.signal);
      if (selector != nullptr && selector != &s) {
        s.multiplexor = static_cast<int>(selector - owner.signals.data());
      } else {
        mark_never_selected(owner, s, named.line);
      }
    }
    for (const DbcMessage& found : result_.dbc.messages()) {
      DbcMessage& owner = *result_.dbc.find(found.id, found.extended);
      const auto root = std::find_if(
          owner.signals.begin(), owner.signals.end(),
          [](const DbcSignal& s) { return s.is_multiplexor && s.multiplexor_values.empty(); });
      for (DbcSignal& s : owner.signals) {
        if (s.multiplexor_values.empty() || s.multiplexor >= 0) continue;
        if (root != owner.signals.end()) {
          s.multiplexor = static_cast<int>(root - owner.signals.begin());
        } else {
          mark_never_selected(owner, s, 0);
        }
      }
    }
  }

  void mark_never_selected(const DbcMessage& owner, DbcSignal& s, int line) {
    report(line, owner.name + "." + s.name + " is multiplexed, and its multiplexor is missing");
    s.multiplexor = static_cast<int>(&s - owner.signals.data());
    s.multiplexor_values.clear();
  }

  DbcSignal* parse_signal_reference() {
    const uint32_t id = parse_message_id();
    const std::string_view name = in_.expect(Kind::kWord, "the signal's name").text;
    signal_message_ = {id & ~kExtendedBit, (id & kExtendedBit) != 0};
    DbcMessage* owner = result_.dbc.find(signal_message_.first, signal_message_.second);
    return owner == nullptr ? nullptr : find_signal(*owner, name);
  }

  uint32_t parse_message_id() {
    const uint64_t id = in_.whole_number("the message's id");
    if (id > 0xFFFFFFFFu) in_.fail("the message's id is out of range");
    return static_cast<uint32_t>(id);
  }

  void report(int line, std::string what) {
    result_.problems.add({std::move(what), line > 0 ? name_ + ":" + std::to_string(line) : name_,
                          "skipped; the rest of the file is used"});
  }

  using MessageKey = std::pair<uint32_t, bool>;
  struct NamedSelector {
    MessageKey message;
    std::string signal, selector;
    int line;
  };

  DbcStatement in_;
  std::string name_;
  DbcParseResult result_;
  MessageKey current_message_{};
  MessageKey signal_message_{};
  bool has_message_ = false;
  std::vector<NamedSelector> named_selectors_;
};

}  // namespace

DbcParseResult parse_dbc(std::string_view text, const std::string& name) {
  return Parser(text, name).parse();
}

Result<DbcParseResult> read_dbc(const std::filesystem::path& file) {
  constexpr size_t kMaxBytes = size_t{64} << 20;
  const auto text = text::read_text(file, kMaxBytes);
  if (!text) return fail(text.error().what, file.string(), "name a DBC file");
  return parse_dbc(*text, file.filename().string());
}

}  // namespace infuse::vehicle
