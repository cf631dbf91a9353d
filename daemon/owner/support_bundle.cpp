#include "daemon/owner/support_bundle.hpp"

#include <spdlog/fmt/fmt.h>
#include <zstd.h>

#include <ctime>
#include <regex>
#include <span>

#include "drivers/recording/atomic_file.hpp"

namespace infuse::daemon {
namespace {

constexpr size_t kBlock = 512;  // bytes, of tar
constexpr size_t kMaxName = 99;

/// The header of a file: fields of fixed places, numbers in octal (POSIX.1-2001, pax, "ustar").
std::string header_of(const std::string& name, size_t bytes) {
  std::string header(kBlock, '\0');
  const auto put = [&](size_t at, const std::string& text) {
    header.replace(at, text.size(), text);
  };
  put(0, name.substr(0, kMaxName));
  put(100, "0000600");
  put(108, "0000000");
  put(116, "0000000");
  put(124, fmt::format("{:011o}", bytes));
  put(136, fmt::format("{:011o}", static_cast<uint64_t>(std::time(nullptr))));
  put(148, "        ");  // of the sum itself
  put(156, "0");
  put(257, std::string("ustar\00000", 8));
  unsigned sum = 0;
  for (const char c : header) sum += static_cast<unsigned char>(c);
  put(148, fmt::format("{:06o}", sum) + std::string("\0 ", 2));
  return header;
}

}  // namespace

void SupportBundle::hide_secrets_of(std::string_view config) {
  static const std::regex kSecrets(
      R"((?:^|[\n{,])\s*(?:token|password|secret)\s*=\s*["']([^"'\n]{1,200})["']|://[^\s/"'@:]*:([^\s/"'@]{1,200})@)");
  const std::string text(config);
  for (std::sregex_iterator at(text.begin(), text.end(), kSecrets), end; at != end; ++at) {
    secrets_.push_back((*at)[1].matched ? (*at)[1].str() : (*at)[2].str());
  }
}

void SupportBundle::add(const std::string& name, std::string text) {
  for (const std::string& secret : secrets_) {
    constexpr std::string_view kLeftOut = "(left out)";
    for (size_t at = text.find(secret); at != std::string::npos;
         at = text.find(secret, at + kLeftOut.size())) {
      text.replace(at, secret.size(), kLeftOut);
    }
  }
  entries_.push_back({name, std::move(text)});
}

std::string SupportBundle::tar(const std::string& folder) const {
  std::string archive;
  for (const Entry& entry : entries_) {
    archive += header_of(folder + "/" + entry.name, entry.text.size()) + entry.text;
    archive.resize((archive.size() + kBlock - 1) / kBlock * kBlock, '\0');
  }
  return archive.append(2 * kBlock, '\0');
}

Result<void> SupportBundle::write(const std::filesystem::path& file) const {
  const std::string name = file.filename().string();
  const std::string archive = tar(name.substr(0, name.find('.')));
  std::string packed(ZSTD_compressBound(archive.size()), '\0');
  constexpr int kLevel = 9;
  const size_t size =
      ZSTD_compress(packed.data(), packed.size(), archive.data(), archive.size(), kLevel);
  if (ZSTD_isError(size) != 0) return fail("cannot be compressed", file.string());
  packed.resize(size);
  return recording::write_file_atomically(file, std::as_bytes(std::span(packed)), 0600);
}

}  // namespace infuse::daemon
