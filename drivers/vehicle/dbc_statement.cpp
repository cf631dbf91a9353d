#include "drivers/vehicle/dbc_statement.hpp"

#include <charconv>
#include <cmath>

#include "drivers/text/quoted.hpp"

namespace infuse::vehicle {
namespace {

using Kind = DbcToken::Kind;

using text::quoted;

bool opens_statement(const DbcToken& token) {
  return token.kind == Kind::kWord && token.first_on_line && is_dbc_keyword(token.text);
}

/// Parses all of the text as a number.
template <class Number>
bool parse_all(std::string_view text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

}  // namespace

DbcToken DbcStatement::open() {
  error_.reset();
  return lexer_.next();
}

void DbcStatement::fail(std::string what) {
  if (ok()) error_ = std::move(what);
}

DbcToken DbcStatement::next() { return ok() ? lexer_.next() : DbcToken{}; }

bool DbcStatement::accept(std::string_view sign) {
  if (!ok() || !peek().is(sign)) return false;
  lexer_.next();
  return true;
}

DbcToken DbcStatement::expect(Kind kind, const char* what) {
  if (peek().kind == Kind::kUnterminatedString) fail("a string is not closed");
  if (peek().kind != kind) fail("expected " + std::string(what) + ", found " + quoted(peek().text));
  return next();
}

void DbcStatement::expect(std::string_view sign) {
  if (!accept(sign)) fail("expected '" + std::string(sign) + "', found " + quoted(peek().text));
}

double DbcStatement::number(const char* what) {
  std::string_view text = expect(Kind::kNumber, what).text;
  if (text.starts_with('+')) text.remove_prefix(1);
  double value = 0;
  if (parse_all(text, value) && std::isfinite(value)) return value;
  fail(quoted(text) + " is not a number");
  return 0;
}

uint64_t DbcStatement::whole_number(const char* what) {
  const std::string_view text = expect(Kind::kNumber, what).text;
  uint64_t value = 0;
  if (parse_all(text, value)) return value;
  fail(quoted(text) + " is not " + what);
  return 0;
}

void DbcStatement::skip_lines() {
  while (peek().kind != Kind::kEnd && (!peek().first_on_line || peek().last_on_line)) lexer_.next();
}

void DbcStatement::skip_rest_of_line() {
  while (ok() && peek().kind != Kind::kEnd && !peek().first_on_line) lexer_.next();
}

void DbcStatement::skip_to_semicolon() {
  while (ok() && !accept(";")) {
    if (peek().kind == Kind::kUnterminatedString) fail("a string is not closed");
    if (peek().kind == Kind::kEnd || opens_statement(peek())) fail("expected ';'");
    next();
  }
}

void DbcStatement::skip_to_next() {
  while (peek().kind != Kind::kEnd && !opens_statement(peek())) lexer_.next();
}

}  // namespace infuse::vehicle
