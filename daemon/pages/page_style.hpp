#pragma once

namespace infuse::daemon {

/// The style sheet of the pages: colours for light and dark, tables, SVG texts.
const char* page_style();

}  // namespace infuse::daemon
