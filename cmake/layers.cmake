# Two thirds of the time to compile go into reading the same headers again and again. One target reads them; the
# others take them from there. `-D MMLINS_PRECOMPILED_HEADERS=OFF` shows includes that are missing.
option(MMLINS_PRECOMPILED_HEADERS "Read common headers once; builds in two thirds of the time" ON)
function(precompile_headers target owner)
  if(NOT MMLINS_PRECOMPILED_HEADERS)
    return()
  endif()
  if(target STREQUAL owner)
    target_precompile_headers(${target} PRIVATE <Eigen/Cholesky> <Eigen/Core> <Eigen/Eigenvalues> <Eigen/Geometry> <Eigen/LU> <algorithm>
                              <cmath> <functional> <map> <memory> <optional> <span> <string> <unordered_map> <variant> <vector> <fmt/format.h> ${ARGN})
  else()
    target_precompile_headers(${target} REUSE_FROM ${owner})
  endif()
endfunction()

# A layer is a folder of src/mmlins with its own library. The table of layers is src/mmlins/CMakeLists.txt;
# tools/check_layers.py reads the same table and refuses an include that it does not allow.
#
#   add_layer(imu DEPS base math sensor PACKAGES fmt::fmt)
function(add_layer name)
  cmake_parse_arguments(LAYER "" "" "DEPS;PACKAGES;PRIVATE_PACKAGES" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${name}/*.cpp)
  set(target mmlins_${name})
  list(TRANSFORM LAYER_DEPS PREPEND mmlins_)
  if(sources)
    add_library(${target} STATIC ${sources})
    target_include_directories(${target} PUBLIC ${PROJECT_SOURCE_DIR}/src)
    target_link_libraries(${target} PUBLIC ${LAYER_DEPS} ${LAYER_PACKAGES} PRIVATE ${LAYER_PRIVATE_PACKAGES} mmlins_compile_options)
    if(name STREQUAL "math" OR mmlins_math IN_LIST LAYER_DEPS)
      precompile_headers(${target} mmlins_math)
    endif()
  else()
    add_library(${target} INTERFACE)
    target_include_directories(${target} INTERFACE ${PROJECT_SOURCE_DIR}/src)
    target_link_libraries(${target} INTERFACE ${LAYER_DEPS} ${LAYER_PACKAGES})
  endif()
endfunction()
