# The library for others' programs (docs/library.md): the package libinfuse-dev. find_package(infuse) and pkg-config find it.

set(library ${PROJECT_SOURCE_DIR}/packaging/library)
set(installed COMPONENT library EXCLUDE_FROM_ALL)
set(headers ${CMAKE_INSTALL_INCLUDEDIR}/infuse/folders)  # headers of folders, below those of infuse/*.hpp
set(config ${CMAKE_INSTALL_LIBDIR}/cmake/infuse)
add_custom_target(library)  # all that is installed

# infuse_export(methods fusion/geometry ...): makes public libraries of folders, in one of two sets. drivers/makers is
# infuse::lidar, any other folder infuse::NAME. Sets infuse_methods_archives for pkg-config.
function(infuse_export set)
  set(archives "")
  foreach(folder ${ARGN})
    string(REPLACE "/" "_" target infuse_${folder})
    get_filename_component(name ${folder} NAME)
    if(folder STREQUAL "drivers/makers")
      set(name lidar)
    elseif(folder STREQUAL "drivers/lidar")
      set(name lidar_packets)
    endif()
    set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
    file(GLOB files CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/${folder}/*.hpp)
    list(FILTER files EXCLUDE REGEX "toml_library\\.hpp$")
    install(FILES ${files} DESTINATION ${headers}/${folder} ${installed})
    infuse_install_archive(${set} ${target})
    string(PREPEND archives "-l${target} ")  # the linker takes what is needed of those after it
  endforeach()
  set(infuse_${set}_archives "${archives}" PARENT_SCOPE)
endfunction()

# infuse_install_archive(methods TARGET)
function(infuse_install_archive set target)
  install(TARGETS ${target} EXPORT infuse_${set} ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} ${installed}
    INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} ${headers})
  add_dependencies(library ${target})
endfunction()

# Layer by layer. The methods need Eigen and tl::expected, which are headers.
infuse_export(methods drivers/measurement fusion/geometry fusion/dependence fusion/features fusion/motion
  fusion/registration fusion/calibration fusion/monitoring fusion/mapping fusion/places)
# What reads files needs the libraries that infuseConfig.cmake looks for.
infuse_install_archive(files infuse_network)
set_target_properties(infuse_network PROPERTIES EXPORT_NAME network)
list(TRANSFORM lidar_makers PREPEND drivers/ OUTPUT_VARIABLE maker_folders)
infuse_export(files drivers/text drivers/host drivers/gnss drivers/camera drivers/vehicle drivers/lidar ${maker_folders}
  drivers/recording drivers/makers fusion/streetmap)

foreach(set methods files)
  install(EXPORT infuse_${set} NAMESPACE infuse:: FILE infuse-${set}.cmake DESTINATION ${config} ${installed})
endforeach()
include(CMakePackageConfigHelpers)
configure_package_config_file(${library}/infuseConfig.cmake.in ${CMAKE_BINARY_DIR}/packaging/infuseConfig.cmake
  INSTALL_DESTINATION ${config})
# Before 1.0 a minor version may change what a header declares.
write_basic_package_version_file(${CMAKE_BINARY_DIR}/packaging/infuseConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/packaging/infuseConfig.cmake ${CMAKE_BINARY_DIR}/packaging/infuseConfigVersion.cmake
  DESTINATION ${config} ${installed})
file(RELATIVE_PATH to_prefix /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
foreach(module infuse infuse-files)
  configure_file(${library}/${module}.pc.in ${CMAKE_BINARY_DIR}/packaging/${module}.pc @ONLY)
  install(FILES ${CMAKE_BINARY_DIR}/packaging/${module}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig ${installed})
endforeach()
install(DIRECTORY ${library}/infuse DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} ${installed})
install(DIRECTORY ${library}/examples DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libinfuse-dev ${installed})
