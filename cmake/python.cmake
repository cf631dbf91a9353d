# The Python module (packaging/python): the package python3-infuse, and build/python for tests. Of Debian's Python, whatever
# others are on the path.

set(PYBIND11_FINDPYTHON ON)
set(Python_EXECUTABLE /usr/bin/python3)
find_package(pybind11 QUIET)
if(NOT pybind11_FOUND)
  message(STATUS "no Python module: pybind11-dev is not installed")
  return()
endif()
set(python ${PROJECT_SOURCE_DIR}/packaging/python)
file(GLOB sources CONFIGURE_DEPENDS ${python}/*.cpp)
pybind11_add_module(infuse_python MODULE NO_EXTRAS ${sources})
target_link_libraries(infuse_python PRIVATE infuse::flags infuse_version infuse::daemon_tools_calibrate infuse::daemon_streetmap
  infuse::drivers_import infuse::fusion_registration infuse::fusion_places_visual infuse::study_dependence
  infuse::study_calibration)
# What the module holds of other libraries is its own.
target_link_options(infuse_python PRIVATE -Wl,--exclude-libs,ALL -Wl,--gc-sections -Wl,--as-needed)
target_compile_options(infuse_python PRIVATE ${INFUSE_COLD_OPTIONS})
set_target_properties(infuse_python PROPERTIES OUTPUT_NAME _infuse CXX_VISIBILITY_PRESET hidden
  UNITY_BUILD ${INFUSE_UNITY} UNITY_BUILD_BATCH_SIZE 12 LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/python/infuse)
file(GLOB modules CONFIGURE_DEPENDS ${python}/infuse/*.py ${python}/infuse/*.pyi ${python}/infuse/py.typed)
file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/python/infuse)
foreach(module ${modules})
  get_filename_component(name ${module} NAME)
  file(CREATE_LINK ${module} ${CMAKE_BINARY_DIR}/python/infuse/${name} SYMBOLIC)
endforeach()
# Of infuse.results.
file(GLOB schemas CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/daemon/results/*.schema.json)
file(CREATE_LINK ${PROJECT_SOURCE_DIR}/daemon/results ${CMAKE_BINARY_DIR}/python/infuse/schemas SYMBOLIC)
set(packages lib/python3/dist-packages/infuse)
install(TARGETS infuse_python LIBRARY DESTINATION ${packages} COMPONENT python EXCLUDE_FROM_ALL)
install(FILES ${modules} DESTINATION ${packages} COMPONENT python EXCLUDE_FROM_ALL)
install(FILES ${schemas} DESTINATION ${packages}/schemas COMPONENT python EXCLUDE_FROM_ALL)
