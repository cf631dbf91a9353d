# How a folder of the house becomes a target, and the one place where compiler flags are set.

add_library(infuse_flags INTERFACE)
add_library(infuse::flags ALIAS infuse_flags)
target_include_directories(infuse_flags INTERFACE ${PROJECT_SOURCE_DIR})
# -ffp-contract=off: a fused multiply-add rounds once where two instructions round twice, so a replay
# would give other bytes on a processor that has it. -fno-math-errno: nobody reads errno after sqrt.
# -Wno-missing-field-initializers: options are written as {.bins = 16}, and what is left out has its default.
# -Wno-restrict: g++ 12 takes text + std::string for an overlapping copy (its bug 105651).
# -Wno-psabi: vectors wider than the baseline's registers are passed between inlined functions only.
target_compile_options(infuse_flags INTERFACE
  -Wall -Wextra -Wconversion -Wshadow -Werror -Wno-missing-field-initializers -Wno-psabi
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict> -ffp-contract=off -fno-math-errno)
# The text of __FILE__, which every assertion of a test holds, begins at the project's folder: so the compiler's cache
# serves every checkout.
target_compile_options(infuse_flags INTERFACE -ffile-prefix-map=${PROJECT_SOURCE_DIR}/=)
# g++ collects garbage again and again, a tenth of the compilation; a file takes up to 1.7 GB without.
target_compile_options(infuse_flags INTERFACE $<$<CXX_COMPILER_ID:GNU>:--param=ggc-min-heapsize=1000000>)
if(CMAKE_SYSTEM_PROCESSOR MATCHES "aarch64|arm64")
  target_include_directories(infuse_flags SYSTEM BEFORE INTERFACE ${PROJECT_SOURCE_DIR}/cmake/arm64)  # arm_neon.h
endif()
# Of the presets asan and tsan: they compile everything again, so little optimisation and short debug info.
set(CMAKE_CXX_FLAGS_SANITIZE "-O1 -g1")
if(INFUSE_SANITIZE)
  # g++ 12 warns falsely about its own library when sanitizers change the inlining. A check of every pointer takes it
  # as long as everything else. The address sanitizer stops at null too; alignment is left to the fuzzers, which clang
  # compiles and which reach what is parsed.
  target_compile_options(infuse_flags INTERFACE -fsanitize=${INFUSE_SANITIZE}
    -fno-sanitize-recover=all -fno-omit-frame-pointer
    $<$<CXX_COMPILER_ID:GNU>:-fno-sanitize=null,alignment -Wno-maybe-uninitialized -Wno-tsan -Wno-stringop-overflow -Wno-array-bounds>)
  target_link_options(infuse_flags INTERFACE -fsanitize=${INFUSE_SANITIZE})
  find_program(INFUSE_MOLD mold)
  if(INFUSE_MOLD)  # seventy programs with debug information; those of a release are a twentieth larger by it
    target_link_options(infuse_flags INTERFACE -fuse-ld=mold)
  endif()
  # Eigen allocates in another way where it sees the address sanitizer; templates that the static Ceres brings, compiled
  # without, would free what it allocated.
  target_compile_definitions(infuse_flags INTERFACE EIGEN_MALLOC_ALREADY_ALIGNED=1)
endif()

if(INFUSE_FUZZ)
  # Coverage of the libraries too: without it a fuzzer does not see where its input leads.
  target_compile_options(infuse_flags INTERFACE -fsanitize=fuzzer-no-link)
endif()

# Libraries are position-independent: others link them into theirs (library.cmake), and Python loads them. A function of
# the same file is inlined as if they were not.
set(INFUSE_LIBRARY_OPTIONS $<$<CONFIG:Release>:-fPIC> $<$<CONFIG:Release>:-fno-semantic-interposition>)
# What does not run for each measurement is optimised little: that takes two thirds of the time.
set(INFUSE_COLD_OPTIONS $<$<CONFIG:Release>:-O1> ${INFUSE_LIBRARY_OPTIONS})

# Precompiled headers: every file parses the standard library and Eigen otherwise, which takes longer than the file
# itself. One for what runs for each measurement, one for what does not, one for daemon/ with the libraries that it uses
# beside them, and one for the tests. g++ optimises a file as it did its precompiled header, whatever its own options:
# a header is of one kind or the other.
if(NOT EXISTS ${CMAKE_BINARY_DIR}/precompiled.cpp)  # written anew, it would be compiled anew with all that includes it
  file(WRITE ${CMAKE_BINARY_DIR}/precompiled.cpp "")
endif()
function(infuse_precompiled name)
  add_library(${name} OBJECT ${CMAKE_BINARY_DIR}/precompiled.cpp)
  target_link_libraries(${name} PRIVATE infuse::flags Eigen3::Eigen tl::expected)
  target_precompile_headers(${name} PRIVATE <algorithm> <array> <atomic> <chrono> <cmath> <cstdint> <deque>
    <filesystem> <functional> <limits> <map> <memory> <numbers> <numeric> <optional> <random> <set>
    <span> <string> <string_view> <thread> <unordered_map> <utility> <variant> <vector> <Eigen/Dense> <tl/expected.hpp>
    ${ARGN})
endfunction()
infuse_precompiled(infuse_pch)
target_compile_options(infuse_pch PRIVATE ${INFUSE_LIBRARY_OPTIONS})
infuse_precompiled(infuse_cold_pch)
target_compile_options(infuse_cold_pch PRIVATE ${INFUSE_COLD_OPTIONS})

# The parts of Asio and Beast that are not templates, compiled once.
add_library(infuse_network STATIC daemon/network_library.cpp)
target_link_libraries(infuse_network PUBLIC $<BUILD_INTERFACE:infuse::flags> $<BUILD_INTERFACE:Boost::headers>
  Threads::Threads)
target_compile_definitions(infuse_network PUBLIC BOOST_ASIO_SEPARATE_COMPILATION BOOST_BEAST_SEPARATE_COMPILATION)
target_compile_options(infuse_network PRIVATE ${INFUSE_COLD_OPTIONS})

# What the folders of daemon/ use.
add_library(infuse_daemon_base INTERFACE)
target_link_libraries(infuse_daemon_base INTERFACE infuse_network spdlog::spdlog nlohmann_json::nlohmann_json)
infuse_precompiled(infuse_daemon_pch <sstream> <nlohmann/json.hpp> <spdlog/spdlog.h> <spdlog/fmt/fmt.h>
  <boost/asio/generic/stream_protocol.hpp> <boost/asio/io_context.hpp> <boost/asio/steady_timer.hpp>)
target_link_libraries(infuse_daemon_pch PRIVATE infuse_daemon_base)
target_compile_options(infuse_daemon_pch PRIVATE ${INFUSE_COLD_OPTIONS})

# Most of a file's compilation goes into headers and templates that its neighbours use too, so that compiling the files
# of a folder together takes half the time. Who changes one file all day compiles it by itself: -DINFUSE_UNITY=OFF.
option(INFUSE_UNITY "compile the files of a folder together" ON)

# infuse_library(drivers/velodyne [COLD] DEPENDENCY...): all .cpp files of the folder but tests, as
# infuse::drivers_velodyne. COLD: nothing in it takes long for each measurement, as all of daemon/.
function(infuse_library folder)
  cmake_parse_arguments(ARG "COLD" "" "" ${ARGN})
  set(batch 12)
  string(REPLACE "/" "_" name ${folder})
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${folder}/*.cpp)
  list(FILTER sources EXCLUDE REGEX "_test\\.cpp$")
  add_library(infuse_${name} STATIC ${sources})
  add_library(infuse::${name} ALIAS infuse_${name})
  target_link_libraries(infuse_${name} PUBLIC $<BUILD_INTERFACE:infuse::flags> ${ARG_UNPARSED_ARGUMENTS})
  if(folder MATCHES "^daemon/")
    set(ARG_COLD TRUE)
    set(batch 20)
    target_link_libraries(infuse_${name} PUBLIC infuse_daemon_base)
    target_precompile_headers(infuse_${name} REUSE_FROM infuse_daemon_pch)
  elseif(ARG_COLD)
    target_precompile_headers(infuse_${name} REUSE_FROM infuse_cold_pch)
  else()
    target_precompile_headers(infuse_${name} REUSE_FROM infuse_pch)
    target_compile_options(infuse_${name} PRIVATE ${INFUSE_LIBRARY_OPTIONS})
  endif()
  if(ARG_COLD)
    target_compile_options(infuse_${name} PRIVATE ${INFUSE_COLD_OPTIONS})
  endif()
  set_target_properties(infuse_${name} PROPERTIES UNITY_BUILD ${INFUSE_UNITY} UNITY_BUILD_BATCH_SIZE ${batch})
endfunction()

# infuse_program(infused daemon/infused.cpp DEPENDENCY...): one program in build/bin. cmake/package.cmake installs it.
function(infuse_program name source)
  add_executable(${name} ${source})
  target_link_libraries(${name} PRIVATE infuse_daemon_base ${ARGN})
  target_precompile_headers(${name} REUSE_FROM infuse_daemon_pch)
  target_compile_options(${name} PRIVATE ${INFUSE_COLD_OPTIONS})
endfunction()

# infuse_tool(calibrate_target DEPENDENCY...): the folder daemon/tools/NAME as a library of the program of all tools.
set(INFUSE_TOOLS ${CMAKE_BINARY_DIR}/libexec/infuse)
function(infuse_tool name)
  infuse_library(daemon/tools/${name} infuse::daemon_command_line ${ARGN})
  string(REPLACE "_" "-" link infuse-${name})
  set_property(GLOBAL APPEND PROPERTY INFUSE_TOOL_LIBRARIES infuse::daemon_tools_${name})
  set_property(GLOBAL APPEND PROPERTY INFUSE_TOOL_LINKS ${INFUSE_TOOLS}/${link})
endfunction()

# infuse_tools_program(daemon/tools/infuse_tools.cpp): that program, with a link for each tool, which `infuse NAME` finds in
# libexec/infuse beside bin.
function(infuse_tools_program source)
  get_property(libraries GLOBAL PROPERTY INFUSE_TOOL_LIBRARIES)
  infuse_program(infuse-tools ${source} ${libraries})
  set_target_properties(infuse-tools PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${INFUSE_TOOLS} OUTPUT_NAME tools)
  get_property(links GLOBAL PROPERTY INFUSE_TOOL_LINKS)
  foreach(link ${links})
    add_custom_command(TARGET infuse-tools POST_BUILD COMMAND ${CMAKE_COMMAND} -E create_symlink tools ${link})
  endforeach()
endfunction()

# Where tests and benchmarks find the source tree and the programs.
add_library(infuse_test_folders STATIC EXCLUDE_FROM_ALL tests/folders.cpp)
target_link_libraries(infuse_test_folders PUBLIC infuse::flags)
target_compile_definitions(infuse_test_folders PRIVATE INFUSE_SOURCE_DIR="${PROJECT_SOURCE_DIR}"
  INFUSE_BINARIES="${INFUSE_PROGRAMS}")

# infuse_test(tests/drivers/velodyne [THREADED] [ALLOCATIONS] DEPENDENCY...): all *_test.cpp of the folder, as one program.
# THREADED: it shares memory between threads, so the thread sanitizer runs it too. ALLOCATIONS: it counts allocations
# (tests/allocation_counter.hpp). The tests of a suite run in one process and share what its set-up makes, such as a drive.
add_custom_target(test_programs)
# Replacements of operator new do not go with files that use it.
set_source_files_properties(tests/allocation_counter.cpp tests/early_logger.cpp PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
function(infuse_test folder)
  cmake_parse_arguments(ARG "THREADED;ALLOCATIONS" "" "" ${ARGN})
  string(REPLACE "/" "_" name ${folder})
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${folder}/*_test.cpp)
  add_executable(${name} ${sources})
  add_dependencies(test_programs ${name})
  target_link_libraries(${name} PRIVATE infuse::flags infuse_test_folders GTest::gtest_main GTest::gmock
    ${ARG_UNPARSED_ARGUMENTS})
  if(NOT TARGET infuse_test_pch)
    infuse_precompiled(infuse_test_pch <gmock/gmock.h> <gtest/gtest.h>)
    target_link_libraries(infuse_test_pch PRIVATE GTest::gtest_main GTest::gmock)
    target_compile_options(infuse_test_pch PRIVATE -O1)
  endif()
  target_compile_options(${name} PRIVATE -O1)  # what is tested is optimised, the tests need not be
  target_precompile_headers(${name} REUSE_FROM infuse_test_pch)
  set_target_properties(${name} PROPERTIES UNITY_BUILD ${INFUSE_UNITY} UNITY_BUILD_BATCH_SIZE 6)
  if(ARG_ALLOCATIONS)
    target_sources(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests/allocation_counter.cpp)
  endif()
  set(label "")
  if(ARG_THREADED)
    set(label threaded)
    target_sources(${name} PRIVATE ${PROJECT_SOURCE_DIR}/tests/early_logger.cpp)
    target_link_libraries(${name} PRIVATE spdlog::spdlog)
  endif()
  set_property(GLOBAL APPEND_STRING PROPERTY INFUSE_TESTS
    "infuse_suites(${folder} \"$<TARGET_FILE:${name}>\" \"${label}\")\n")
  set_property(GLOBAL APPEND_STRING PROPERTY INFUSE_TEST_TARGETS "${folder}|${label}|${name}\n")
endfunction()

# infuse_script(tests/npm [SERIAL] [TIMEOUT SECONDS] [NEEDS TARGET...] COMMAND WORD...): a test that is a script, below the
# root; status 77 is "skipped". NEEDS: programs that it runs.
function(infuse_script name)
  cmake_parse_arguments(ARG "SERIAL" "TIMEOUT" "NEEDS;COMMAND" ${ARGN})
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 600)
  endif()
  if(ARG_NEEDS)
    add_dependencies(test_programs ${ARG_NEEDS})
  endif()
  list(JOIN ARG_COMMAND "\" \"" command)
  set_property(GLOBAL APPEND_STRING PROPERTY INFUSE_TESTS
    "infuse_script(${name} ${ARG_TIMEOUT} ${ARG_SERIAL} \"${PROJECT_SOURCE_DIR}/${command}\")\n")
  list(JOIN ARG_NEEDS " " needs)
  set_property(GLOBAL APPEND_STRING PROPERTY INFUSE_TEST_TARGETS "${name}||${needs}\n")
endfunction()

# infuse_write_tests(): build/tests.cmake, by which ctest finds the tests when it starts, and build/test_targets, by which
# ./dev builds what a test needs: lines NAME|LABEL|TARGETS.
function(infuse_write_tests)
  get_property(tests GLOBAL PROPERTY INFUSE_TESTS)
  get_property(targets GLOBAL PROPERTY INFUSE_TEST_TARGETS)
  set(left_out "")
  if(INFUSE_SANITIZE)
    set(left_out ${PROJECT_SOURCE_DIR}/tests/not_sanitized.txt)
  endif()
  file(GENERATE OUTPUT ${CMAKE_BINARY_DIR}/tests.cmake CONTENT "set(INFUSE_EMULATOR ${CMAKE_CROSSCOMPILING_EMULATOR})
set(INFUSE_RESULTS \"${CMAKE_BINARY_DIR}/Testing/results\")
set(INFUSE_LEFT_OUT \"${left_out}\")
include(\"${PROJECT_SOURCE_DIR}/cmake/discover_tests.cmake\")
${tests}infuse_check_left_out()
")
  file(GENERATE OUTPUT ${CMAKE_BINARY_DIR}/test_targets CONTENT "${targets}")
  set_property(DIRECTORY PROPERTY TEST_INCLUDE_FILES ${CMAKE_BINARY_DIR}/tests.cmake)
endfunction()

# infuse_bench(tests/bench/decode_bench.cpp DEPENDENCY...): a Google Benchmark program in build/bin.
function(infuse_bench source)
  get_filename_component(name ${source} NAME_WE)
  add_executable(${name} ${source})
  target_link_libraries(${name} PRIVATE infuse::flags infuse_test_folders benchmark::benchmark_main ${ARGN})
endfunction()

# infuse_fuzzer(tests/fuzz/decoder_fuzz.cpp DEPENDENCY...): with INFUSE_FUZZ, a libFuzzer program, built by the target
# fuzzers; otherwise a part of tests_fuzz, which runs all of them on their corpus, each under its own name.
function(infuse_fuzzer source)
  get_filename_component(name ${source} NAME_WE)
  if(NOT INFUSE_FUZZ)
    target_sources(tests_fuzz PRIVATE ${source})
    set_source_files_properties(${source} PROPERTIES COMPILE_DEFINITIONS LLVMFuzzerTestOneInput=${name})
    target_link_libraries(tests_fuzz PRIVATE ${ARGN})
    set_property(GLOBAL APPEND_STRING PROPERTY INFUSE_FUZZERS "INFUSE_FUZZER(${name})\n")
    return()
  endif()
  add_executable(${name} ${source})
  target_compile_options(${name} PRIVATE -fsanitize=fuzzer)
  add_dependencies(fuzzers ${name})
  target_link_options(${name} PRIVATE -fsanitize=fuzzer)
  target_link_libraries(${name} PRIVATE infuse::flags ${ARGN})
endfunction()
