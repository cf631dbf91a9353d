# INFUSE_PROGRAMS: the folder in which tests find the programs that they start. Of another processor, they are scripts
# that start the program in its emulator, so that nothing depends on what the kernel has registered for its format.
set(INFUSE_PROGRAMS ${CMAKE_RUNTIME_OUTPUT_DIRECTORY})
if(CMAKE_CROSSCOMPILING AND CMAKE_CROSSCOMPILING_EMULATOR)
  set(INFUSE_PROGRAMS ${CMAKE_BINARY_DIR}/emulated)
  list(JOIN CMAKE_CROSSCOMPILING_EMULATOR " " emulator)
  # infuse finds the scripts of its tools in a folder of their own.
  function(emulate program folder into)
    file(WRITE ${into}/${program} "#!/bin/sh\nexport INFUSE_EXEC_PATH=${INFUSE_PROGRAMS}/tools\n"
      "exec ${emulator} ${folder}/${program} \"$@\"\n")
    file(CHMOD ${into}/${program} PERMISSIONS
      OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
  endfunction()
  foreach(program infused infuse infuse-simulate infuse-make-capture infuse-send-capture)
    emulate(${program} ${CMAKE_RUNTIME_OUTPUT_DIRECTORY} ${INFUSE_PROGRAMS})
  endforeach()
  foreach(tool align calibrate calibrate-intrinsics calibrate-target export fleet import map places)
    emulate(infuse-${tool} ${CMAKE_BINARY_DIR}/libexec/infuse ${INFUSE_PROGRAMS}/tools)
  endforeach()
  # A test program is asked for its tests when they are run, not after it was linked.
  set(CMAKE_GTEST_DISCOVER_TESTS_DISCOVERY_MODE PRE_TEST)
endif()
