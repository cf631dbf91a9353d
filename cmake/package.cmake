# What is installed beside the programs, and the Debian packages that CPack makes of it.

set(packaging ${PROJECT_SOURCE_DIR}/packaging)

# The service: where systemd, udev and the kernel's settings are looked for.
install(FILES systemd/infused.service systemd/infused.socket systemd/infuse-upload.path systemd/infuse-upload.service
  DESTINATION /lib/systemd/system)
install(PROGRAMS packaging/upload DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/infuse)
install(FILES systemd/infuse.sysusers DESTINATION /usr/lib/sysusers.d RENAME infuse.conf)
install(FILES systemd/infuse.tmpfiles DESTINATION /usr/lib/tmpfiles.d RENAME infuse.conf)
install(FILES systemd/60-infuse.sysctl DESTINATION /usr/lib/sysctl.d RENAME 60-infuse.conf)
install(FILES systemd/60-infuse.rules DESTINATION /lib/udev/rules.d)
install(FILES packaging/examples/infused.toml DESTINATION /etc/infuse)
install(DIRECTORY DESTINATION /etc/infuse/infused.toml.d)
install(FILES drivers/lcm/infuse.lcm DESTINATION ${CMAKE_INSTALL_DATADIR}/infuse/lcm)
install(FILES packaging/examples/shuttle.toml packaging/examples/survey_car.toml packaging/examples/truck.toml
  packaging/examples/rig.toml packaging/examples/upload systemd/tap.conf systemd/mqtt.conf systemd/lcm.conf
  DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/infused/examples)

# Seven packages: the daemon; the command `infuse`; its tools, whose libraries are many; the simulator; the studies; the
# library (library.cmake) and the Python module (python.cmake). `./dev package` makes the last six of their components.
set(owner COMPONENT owner EXCLUDE_FROM_ALL)
set(tools COMPONENT tools EXCLUDE_FROM_ALL)
set(simulator COMPONENT simulator EXCLUDE_FROM_ALL)
install(TARGETS infused RUNTIME)
install(TARGETS infuse RUNTIME ${owner})
install(TARGETS infuse-tools RUNTIME DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/infuse ${tools})
get_property(links GLOBAL PROPERTY INFUSE_TOOL_LINKS)
install(FILES ${links} DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/infuse ${tools})
install(FILES ${packaging}/completion/infuse DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions ${owner})

# Debian wants manuals and the changelog compressed, always to the same bytes.
function(compress source name)
  set(compressed ${CMAKE_BINARY_DIR}/packaging/${name}.gz)
  add_custom_command(OUTPUT ${compressed} DEPENDS ${source}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${CMAKE_BINARY_DIR}/packaging
    COMMAND gzip -9nc ${source} > ${compressed} VERBATIM)
  set_property(GLOBAL APPEND PROPERTY INFUSE_COMPRESSED ${compressed})
endfunction()
# install_manual(NAME SECTION ...): ARGN: of install().
function(install_manual name section)
  compress(${packaging}/man/${name}.${section} ${name}.${section})
  install(FILES ${CMAKE_BINARY_DIR}/packaging/${name}.${section}.gz
    DESTINATION ${CMAKE_INSTALL_MANDIR}/man${section} ${ARGN})
endfunction()

# The workflow over many drives, and what a server of many vehicles needs.
install(FILES packaging/fleet/Snakefile packaging/fleet/fleet.toml packaging/fleet/README.md
  DESTINATION ${CMAKE_INSTALL_DATADIR}/infuse/fleet ${tools})
install(PROGRAMS packaging/fleet/drive_job DESTINATION ${CMAKE_INSTALL_DATADIR}/infuse/fleet ${tools})
install(FILES packaging/fleet/slurm/config.yaml packaging/fleet/slurm/jobscript.sh
  DESTINATION ${CMAKE_INSTALL_DATADIR}/infuse/fleet/slurm ${tools})
install(PROGRAMS packaging/fleet/slurm/status DESTINATION ${CMAKE_INSTALL_DATADIR}/infuse/fleet/slurm ${tools})
install(DIRECTORY packaging/fleet/prometheus packaging/fleet/grafana
  DESTINATION ${CMAKE_INSTALL_DATADIR}/infuse/fleet ${tools})

install_manual(infused 8)
install_manual(infuse 1 ${owner})
if(INFUSE_SIMULATOR)
  install_manual(infuse-simulate 1 ${simulator})
endif()
if(TARGET infuse-study)
  install_manual(infuse-study 1 COMPONENT study EXCLUDE_FROM_ALL)
endif()
configure_file(${packaging}/debian/changelog.in ${CMAKE_BINARY_DIR}/packaging/changelog @ONLY)
compress(${CMAKE_BINARY_DIR}/packaging/changelog changelog)
get_property(compressed GLOBAL PROPERTY INFUSE_COMPRESSED)
add_custom_target(manuals ALL DEPENDS ${compressed})

# What Debian wants of every package. ARGN: of install().
function(install_package_texts package)
  set(overrides ${CMAKE_BINARY_DIR}/packaging/${package}.overrides)
  set(doc ${CMAKE_INSTALL_DATADIR}/doc/${package})
  # The project has no public mail address.
  file(WRITE ${overrides}
    "${package}: bogus-mail-host Maintainer *\n${package}: bogus-mail-host-in-debian-changelog *\n")
  install(FILES ${packaging}/debian/copyright ${CMAKE_BINARY_DIR}/packaging/changelog.gz DESTINATION ${doc} ${ARGN})
  install(FILES ${overrides} DESTINATION ${CMAKE_INSTALL_DATADIR}/lintian/overrides RENAME ${package} ${ARGN})
endfunction()
install_package_texts(infused)
install_package_texts(infuse ${owner})
install_package_texts(infuse-tools ${tools})
if(TARGET infuse-study)
  set(study COMPONENT study EXCLUDE_FROM_ALL)
  install(TARGETS infuse-study RUNTIME ${study})
  install_package_texts(infuse-study ${study})
endif()
install_package_texts(libinfuse-dev COMPONENT library EXCLUDE_FROM_ALL)
install_package_texts(python3-infuse COMPONENT python EXCLUDE_FROM_ALL)

if(INFUSE_SIMULATOR)
  install(TARGETS infuse-simulate RUNTIME ${simulator})
  install(DIRECTORY fixtures/scenarios fixtures/maps DESTINATION ${CMAKE_INSTALL_DATADIR}/infuse-simulate ${simulator})
  install_package_texts(infuse-simulate ${simulator})
endif()

file(WRITE ${CMAKE_BINARY_DIR}/packaging/conffiles "/etc/infuse/infused.toml\n")
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME infused)
set(CPACK_PACKAGE_VERSION ${INFUSE_VERSION})
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_PACKAGE_CONTACT "The infuse authors <infuse@localhost.localdomain>")
set(CPACK_PACKAGE_VENDOR infuse)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "on-vehicle fusion of lidar, cameras and odometry")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION
  "infused takes the raw streams of lidars, cameras and the vehicle's
CAN bus, keeps them on one clock, monitors their health and calibration, and
publishes reports over a socket. The command that queries and controls it is
in infuse.")
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "systemd")
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS infuse)
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "can-utils, v4l-utils")
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA ${packaging}/debian/postinst ${packaging}/debian/prerm
  ${packaging}/debian/postrm ${CMAKE_BINARY_DIR}/packaging/conffiles)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_STRIP_FILES ON)
include(CPack)
