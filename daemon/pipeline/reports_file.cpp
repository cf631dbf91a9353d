#include "daemon/pipeline/reports_file.hpp"

#include <cerrno>
#include <cstring>

namespace infuse::daemon {

Result<ReportsFile> ReportsFile::create(const std::filesystem::path& path) {
  std::FILE* file = std::fopen(path.c_str(), "we");
  if (file == nullptr) {
    return fail(std::string("cannot create the reports file: ") + std::strerror(errno),
                path.string(), "choose a file in an existing folder");
  }
  return ReportsFile(file, path);
}

void ReportsFile::write(std::string_view message) {
  if (error_) return;
  if (std::fwrite(message.data(), 1, message.size(), file_.get()) != message.size() ||
      std::fputc('\n', file_.get()) == EOF) {
    set_error();
  }
}

void ReportsFile::set_error() {
  error_ = Error{std::string("cannot write the reports file: ") + std::strerror(errno),
                 path_.string(), "check the free disk space"};
}

Result<void> ReportsFile::close() {
  if (!error_ && std::fflush(file_.get()) != 0) set_error();
  if (error_) return tl::unexpected(*error_);
  return {};
}

}  // namespace infuse::daemon
