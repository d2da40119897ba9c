# Options, and how our own code is compiled.
# Within another build (MeshLab's own: docs/installing.md) the choices of that one stand.
string(COMPARE EQUAL "${CMAKE_SOURCE_DIR}" "${PROJECT_SOURCE_DIR}" shrinkwrap_is_top_level)

option(SHRINKWRAP_BUILD_PLUGIN "Build the MeshLab plugin (needs MeshLab and Qt 5)" ON)
option(SHRINKWRAP_BUILD_TESTS "Build the tests (needs GoogleTest)" ${shrinkwrap_is_top_level})
option(SHRINKWRAP_WARNINGS_AS_ERRORS "Stop at any warning of the compiler" ${shrinkwrap_is_top_level})
option(SHRINKWRAP_SANITIZE "Build with the address and undefined-behaviour sanitizers" OFF)

if(NOT CMAKE_BUILD_TYPE AND shrinkwrap_is_top_level)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
endif()
set(CMAKE_CXX_FLAGS_RELEASE "-O3 -DNDEBUG")
set(CMAKE_CXX_STANDARD 17)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_CXX_VISIBILITY_PRESET hidden)
set(CMAKE_VISIBILITY_INLINES_HIDDEN ON)

# The same bytes on every machine: no contraction into fused multiply-add.
add_compile_options(-ffp-contract=off)

if(SHRINKWRAP_SANITIZE)
  # With the assertions of Eigen and of the standard library, which look at every index. Lines, but no variables: full
  # debug information is a third of the time that it takes to compile. A third of the time of the tests goes into what
  # is asked of each pointer before it is used: not null, aligned, within its object. Most of the first and the last the
  # address sanitizer finds too; the second needs a cast.
  add_compile_options(-fsanitize=address,undefined -fno-sanitize=null,alignment,object-size -fno-sanitize-recover=all
                      -fno-omit-frame-pointer -g1 -O1 -UNDEBUG)
  add_compile_definitions(_GLIBCXX_ASSERTIONS)
  add_link_options(-fsanitize=address,undefined)
endif()

# Linked privately by every target of ours; the headers of others are system headers and stay out of it.
add_library(shrinkwrap_warnings INTERFACE)
target_compile_options(shrinkwrap_warnings INTERFACE -Wall -Wextra -Wpedantic -Wshadow)
if(SHRINKWRAP_WARNINGS_AS_ERRORS)
  target_compile_options(shrinkwrap_warnings INTERFACE -Werror)
endif()
