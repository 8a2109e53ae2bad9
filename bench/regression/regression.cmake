# gudgeon_regression(TARGET RECORD TEST): makes an executable of kernels (counted.hpp) a test of speed.
#   RECORD: JSON file with the committed counts; the target renew_<TARGET> writes it anew
#   TEST:   name of the test that compares; its report lies in <binary directory>/<TARGET>-counts/report.txt
# Without valgrind or Python 3 the executable is left out of the default build and there is no test.
set(gudgeon_regression_folder ${CMAKE_CURRENT_LIST_DIR})

function(gudgeon_regression target record test)
  find_program(VALGRIND valgrind)
  find_path(VALGRIND_INCLUDE_DIR valgrind/callgrind.h)
  find_package(Python3 3.9 QUIET COMPONENTS Interpreter)
  if(NOT VALGRIND OR NOT VALGRIND_INCLUDE_DIR OR NOT Python3_FOUND)
    message(STATUS "No valgrind or no Python 3: speed is not compared with ${record}")
    set_target_properties(${target} PROPERTIES EXCLUDE_FROM_ALL TRUE)
    return()
  endif()
  set(folder ${gudgeon_regression_folder})
  string(TOUPPER "${CMAKE_BUILD_TYPE}" build_type)
  string(STRIP "${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_${build_type}}" flags)
  target_sources(${target} PRIVATE ${folder}/counted.cpp ${folder}/calibration.cpp)
  target_include_directories(${target} PRIVATE ${folder})
  target_include_directories(${target} SYSTEM PRIVATE ${VALGRIND_INCLUDE_DIR})
  target_compile_features(${target} PRIVATE cxx_std_20)
  target_compile_definitions(${target} PRIVATE COUNTED_FLAGS="${flags}")

  set(counts ${CMAKE_CURRENT_BINARY_DIR}/${target}-counts)
  set(command ${Python3_EXECUTABLE} -B ${folder}/regression.py $<TARGET_FILE:${target}> --record ${record}
    --valgrind ${VALGRIND} --keep ${counts})
  add_custom_target(renew_${target} COMMAND ${command} --renew DEPENDS ${target} USES_TERMINAL VERBATIM
    COMMENT "Counting every kernel of ${target}")
  add_test(NAME ${test} COMMAND ${command} --report ${counts}/report.txt)
  set_tests_properties(${test} PROPERTIES SKIP_RETURN_CODE 77 TIMEOUT 600 COST 1000)
endfunction()
