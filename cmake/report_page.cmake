# Puts the files of daemon/pages/page into a header, so that the page needs no files at run time.
set(page ${PROJECT_SOURCE_DIR}/daemon/pages/page)
file(READ ${page}/body.html PAGE_BODY)
file(READ ${page}/style.css PAGE_STYLE)
file(READ ${page}/charts.js PAGE_CHARTS)
file(READ ${page}/report.js PAGE_CODE)
configure_file(${PROJECT_SOURCE_DIR}/daemon/pages/page_files.hpp.in
  ${CMAKE_BINARY_DIR}/made/daemon/pages/page_files.hpp @ONLY)
set_property(DIRECTORY ${PROJECT_SOURCE_DIR} APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS
  ${page}/body.html ${page}/style.css ${page}/charts.js ${page}/report.js)
target_include_directories(infuse_daemon_pages PRIVATE ${CMAKE_BINARY_DIR}/made)
