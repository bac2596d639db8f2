# SPDX-License-Identifier: Apache-2.0
# What is installed, and the Debian package of it: cmake --build --preset release --target package
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

install(TARGETS sinew sinew-board)
foreach(file plant/limbs plant/emps plant/tanks plant/silverbox scenarios)
  install(DIRECTORY ${file}/ DESTINATION ${CMAKE_INSTALL_DATADIR}/sinew/${file} FILES_MATCHING PATTERN "*.yaml" PATTERN "recording.csv")
endforeach()
install(DIRECTORY docs/schema DESTINATION ${CMAKE_INSTALL_DATADIR}/sinew/docs)
install(FILES NOTICE CHANGELOG.md README.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME copyright)
# What `export-fmu` puts into an FMU.
if(TARGET sinew_fmu_binary)
  install(TARGETS sinew_fmu_binary LIBRARY DESTINATION lib/sinew)
  install(FILES ${CMAKE_BINARY_DIR}/sinew-fmu.licenses.txt DESTINATION lib/sinew)
endif()
# The emulated board is a program of its own, under the GPL.
if(TARGET sinew-emulator)
  install(PROGRAMS $<TARGET_FILE:sinew-emulator> DESTINATION lib/sinew)
  install(FILES ${CMAKE_BINARY_DIR}/firmware.elf DESTINATION lib/sinew)
  install(FILES emulator/LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} RENAME copyright.sinew-emulator)
endif()

# Libraries and headers, for a plant of one's own: examples/own_plant.
foreach(room plant sim diagnose model report)
  set_target_properties(sinew_${room} PROPERTIES EXPORT_NAME ${room})
  install(TARGETS sinew_${room} EXPORT sinewTargets)
  install(DIRECTORY ${room}/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/sinew/${room} FILES_MATCHING PATTERN "*.h")
  install(CODE "execute_process(COMMAND ${CMAKE_STRIP} --strip-unneeded
    \$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_LIBDIR}/libsinew_${room}.a COMMAND_ERROR_IS_FATAL ANY)")
endforeach()
target_compile_definitions(sinew_plant INTERFACE EIGEN_MAX_ALIGN_BYTES=16)  # as the libraries were compiled
target_compile_features(sinew_plant INTERFACE cxx_std_20)
install(EXPORT sinewTargets NAMESPACE sinew:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/sinew)
configure_package_config_file(cmake/sinewConfig.cmake.in ${CMAKE_BINARY_DIR}/generated/sinewConfig.cmake
                              INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/sinew)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/generated/sinewConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/generated/sinewConfig.cmake ${CMAKE_BINARY_DIR}/generated/sinewConfigVersion.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/sinew)
install(DIRECTORY examples/own_plant DESTINATION ${CMAKE_INSTALL_DOCDIR}/examples)

# Manual pages and completions, which the program prints.
set(pages ${CMAKE_BINARY_DIR}/pages)
add_custom_command(OUTPUT ${pages}/man/sinew.1
  COMMAND ${CMAKE_COMMAND} -DSINEW=$<TARGET_FILE:sinew> -DOUTPUT=${pages} -P ${CMAKE_SOURCE_DIR}/cmake/pages.cmake
  DEPENDS sinew ${CMAKE_SOURCE_DIR}/cmake/pages.cmake)
add_custom_target(sinew_pages ALL DEPENDS ${pages}/man/sinew.1)
install(DIRECTORY ${pages}/man/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${pages}/bash/sinew DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
install(FILES ${pages}/zsh/_sinew DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions)
install(FILES ${pages}/fish/sinew.fish DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d)

# The Python module, where Debian's Python looks.
if(TARGET sinew_python)
  set(SINEW_PYTHON_DIR lib/python3/dist-packages/sinew CACHE STRING "where the Python module is installed, below the prefix")
  install(TARGETS sinew_python LIBRARY DESTINATION ${SINEW_PYTHON_DIR})
  install(DIRECTORY python/sinew/ DESTINATION ${SINEW_PYTHON_DIR} FILES_MATCHING PATTERN "*.py" PATTERN "*.pyi" PATTERN "py.typed")
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME sinew)
set(CPACK_PACKAGE_CONTACT "the authors of Sinew <sinew@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "simulation and diagnosis of soft limbs bent by shape memory alloy")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_POST_BUILD_SCRIPTS ${CMAKE_SOURCE_DIR}/cmake/pack_tighter.cmake)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS "libjs-dygraphs, python3, python3-numpy")
string(CONCAT CPACK_DEBIAN_PACKAGE_SUGGESTS "g++, cmake, libeigen3-dev, libsundials-dev, libyaml-cpp-dev, libceres-dev, nlohmann-json3-dev, "
       "libssl-dev, libhdf5-dev, libmatio-dev, libopenmpi-dev, pkg-config, python3-matplotlib")
include(CPack)
