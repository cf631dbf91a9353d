#include "daemon/config/view_settings.hpp"

#include <algorithm>
#include <boost/asio/ip/address.hpp>
#include <cctype>

namespace infuse::daemon {
namespace {

constexpr size_t kMinTokenBytes = 16, kMaxTokenBytes = 128;
constexpr size_t kMaxViewClients = 64;

bool is_token(const std::string& text) {
  return text.size() >= kMinTokenBytes && text.size() <= kMaxTokenBytes &&
         std::all_of(text.begin(), text.end(), [](unsigned char each) {
           return std::isalnum(each) != 0 || each == '-' || each == '_';
         });
}

}  // namespace

std::optional<std::string> ViewSettings::invalid() const {
  if (!path.empty() && path.front() != '/') return "path must begin with /";
  boost::system::error_code failed;
  const auto address = boost::asio::ip::make_address(bind, failed);
  if (failed) return "bind must be an address of this host";
  if (!token.empty() && !is_token(token)) {
    return "token must have 16 to 128 letters, digits, - or _";
  }
  if (!address.is_loopback() && token.empty()) return "bind beyond the loopback needs a token";
  for (const std::string& origin : allowed_origins) {
    if (origin.rfind("http://", 0) != 0 && origin.rfind("https://", 0) != 0) {
      return "allowed_origins must begin with http:// or https://";
    }
  }
  if (max_clients == 0 || max_clients > kMaxViewClients) {
    return "max_clients must be between 1 and 64";
  }
  return std::nullopt;
}

}  // namespace infuse::daemon
