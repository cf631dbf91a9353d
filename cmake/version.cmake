# INFUSE_VERSION: what the next release is called, with date and hash of the commit, as 0.2.0~git20261127.566adb79; the
# same in programs, reports and packages. INFUSE_COMMIT_DATE: as changelogs have it. Git knows the commit; a source
# archive has it in cmake/commit.txt, where `git archive` writes it. The build asks again when another commit is checked
# out, and compiles one small file for it.
find_package(Git QUIET)
set(commit "")
if(GIT_FOUND AND EXISTS ${PROJECT_SOURCE_DIR}/.git)
  execute_process(COMMAND ${GIT_EXECUTABLE} log -1 --format=%cs\ %H\ %cD WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}
    OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE)
  execute_process(COMMAND ${GIT_EXECUTABLE} rev-parse --path-format=absolute --git-path logs/HEAD
    WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} OUTPUT_VARIABLE moves OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(EXISTS "${moves}")
    set_property(DIRECTORY ${PROJECT_SOURCE_DIR} APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${moves})
  endif()
else()
  file(READ ${PROJECT_SOURCE_DIR}/cmake/commit.txt commit)
endif()
if(commit MATCHES "^([0-9]+)-([0-9]+)-([0-9]+) ([0-9a-f]+) (.+)$")
  string(SUBSTRING ${CMAKE_MATCH_4} 0 8 hash)
  set(INFUSE_VERSION ${PROJECT_VERSION}~git${CMAKE_MATCH_1}${CMAKE_MATCH_2}${CMAKE_MATCH_3}.${hash})
  set(INFUSE_COMMIT_DATE ${CMAKE_MATCH_5})
else()
  set(INFUSE_VERSION ${PROJECT_VERSION}~unknown)
  set(INFUSE_COMMIT_DATE "Thu, 01 Jan 1970 00:00:00 +0000")
  message(WARNING "the commit of these sources is not known: the version is ${INFUSE_VERSION}")
endif()
configure_file(${PROJECT_SOURCE_DIR}/cmake/version.cpp.in ${CMAKE_BINARY_DIR}/made/version.cpp @ONLY)
add_library(infuse_version STATIC ${CMAKE_BINARY_DIR}/made/version.cpp)
target_link_libraries(infuse_version PUBLIC infuse::flags)
