# Puts the files of daemon/view/page, and the charts of daemon/pages, into a header.
set(page ${PROJECT_SOURCE_DIR}/daemon/view/page)
set(charts ${PROJECT_SOURCE_DIR}/daemon/pages/page/charts.js)
file(READ ${page}/view.html VIEW_PAGE)
file(READ ${page}/icon.svg VIEW_ICON)
file(READ ${page}/style.css VIEW_STYLE)
file(READ ${charts} VIEW_CHARTS)
file(READ ${page}/scene.js VIEW_SCENE)
file(READ ${page}/profile.js VIEW_PROFILE)
file(READ ${page}/overlay.js VIEW_OVERLAY)
file(READ ${page}/image_colours.js VIEW_IMAGE_COLOURS)
file(READ ${page}/history.js VIEW_HISTORY)
file(READ ${page}/player.js VIEW_PLAYER)
file(READ ${page}/view.js VIEW_CODE)
configure_file(${PROJECT_SOURCE_DIR}/daemon/view/view_files.hpp.in
  ${CMAKE_BINARY_DIR}/made/daemon/view/view_files.hpp @ONLY)
set_property(DIRECTORY ${PROJECT_SOURCE_DIR} APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS
  ${page}/view.html ${page}/icon.svg ${page}/style.css ${page}/scene.js ${page}/profile.js ${page}/overlay.js ${page}/image_colours.js
  ${page}/player.js ${page}/history.js ${page}/view.js)
target_include_directories(infuse_daemon_view PRIVATE ${CMAKE_BINARY_DIR}/made)
