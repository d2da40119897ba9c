# The MeshLab that is installed, or whose build this is a part of: its generation, its headers (target vcglib and, for the
# plugin, meshlab_host), and a stage in which the installed one finds the plugin without root.
set(SHRINKWRAP_MESHLAB_GENERATION "" CACHE STRING
    "Plugin interface: 2020 (2020.09) or 2021 (2021.05 and later); empty: that of the sources found")
set_property(CACHE SHRINKWRAP_MESHLAB_GENERATION PROPERTY STRINGS "" 2020 2021)
set(SHRINKWRAP_MESHLAB_SOURCE_DIR "" CACHE PATH
    "Sources of the installed MeshLab, with src/common and vcglib; empty: fetched into the build folder")
set(SHRINKWRAP_MESHLAB_SCALAR "float" CACHE STRING "Scalar that the host was built with (Debian: float, PyMeshLab: double)")
set_property(CACHE SHRINKWRAP_MESHLAB_SCALAR PROPERTY STRINGS float double)

# The host's own library as a target, if this is a part of its build: "common" in 2020.09.
set(meshlab_target "")
foreach(candidate meshlab-common common)
  if(TARGET ${candidate} AND DEFINED MESHLAB_PLUGIN_OUTPUT_DIR AND NOT meshlab_target)
    set(meshlab_target ${candidate})
  endif()
endforeach()

set(meshlab_source_dir ${SHRINKWRAP_MESHLAB_SOURCE_DIR})
if(meshlab_target)
  get_target_property(meshlab_common_dir ${meshlab_target} SOURCE_DIR)
  get_filename_component(meshlab_source_dir ${meshlab_common_dir}/../.. ABSOLUTE)
  if(BUILD_WITH_DOUBLE_SCALAR OR MESHLAB_BUILD_WITH_DOUBLE_SCALAR)
    set(SHRINKWRAP_MESHLAB_SCALAR double)
  endif()
endif()
if(NOT meshlab_source_dir AND (SHRINKWRAP_BUILD_PLUGIN OR SHRINKWRAP_BUILD_TESTS))
  set(meshlab_source_dir ${PROJECT_BINARY_DIR}/meshlab-source)
  execute_process(COMMAND sh ${CMAKE_CURRENT_LIST_DIR}/fetch_meshlab_source.sh ${meshlab_source_dir}
                  RESULT_VARIABLE fetch_result)
  if(NOT fetch_result EQUAL 0)
    if(SHRINKWRAP_BUILD_PLUGIN)
      message(FATAL_ERROR "No MeshLab headers: see above. -DSHRINKWRAP_BUILD_PLUGIN=OFF builds the library alone.")
    endif()
    message(STATUS "No MeshLab headers: the tests of the vcg adapters are left out")
    set(meshlab_source_dir "")
  endif()
endif()

if(meshlab_source_dir)
  # Debian's source package has vcglib beside src, upstream's archives have it inside.
  foreach(candidate ${meshlab_source_dir}/vcglib ${meshlab_source_dir}/src/vcglib)
    if(EXISTS ${candidate}/vcg)
      set(vcglib_dir ${candidate})
    endif()
  endforeach()
  if(NOT vcglib_dir)
    message(FATAL_ERROR "No vcglib in ${meshlab_source_dir}")
  endif()
  if(NOT TARGET vcglib)  # later generations' own builds have it
    add_library(vcglib INTERFACE)
    target_include_directories(vcglib SYSTEM INTERFACE ${vcglib_dir})
    target_link_libraries(vcglib INTERFACE Eigen3::Eigen)
  endif()
endif()

if(NOT SHRINKWRAP_BUILD_PLUGIN)
  return()
endif()

include(CheckMeshLab)
check_meshlab_options()
meshlab_of_sources(${meshlab_source_dir} meshlab_version meshlab_generation)
if(meshlab_target)
  set(meshlab_common ${meshlab_target})
else()
  find_library(SHRINKWRAP_MESHLAB_COMMON meshlab-common PATH_SUFFIXES meshlab REQUIRED
               PATHS /usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}
               DOC "MeshLab's own library, to link with: found among the installed ones unless it is given.")
  check_meshlab_library(${SHRINKWRAP_MESHLAB_COMMON} ${meshlab_version})
  set(meshlab_common ${SHRINKWRAP_MESHLAB_COMMON})
  get_filename_component(meshlab_library_dir ${meshlab_common} DIRECTORY)
  get_filename_component(meshlab_library_dir ${meshlab_library_dir} REALPATH)  # /lib may be a link to /usr/lib
  string(REGEX REPLACE "/lib[^/]*(/[^/]+)?/meshlab$" "" meshlab_prefix ${meshlab_library_dir})  # with a triplet, or not
  set(MESHLAB_PLUGIN_DIR ${meshlab_library_dir}/plugins)
  set(MESHLAB_SERVER ${meshlab_prefix}/bin/meshlabserver)  # later generations have none
endif()
message(STATUS "MeshLab ${meshlab_version} (${SHRINKWRAP_MESHLAB_SCALAR}), plugin interface of generation "
               "${meshlab_generation}")

find_package(Qt5 REQUIRED COMPONENTS Core Gui Widgets OpenGL Xml)
add_library(meshlab_host INTERFACE)
target_include_directories(meshlab_host SYSTEM INTERFACE ${meshlab_source_dir}/src
                                                         ${meshlab_source_dir}/src/common)
target_compile_definitions(
  meshlab_host
  INTERFACE MESHLAB_SCALAR=${SHRINKWRAP_MESHLAB_SCALAR} MESHLAB_VERSION=${meshlab_version}
            SHRINKWRAP_MESHLAB_GENERATION=${meshlab_generation} QT_NO_DEBUG)
target_link_libraries(meshlab_host INTERFACE vcglib ${meshlab_common} Qt5::Core Qt5::Gui Qt5::Widgets
                                             Qt5::OpenGL Qt5::Xml)

# After every build of `plugin`: <build>/stage/bin with the host's programs, finding all stock plugins and `plugin`.
function(stage_meshlab plugin)
  add_custom_command(
    TARGET ${plugin} POST_BUILD VERBATIM
    COMMAND ${CMAKE_COMMAND} -DSTAGE=${PROJECT_BINARY_DIR}/stage -DPREFIX=${meshlab_prefix}
            -DLIBRARY_DIR=${meshlab_library_dir} -DPLUGIN=$<TARGET_FILE:${plugin}>
            -P ${PROJECT_SOURCE_DIR}/cmake/StageMeshLab.cmake
    COMMENT "Staging MeshLab with the plugin")
endfunction()
