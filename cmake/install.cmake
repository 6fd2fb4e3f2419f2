# What `cmake --install` puts where, and the packages that `cmake --build build/release --target package` makes of it:
# granuscope_*.deb (the program), granuscope-mpi_*.deb (where MPI was found) and libgranuscope-dev_*.deb (the library,
# component "library").
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# The library: the rooms that need neither pictures nor pages, in one archive. Its interface is not stable yet.
set(granuscope_library_rooms support model storage sampling ensemble analysis)
set(granuscope_objects)
foreach(room IN LISTS granuscope_library_rooms)
  list(APPEND granuscope_objects $<TARGET_OBJECTS:granuscope_${room}>)
endforeach()
add_library(granuscope_library STATIC ${granuscope_objects})
set_target_properties(granuscope_library PROPERTIES OUTPUT_NAME granuscope EXPORT_NAME granuscope LINKER_LANGUAGE CXX)
target_compile_features(granuscope_library INTERFACE cxx_std_20)
target_include_directories(granuscope_library INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/granuscope>)
target_link_libraries(granuscope_library PUBLIC fmt::fmt
                      PRIVATE OpenSSL::Crypto Threads::Threads GSL::gsl PkgConfig::HWY ${GLPK_LIBRARY} ${HDF5_C_LIBRARIES})
install(TARGETS granuscope_library EXPORT granuscope ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library)
foreach(room IN LISTS granuscope_library_rooms)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/src/core/${room} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/granuscope
          COMPONENT library FILES_MATCHING PATTERN "*.h" PATTERN "*.inc" PATTERN "*-inl.h" EXCLUDE)
endforeach()
set(granuscope_package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/granuscope)
install(EXPORT granuscope NAMESPACE granuscope:: FILE granuscopeTargets.cmake
        DESTINATION ${granuscope_package_folder} COMPONENT library)
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/granuscopeConfig.cmake.in
  ${CMAKE_BINARY_DIR}/granuscopeConfig.cmake INSTALL_DESTINATION ${granuscope_package_folder})
write_basic_package_version_file(${CMAKE_BINARY_DIR}/granuscopeConfigVersion.cmake COMPATIBILITY ExactVersion)
install(FILES ${CMAKE_BINARY_DIR}/granuscopeConfig.cmake ${CMAKE_BINARY_DIR}/granuscopeConfigVersion.cmake
        DESTINATION ${granuscope_package_folder} COMPONENT library)

# The program, with what it prints about itself. A manual page is stored packed, without a time.
set(share ${CMAKE_BINARY_DIR}/share)
add_custom_command(OUTPUT ${share}/done
  COMMAND ${CMAKE_COMMAND} -E rm -rf ${share}
  COMMAND granuscope reference --files ${share}
  COMMAND find ${share}/man -type f -exec gzip -9n {} +
  COMMAND ${CMAKE_COMMAND} -E touch ${share}/done
  DEPENDS granuscope COMMENT "Writing manual pages and completions" VERBATIM)
add_custom_target(granuscope_manual ALL DEPENDS ${share}/done)
set(documents ${CMAKE_INSTALL_DATADIR}/doc/granuscope)
install(TARGETS granuscope RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program)
if(TARGET granuscope-mpi)
  install(TARGETS granuscope-mpi RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT mpi)
endif()
install(DIRECTORY ${share}/ DESTINATION ${CMAKE_INSTALL_DATADIR} COMPONENT program PATTERN done EXCLUDE)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/templates DESTINATION ${CMAKE_INSTALL_DATADIR}/granuscope COMPONENT program)
# Scripts are no documents, which a small system leaves out.
install(FILES ${PROJECT_SOURCE_DIR}/examples/python/force_chains.py
        ${PROJECT_SOURCE_DIR}/examples/python/paraview_tubes.py
        ${PROJECT_SOURCE_DIR}/examples/python/response_profile.py
        DESTINATION ${CMAKE_INSTALL_DATADIR}/granuscope/python COMPONENT program)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/examples DESTINATION ${documents} COMPONENT program
        PATTERN "figures" EXCLUDE PATTERN "__pycache__" EXCLUDE)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs DESTINATION ${documents} COMPONENT program)
install(FILES ${PROJECT_SOURCE_DIR}/CITATION.cff ${PROJECT_SOURCE_DIR}/README.md DESTINATION ${documents}
        COMPONENT program)

# Debian's documents: the licences, and the changelog in Debian's form.
configure_file(${PROJECT_SOURCE_DIR}/cmake/debian/changelog.in ${CMAKE_BINARY_DIR}/changelog @ONLY)
execute_process(COMMAND gzip -9nf ${CMAKE_BINARY_DIR}/changelog)
set(components program library)
set(packages granuscope libgranuscope-dev)
if(TARGET granuscope-mpi)
  list(APPEND components mpi)
  list(APPEND packages granuscope-mpi)
endif()
foreach(component package IN ZIP_LISTS components packages)
  install(FILES ${PROJECT_SOURCE_DIR}/cmake/debian/copyright ${CMAKE_BINARY_DIR}/changelog.gz
          DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package} COMPONENT ${component})
endforeach()
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/CHANGELOG.md DESTINATION ${documents}
        COMPONENT program)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME granuscope)
set(CPACK_PACKAGE_CONTACT "The granuscope authors <granuscope@example.org>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL ${components})
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME granuscope)
set(CPACK_DEBIAN_PROGRAM_DESCRIPTION "Draws random contact-force networks of piles of frictional beads, measures how
a point load spreads through them, renders force chains off-screen, and writes
an HTML or PDF report that tests the figures and claims of a paper.")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS "gnuplot-nox, fonts-dejavu-core")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS libosmesa6)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS weasyprint)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME libgranuscope-dev)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_LIBRARY_DESCRIPTION "The rooms model, storage, sampling, ensemble and analysis of granuscope as a
static library with headers. Its interface may change with every version.")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_DEPENDS "libfmt-dev, libglpk-dev, libgsl-dev, libhdf5-dev, libhwy-dev, libssl-dev, pkg-config")
set(CPACK_DEBIAN_MPI_PACKAGE_NAME granuscope-mpi)
set(CPACK_DEBIAN_MPI_PACKAGE_DEPENDS "granuscope (= ${PROJECT_VERSION})")
set(CPACK_DEBIAN_MPI_DESCRIPTION "The program granuscope for MPI: mpirun -n N granuscope-mpi run EXPERIMENT draws
the piles of an experiment on all ranks, and leaves the bytes of one process.")
include(CPack)
