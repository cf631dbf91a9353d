# INFUSE_PROGRAMS: the folder in which tests find the programs that they start. Of another processor, they are scripts
# that start the program in its emulator, so that nothing depends on what the kernel has registered for its format.
set(INFUSE_PROGRAMS ${CMAKE_RUNTIME_OUTPUT_DIRECTORY})
if(CMAKE_CROSSCOMPILING AND CMAKE_CROSSCOMPILING_EMULATOR)
  set(INFUSE_PROGRAMS ${CMAKE_BINARY_DIR}/emulated)
  list(JOIN CMAKE_CROSSCOMPILING_EMULATOR " " emulator)
  foreach(program infused infuse infuse-simulate infuse-make-capture infuse-send-capture)
    file(WRITE ${INFUSE_PROGRAMS}/${program}
      "#!/bin/sh\nexec ${emulator} ${CMAKE_RUNTIME_OUTPUT_DIRECTORY}/${program} \"$@\"\n")
    file(CHMOD ${INFUSE_PROGRAMS}/${program} PERMISSIONS
      OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
  endforeach()
  # A test program is asked for its tests when they are run, not after it was linked.
  set(CMAKE_GTEST_DISCOVER_TESTS_DISCOVERY_MODE PRE_TEST)
endif()
