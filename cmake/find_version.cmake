# INFUSE_VERSION of the sources in SOURCES, whose next release is NEXT: 0.2.0~git20261127.566adb79, with date and hash of
# the commit. INFUSE_COMMIT_DATE: as changelogs have it. Git knows the commit; a source archive has it in
# cmake/commit.txt, where `git archive` writes it. As a script it prints the version:
#   cmake -D SOURCES=. -D NEXT=0.2.0 -P cmake/find_version.cmake
find_package(Git QUIET)
if(GIT_FOUND AND EXISTS ${SOURCES}/.git)
  execute_process(COMMAND ${GIT_EXECUTABLE} log -1 --format=%cs\ %H\ %cD WORKING_DIRECTORY ${SOURCES}
    OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE)
else()
  file(READ ${SOURCES}/cmake/commit.txt commit)
  string(STRIP "${commit}" commit)
endif()
if(commit MATCHES "^([0-9]+)-([0-9]+)-([0-9]+) ([0-9a-f]+) (.+)$")
  string(SUBSTRING ${CMAKE_MATCH_4} 0 8 hash)
  set(INFUSE_VERSION ${NEXT}~git${CMAKE_MATCH_1}${CMAKE_MATCH_2}${CMAKE_MATCH_3}.${hash})
  set(INFUSE_COMMIT_DATE ${CMAKE_MATCH_5})
else()
  set(INFUSE_VERSION ${NEXT}~dev)
  set(INFUSE_COMMIT_DATE "Thu, 01 Jan 1970 00:00:00 +0000")
  message(WARNING "the commit of these sources is not known: the version is ${INFUSE_VERSION}")
endif()
if(CMAKE_SCRIPT_MODE_FILE)
  message(NOTICE ${INFUSE_VERSION})
endif()
