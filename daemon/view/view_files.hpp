#pragma once

#include <span>
#include <string_view>

namespace infuse::daemon {

/// A file of the page.
struct ViewFile {
  std::string_view name, text;
};

/// The files of daemon/view/page, and the charts of daemon/pages; cmake puts them into the program
/// (cmake/view_page.cmake).
std::span<const ViewFile> view_files();

}  // namespace infuse::daemon
