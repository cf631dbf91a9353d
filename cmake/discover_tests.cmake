# Read by ctest when it starts, by build/tests.cmake: makes an entry of every suite of a test program, whose tests run in one
# process, and of every script. INFUSE_TEST_REGEX in the environment selects tests by FOLDER/Suite.Test and scripts by
# their names. Where the build has a sanitizer, tests in tests/not_sanitized.txt are left out unless they are selected.
cmake_policy(VERSION 3.25)

set(selection "$ENV{INFUSE_TEST_REGEX}")

# What is left out of this build: INFUSE_LEFT_OUT is a file of lines "FOLDER/Suite[.Test]  # reason", or empty.
set(left_out "")
set(found "")  # of these, by now
if(INFUSE_LEFT_OUT AND NOT selection)
  file(STRINGS ${INFUSE_LEFT_OUT} left_out REGEX "^tests/")
  list(TRANSFORM left_out REPLACE "[ \t]+#.*" "")
endif()

# names_of(PROGRAM VARIABLE): lines "Suite." and "  Test", kept beside the program until it is built again.
function(names_of program variable)
  set(list ${program}.tests)
  if(NOT EXISTS ${list} OR ${program} IS_NEWER_THAN ${list})
    execute_process(COMMAND ${INFUSE_EMULATOR} ${program} --gtest_list_tests OUTPUT_VARIABLE text
      COMMAND_ERROR_IS_FATAL ANY)
    string(REGEX REPLACE " *#[^\n]*" "" text "${text}")  # types and parameters
    file(WRITE ${list} "${text}")
  endif()
  file(STRINGS ${list} lines REGEX "^[^ ]+\\.$|^  [^ ]+$")
  set(${variable} "${lines}" PARENT_SCOPE)
endfunction()

# add_suite(FOLDER PROGRAM LABELS SUITE ALL TEST...): ALL: nothing of it is left out.
function(add_suite folder program labels suite all)
  if("${ARGN}" STREQUAL "")
    return()
  endif()
  set(filter ${suite}.*)
  if(NOT all)
    list(JOIN ARGN ":" filter)
  endif()
  add_test(${folder}/${suite} ${INFUSE_EMULATOR} ${program} --gtest_filter=${filter}
    --gtest_output=xml:${INFUSE_RESULTS}/${folder}/${suite}.xml)
  set_tests_properties(${folder}/${suite} PROPERTIES TIMEOUT 1200 LABELS "${labels}")
endfunction()

# infuse_suites(FOLDER PROGRAM LABELS): the tests of one program.
function(infuse_suites folder program labels)
  if(NOT EXISTS ${program})
    if(NOT selection)
      add_test(${folder} ${program})  # fails: it was not built
    endif()
    return()
  endif()
  names_of(${program} names)
  set(suite "")
  foreach(name IN LISTS names ITEMS "end.")
    if(name MATCHES "^([^ ]+)\\.$")
      if(NOT suite STREQUAL "")
        add_suite(${folder} ${program} "${labels}" ${suite} ${all} ${tests})
      endif()
      set(suite ${CMAKE_MATCH_1})
      # As the source has it: without the name of an instance and the number of a type.
      string(REGEX REPLACE "/[0-9]+$" "" plain ${suite})
      string(REGEX REPLACE "^.*/" "" plain ${plain})
      set(tests "")
      set(all TRUE)
    else()
      string(STRIP ${name} name)
      set(test ${folder}/${suite}.${name})
      if(${folder}/${plain}.${name} IN_LIST left_out OR ${folder}/${plain} IN_LIST left_out)
        list(APPEND found ${folder}/${plain}.${name} ${folder}/${plain})
        set(all FALSE)
      elseif(selection AND NOT "${test} ${folder}/${plain}.${name}" MATCHES "${selection}")
        set(all FALSE)
      else()
        list(APPEND tests ${suite}.${name})
      endif()
    endif()
  endforeach()
  set(found ${found} PARENT_SCOPE)
endfunction()

# infuse_check_left_out(): an entry that fails for every line of INFUSE_LEFT_OUT that names no test. After all programs.
function(infuse_check_left_out)
  set(unknown ${left_out})
  list(REMOVE_ITEM unknown "" ${found})
  foreach(line IN LISTS unknown)
    add_test("no such test: ${line}" false)
  endforeach()
endfunction()

# infuse_script(NAME TIMEOUT SERIAL COMMAND...): a test that is no test program; exit status 77 is "skipped".
function(infuse_script name timeout serial)
  if(selection AND NOT name MATCHES "${selection}")
    return()
  endif()
  add_test(${name} ${ARGN})
  set_tests_properties(${name} PROPERTIES SKIP_RETURN_CODE 77 TIMEOUT ${timeout} RUN_SERIAL ${serial})
endfunction()
