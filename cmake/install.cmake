# Installation: libraries, headers, ready models and the package for find_package(gudgeon).
include(CMakePackageConfigHelpers)

install(TARGETS gudgeon_all EXPORT gudgeonTargets)

# Inside the installed headers "core/x.hpp" becomes <gudgeon/core/x.hpp>, so that a folder "core" of
# the program that includes them is never taken for ours.
install(CODE "
  set(from \"${PROJECT_SOURCE_DIR}\")
  set(to \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_INCLUDEDIR}/gudgeon\")
  foreach(folder core contact solvers models)
    file(GLOB_RECURSE headers RELATIVE \${from} \${from}/\${folder}/*.hpp)
    list(FILTER headers EXCLUDE REGEX \"(json_input|reader_parts|writer_parts|validate_parts|validate_laws|cholmod_tools|exact_step)\") # parts of .cpp files
    foreach(header \${headers})
      file(READ \${from}/\${header} text)
      string(REGEX REPLACE \"#include \\\"((core|contact|solvers|models)/[^\\\"]+)\\\"\"
             \"#include <gudgeon/\\\\1>\" text \"\${text}\")
      message(STATUS \"Installing: \${to}/\${header}\")
      file(WRITE \${to}/\${header} \"\${text}\")
      list(APPEND CMAKE_INSTALL_MANIFEST_FILES \${to}/\${header})
    endforeach()
  endforeach()
")

install(DIRECTORY models/ DESTINATION ${CMAKE_INSTALL_DATADIR}/gudgeon/models FILES_MATCHING PATTERN "*.json")
install(FILES bench/regression/counted.hpp bench/regression/counted.cpp bench/regression/calibration.cpp
  bench/regression/regression.cmake bench/regression/README.md
  DESTINATION ${CMAKE_INSTALL_DATADIR}/gudgeon/regression)
install(PROGRAMS bench/regression/regression.py DESTINATION ${CMAKE_INSTALL_DATADIR}/gudgeon/regression)
install(FILES LICENSE NOTICE DESTINATION ${CMAKE_INSTALL_DOCDIR})

list(JOIN suitesparse " " gudgeon_suitesparse)
set(regression ${CMAKE_INSTALL_DATADIR}/gudgeon/regression)
set(package ${CMAKE_INSTALL_LIBDIR}/cmake/gudgeon)
install(EXPORT gudgeonTargets NAMESPACE gudgeon:: DESTINATION ${package})
configure_package_config_file(cmake/gudgeonConfig.cmake.in ${PROJECT_BINARY_DIR}/gudgeonConfig.cmake
  INSTALL_DESTINATION ${package} PATH_VARS regression)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/gudgeonConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/gudgeonConfig.cmake ${PROJECT_BINARY_DIR}/gudgeonConfigVersion.cmake
  cmake/FindSuiteSparse.cmake DESTINATION ${package})
