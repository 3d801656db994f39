# One interface target that every target of the project links: warnings, sanitizers, processor.
option(MMLINS_WARNINGS_AS_ERRORS "Treat warnings as errors" OFF)

add_library(mmlins_compile_options INTERFACE)
target_compile_features(mmlins_compile_options INTERFACE cxx_std_20)
target_compile_options(mmlins_compile_options INTERFACE -Wall -Wextra -Wshadow -Wnon-virtual-dtor)
if(MMLINS_WARNINGS_AS_ERRORS)
  target_compile_options(mmlins_compile_options INTERFACE -Werror)
endif()
if(MMLINS_NATIVE)
  target_compile_options(mmlins_compile_options INTERFACE -march=native)
endif()
if(MMLINS_SANITIZE)
  target_compile_options(mmlins_compile_options INTERFACE -fsanitize=${MMLINS_SANITIZE} -fno-omit-frame-pointer)
  target_link_options(mmlins_compile_options INTERFACE -fsanitize=${MMLINS_SANITIZE})
endif()
if(CMAKE_BUILD_TYPE STREQUAL "Release")
  target_compile_options(mmlins_compile_options INTERFACE -O3)
endif()
# The packaged Ceres was built with Eigen's alignment for plain x86-64 and shares template code with ours at run
# time: memory that one side allocates the other frees. Wider vectors and sanitizers would change ours.
if(MMLINS_NATIVE OR MMLINS_SANITIZE)
  target_compile_definitions(mmlins_compile_options INTERFACE EIGEN_MAX_ALIGN_BYTES=16 EIGEN_MALLOC_ALREADY_ALIGNED=1)
endif()
