#include "daemon/view/access.hpp"

#include <algorithm>
#include <boost/asio/ip/address.hpp>

namespace infuse::daemon {
namespace {

constexpr size_t kMaxTarget = 1024, kMaxHost = 256;
constexpr int kForbidden = 403, kUnauthorized = 401, kNotAllowed = 405, kBad = 400;

/// Host without its port; IPv6 without its brackets. Empty if it is neither.
std::string_view host_name(std::string_view host) {
  if (host.size() > kMaxHost) return {};
  std::string_view port;
  if (host.starts_with('[')) {
    const size_t end = host.find(']');
    if (end == std::string_view::npos) return {};
    port = host.substr(end + 1);
    host = host.substr(1, end - 1);
  } else if (const size_t colon = host.find(':'); colon != std::string_view::npos) {
    port = host.substr(colon);
    host = host.substr(0, colon);
  }
  const bool digits =
      port.empty() || (port.size() <= 6 && port.front() == ':' && port.size() > 1 &&
                       port.find_first_not_of("0123456789", 1) == std::string_view::npos);
  return digits ? host : std::string_view{};
}

bool is_address_or_localhost(std::string_view host) {
  const std::string_view name = host_name(host);
  if (name == "localhost") return true;
  boost::system::error_code failed;
  static_cast<void>(boost::asio::ip::make_address(std::string(name), failed));
  return !failed;
}

/// Takes the same time wherever the texts differ.
bool equals(std::string_view a, std::string_view b) {
  unsigned different = a.size() == b.size() ? 0 : 1;
  for (size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    different |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
  }
  return different == 0;
}

std::string_view token_in(std::string_view cookie) {
  while (!cookie.empty()) {
    const size_t end = std::min(cookie.find(';'), cookie.size());
    std::string_view one = cookie.substr(0, end);
    while (one.starts_with(' ')) one.remove_prefix(1);
    if (one.size() > kTokenCookie.size() && one.starts_with(kTokenCookie) &&
        one[kTokenCookie.size()] == '=') {
      return one.substr(kTokenCookie.size() + 1);
    }
    cookie.remove_prefix(std::min(end + 1, cookie.size()));
  }
  return {};
}

}  // namespace

std::string_view path_of(std::string_view target) { return target.substr(0, target.find('?')); }

std::string_view token_of(std::string_view target) {
  constexpr std::string_view kKey = "token=";
  const size_t question = target.find('?');
  if (question == std::string_view::npos) return {};
  std::string_view query = target.substr(question + 1);
  while (!query.empty()) {
    const size_t end = std::min(query.find('&'), query.size());
    if (query.starts_with(kKey)) return query.substr(kKey.size(), end - kKey.size());
    query.remove_prefix(std::min(end + 1, query.size()));
  }
  return {};
}

std::optional<ViewRefusal> check_access(const ViewRequest& request, const ViewSettings& settings) {
  if (request.method != "GET" && request.method != "HEAD") {
    return ViewRefusal{kNotAllowed, "only GET"};
  }
  if (!request.target.starts_with('/') || request.target.size() > kMaxTarget) {
    return ViewRefusal{kBad, "not a path"};
  }
  if (request.hosts != 1) return ViewRefusal{kBad, "one Host is needed"};
  if (!is_address_or_localhost(request.host)) {
    return ViewRefusal{kForbidden, "Host must be an address or localhost"};
  }
  const auto& allowed = settings.allowed_origins;
  if (!request.origin.empty() && request.origin != "http://" + std::string(request.host) &&
      std::find(allowed.begin(), allowed.end(), request.origin) == allowed.end()) {
    return ViewRefusal{kForbidden, "a page of another origin"};
  }
  if (!settings.token.empty() && !equals(token_of(request.target), settings.token) &&
      !equals(token_in(request.cookie), settings.token)) {
    return ViewRefusal{kUnauthorized, "the token is missing or wrong"};
  }
  return std::nullopt;
}

}  // namespace infuse::daemon
