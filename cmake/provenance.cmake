# granuscope_provenance(target): gives the target generated/build_facts.h (compiler, flags, library versions; known when
# configuring) and generated/git_state.h (refreshed by every build; only the file that includes it is compiled again).
function(granuscope_provenance target)
  string(TOUPPER "${CMAKE_BUILD_TYPE}" type)
  get_directory_property(options COMPILE_OPTIONS)
  get_target_property(warnings granuscope_warnings INTERFACE_COMPILE_OPTIONS)
  set(facts_flags "-std=c++${CMAKE_CXX_STANDARD} ${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_${type}} ${options} ${warnings}")
  # A path of the building machine would make the same program differ between machines, and is nobody's business.
  string(REGEX REPLACE "[;\t\r\n ]+" " " facts_flags "${facts_flags}")
  string(REGEX REPLACE "/[^ ]*" "<path>" facts_flags "${facts_flags}")
  string(REGEX REPLACE "[\\\\\"]" "" facts_flags "${facts_flags}")
  string(STRIP "${facts_flags}" facts_flags)
  set(facts_build_type "${CMAKE_BUILD_TYPE}")

  # Mesa is not here: its pkg-config file carries an interface number, while the GL context tells its true version.
  pkg_check_modules(GRANUSCOPE_TOMLPP QUIET tomlplusplus)
  set(facts_libraries "")
  foreach(entry "CLI11 ${CLI11_VERSION}" "Eigen ${Eigen3_VERSION}" "FreeType ${FREETYPE_VERSION_STRING}"
          "GLPK ${GLPK_VERSION}" "GSL ${GSL_VERSION}" "HDF5 ${HDF5_VERSION}" "Highway ${HWY_VERSION}"
          "fmt ${fmt_VERSION}" "libpng ${PNG_VERSION_STRING}" "nlohmann-json ${nlohmann_json_VERSION}"
          "tomlplusplus ${GRANUSCOPE_TOMLPP_VERSION}")
    if(entry MATCHES " [0-9]")
      list(APPEND facts_libraries "${entry}")
    endif()
  endforeach()

  set(folder ${CMAKE_BINARY_DIR}/provenance)
  configure_file(${PROJECT_SOURCE_DIR}/cmake/build_facts.h.in ${folder}/generated/build_facts.h @ONLY)
  add_custom_target(granuscope_git_state
    COMMAND ${CMAKE_COMMAND} -DSOURCE_DIR=${PROJECT_SOURCE_DIR} -DOUTPUT=${folder}/generated/git_state.h
            -P ${PROJECT_SOURCE_DIR}/cmake/git_state.cmake
    BYPRODUCTS ${folder}/generated/git_state.h
    COMMENT "Looking up the git commit" VERBATIM)
  target_include_directories(${target} PRIVATE ${folder})
  add_dependencies(${target} granuscope_git_state)
endfunction()
