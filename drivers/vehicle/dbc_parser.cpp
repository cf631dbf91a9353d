#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>

#include "drivers/vehicle/dbc.hpp"
#include "drivers/vehicle/dbc_lexer.hpp"

namespace infuse::vehicle {
namespace {

using Kind = DbcToken::Kind;

// Maximum number of messages, more than any bus has; bounds the quadratic time of a corrupt file.
constexpr size_t kMaxMessages = 16384;
constexpr size_t kMaxSignals = 1024;  // maximum per message
constexpr uint32_t kExtendedBit = 0x80000000u;
constexpr std::string_view kNoMessage = "VECTOR__INDEPENDENT_SIG_MSG";

/// A statement that cannot be parsed: thrown and caught inside this file only.
struct Malformed {
  std::string what;
};

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
  Parser(std::string_view text, const std::string& name) : lexer_(text), name_(name) {}

  DbcParseResult parse() {
    while (lexer_.peek().kind != Kind::kEnd) {
      const DbcToken opening = lexer_.next();
      try {
        parse_statement(opening);
      } catch (const Malformed& malformed) {
        report(opening.line, malformed.what);
        skip_to_statement();
      }
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
      return skip_lines();
    }
    if (opening.kind == Kind::kWord && is_dbc_keyword(opening.text)) return skip_to_semicolon();
    throw Malformed{"'" + std::string(opening.text.substr(0, 40)) + "' does not open a statement"};
  }

  // BO_ 2364540158 Name: 8 Transmitter
  void parse_message() {
    has_message_ = false;
    DbcMessage parsed;
    const uint32_t id = parse_message_id();
    parsed.extended = (id & kExtendedBit) != 0;
    parsed.id = id & ~kExtendedBit;
    parsed.name = expect_token(Kind::kWord, "the message's name").text;
    expect(":");
    const uint64_t length = parse_unsigned("the message's length");
    if (lexer_.peek().kind == Kind::kWord && !lexer_.peek().first_on_line) lexer_.next();
    if (parsed.name == kNoMessage) return;
    if (parsed.id > (parsed.extended ? 0x1FFFFFFFu : 0x7FFu)) {
      throw Malformed{"message " + parsed.name + ": id out of range"};
    }
    if (length > 64) throw Malformed{"message " + parsed.name + " is longer than 64 bytes"};
    parsed.length = static_cast<uint16_t>(length);
    if (result_.dbc.messages().size() >= kMaxMessages) throw Malformed{"too many messages"};
    const std::string label = parsed.name;
    current_message_ = {parsed.id, parsed.extended};
    if (!result_.dbc.add(std::move(parsed))) {
      throw Malformed{"message " + label + ": another message has the same id"};
    }
    has_message_ = true;
  }

  // SG_ NAME m3M : 7|16@0+ (0.01,-67.67) [0|250] "kph" RECEIVER,RECEIVER
  void parse_signal() {
    SignalLine parsed;
    DbcSignal& s = parsed.signal;
    s.name = expect_token(Kind::kWord, "the signal's name").text;
    if (!lexer_.peek().is(":")) {
      parse_multiplexing(expect_token(Kind::kWord, "':' or a multiplexor indicator").text, parsed);
    }
    expect(":");
    const uint64_t start = parse_unsigned("the start bit");
    expect("|");
    const uint64_t length = parse_unsigned("the length");
    expect("@");
    parse_byte_order_and_sign(s);
    expect("(");
    s.scale = parse_number("the factor");
    expect(",");
    s.offset = parse_number("the offset");
    expect(")");
    expect("[");
    s.minimum = parse_number("the minimum");
    expect("|");
    s.maximum = parse_number("the maximum");
    expect("]");
    s.unit = expect_token(Kind::kString, "the unit").text;
    while (lexer_.peek().kind != Kind::kEnd && !lexer_.peek().first_on_line) lexer_.next();

    if (!has_message_) {  // its message was refused and reported
      return;
    }
    DbcMessage& owner = *result_.dbc.find(current_message_.first, current_message_.second);
    const std::string label = owner.name + "." + s.name;
    if (length < 1 || length > 64 || start >= 512) {
      throw Malformed{label + ": start bit or length out of range"};
    }
    s.start_bit = static_cast<uint16_t>(start);
    s.length = static_cast<uint16_t>(length);
    const CanFrame frame = make_frame(owner, {});
    if (!raw_value(s, frame.payload())) throw Malformed{label + " does not fit into its message"};
    if (s.scale == 0) throw Malformed{label + ": the factor is 0"};
    if (owner.find_signal(s.name) != nullptr) throw Malformed{label + " is defined twice"};
    if (owner.signals.size() >= kMaxSignals) throw Malformed{label + ": too many signals"};
    if (parsed.selector_value) {
      s.multiplexor_values.emplace_back(*parsed.selector_value, *parsed.selector_value);
    }
    owner.signals.push_back(std::move(s));
  }

  static void parse_multiplexing(std::string_view indicator, SignalLine& parsed) {
    std::string_view rest = indicator;
    if (rest.ends_with('M')) {
      parsed.signal.is_multiplexor = true;
      rest.remove_suffix(1);
    }
    if (rest.empty()) return;
    uint64_t value = 0;
    const auto [end, error] = std::from_chars(rest.data() + 1, rest.data() + rest.size(), value);
    if (rest[0] != 'm' || error != std::errc() || end != rest.data() + rest.size()) {
      throw Malformed{"'" + std::string(indicator.substr(0, 40)) +
                      "' is not a multiplexor indicator (M, m<value> or m<value>M)"};
    }
    parsed.selector_value = value;
  }

  void parse_byte_order_and_sign(DbcSignal& s) {
    const uint64_t order = parse_unsigned("the byte order");
    if (order > 1) throw Malformed{"the byte order of " + s.name + " is neither 0 nor 1"};
    s.byte_order = order == 1 ? ByteOrder::kIntel : ByteOrder::kMotorola;
    const DbcToken sign = lexer_.next();
    if (!sign.is("+") && !sign.is("-")) throw Malformed{"expected + or - after the byte order"};
    s.type = sign.is("-") ? SignalType::kSigned : SignalType::kUnsigned;
  }

  // SIG_VALTYPE_ 100 NAME : 1;
  void parse_value_type() {
    DbcSignal* s = parse_signal_reference();
    if (lexer_.peek().is(":")) lexer_.next();
    const uint64_t type = parse_unsigned("the value type");
    if (type > 2) throw Malformed{"the value type is not 0, 1 or 2"};
    if (s != nullptr && type > 0) {
      if (s->length != (type == 1 ? 32 : 64)) {
        throw Malformed{s->name + ": a float has 32 bits, a double 64"};
      }
      s->type = type == 1 ? SignalType::kFloat32 : SignalType::kFloat64;
    }
    expect(";");
  }

  // SG_MUL_VAL_ 100 NAME SELECTOR 1-3, 5-5;
  void parse_extended_multiplexing() {
    const DbcToken ahead = lexer_.peek();
    DbcSignal* s = parse_signal_reference();
    const std::string selector(expect_token(Kind::kWord, "the multiplexor's name").text);
    std::vector<std::pair<uint64_t, uint64_t>> ranges;
    do {
      const uint64_t from = parse_unsigned("a value");
      if (lexer_.peek().is("-")) lexer_.next();
      const double to = std::abs(parse_number("the end of a range"));  // "1-3" is read as 1, −3
      if (!(to <= 1.8e19)) throw Malformed{"the end of a range is too large"};
      ranges.emplace_back(from, static_cast<uint64_t>(to));
    } while (lexer_.peek().is(",") && (lexer_.next(), true));
    expect(";");
    if (s == nullptr) return;
    s->multiplexor_values = std::move(ranges);
    named_selectors_.push_back({signal_message_, s->name, selector, ahead.line});
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
    const std::string_view name = expect_token(Kind::kWord, "the signal's name").text;
    signal_message_ = {id & ~kExtendedBit, (id & kExtendedBit) != 0};
    DbcMessage* owner = result_.dbc.find(signal_message_.first, signal_message_.second);
    return owner == nullptr ? nullptr : find_signal(*owner, name);
  }

  DbcToken expect_token(Kind kind, const char* what) {
    if (lexer_.peek().kind == Kind::kUnterminatedString) throw Malformed{"a string is not closed"};
    if (lexer_.peek().kind != kind) {
      throw Malformed{"expected " + std::string(what) + ", found '" +
                      std::string(lexer_.peek().text.substr(0, 40)) + "'"};
    }
    return lexer_.next();
  }

  void expect(std::string_view sign) {
    if (!lexer_.peek().is(sign)) {
      throw Malformed{"expected '" + std::string(sign) + "', found '" +
                      std::string(lexer_.peek().text.substr(0, 40)) + "'"};
    }
    lexer_.next();
  }

  double parse_number(const char* what) {
    std::string_view text = expect_token(Kind::kNumber, what).text;
    if (text.starts_with('+')) text.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
      throw Malformed{"'" + std::string(text.substr(0, 40)) + "' is not a number"};
    }
    return value;
  }

  uint64_t parse_unsigned(const char* what) {
    const std::string_view text = expect_token(Kind::kNumber, what).text;
    uint64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) {
      throw Malformed{"'" + std::string(text.substr(0, 40)) + "' is not " + what};
    }
    return value;
  }

  uint32_t parse_message_id() {
    const uint64_t id = parse_unsigned("the message's id");
    if (id > 0xFFFFFFFFu) throw Malformed{"the message's id is out of range"};
    return static_cast<uint32_t>(id);
  }

  /// VERSION "x", BS_: and BU_: a b end with their lines; the words under NS_: are alone on their
  /// lines.
  void skip_lines() {
    while (lexer_.peek().kind != Kind::kEnd) {
      const DbcToken& ahead = lexer_.peek();
      if (ahead.first_on_line && !ahead.last_on_line) return;
      lexer_.next();
    }
  }

  void skip_to_semicolon() {
    while (!lexer_.peek().is(";")) {
      const DbcToken& ahead = lexer_.peek();
      if (ahead.kind == Kind::kUnterminatedString) throw Malformed{"a string is not closed"};
      if (ahead.kind == Kind::kEnd || opens_statement(ahead)) throw Malformed{"expected ';'"};
      lexer_.next();
    }
    lexer_.next();
  }

  void skip_to_statement() {
    while (lexer_.peek().kind != Kind::kEnd && !opens_statement(lexer_.peek())) lexer_.next();
  }

  static bool opens_statement(const DbcToken& token) {
    return token.kind == Kind::kWord && token.first_on_line && is_dbc_keyword(token.text);
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

  DbcLexer lexer_;
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
  constexpr uintmax_t kMaxBytes = uintmax_t{64} << 20;
  std::error_code error;
  const uintmax_t bytes = std::filesystem::file_size(file, error);
  if (error) return fail(error.message(), file.string(), "name a DBC file");
  if (bytes > kMaxBytes) return fail("larger than 64 MiB: not a DBC file", file.string());
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  if (!stream) return fail("cannot be read", file.string());
  return parse_dbc(text.view(), file.filename().string());
}

}  // namespace infuse::vehicle
