# The version (find_version.cmake) for programs, reports and packages. The build asks again when another commit is
# checked out, and compiles one small file for it.
set(SOURCES ${PROJECT_SOURCE_DIR})
set(NEXT ${PROJECT_VERSION})
include(cmake/find_version.cmake)
if(GIT_FOUND AND EXISTS ${PROJECT_SOURCE_DIR}/.git)
  execute_process(COMMAND ${GIT_EXECUTABLE} rev-parse --path-format=absolute --git-path logs/HEAD
    WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} OUTPUT_VARIABLE moves OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(EXISTS "${moves}")
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${moves})
  endif()
endif()
configure_file(cmake/version.cpp.in ${CMAKE_BINARY_DIR}/made/version.cpp @ONLY)
add_library(infuse_version STATIC ${CMAKE_BINARY_DIR}/made/version.cpp)
target_link_libraries(infuse_version PUBLIC infuse::flags)
target_compile_options(infuse_version PRIVATE ${INFUSE_LIBRARY_OPTIONS})
