# Holds the algorithm to its layers: cmake -D ROOT=<its folder> -P check_folders.cmake
#
# A file includes headers of its own folder and of those before it in this list alone, each by its path from the root
# of the algorithm. The files in that root make the pipeline of them, and may include any.
cmake_minimum_required(VERSION 3.18)

set(folders
    common
    geometry
    mesh
    samples
    orientation
    initial_mesh
    parametric_surface
    edge_optimisation
    complete_matching
    stop_at_surface
    report)

set(faults "")
file(GLOB_RECURSE files RELATIVE ${ROOT} ${ROOT}/*.h ${ROOT}/*.cpp)
if(NOT files)
  message(FATAL_ERROR "No sources in '${ROOT}'")
endif()
foreach(file ${files})
  get_filename_component(folder ${file} DIRECTORY)
  list(LENGTH folders layer)
  if(folder)
    list(FIND folders ${folder} layer)
    if(layer LESS 0)
      list(APPEND faults "${file}: the folder is not in the list of ${CMAKE_CURRENT_LIST_FILE}")
      continue()
    endif()
  endif()
  file(STRINGS ${ROOT}/${file} includes REGEX "^#include \"")
  foreach(include ${includes})
    string(REGEX REPLACE "^#include \"([^\"]*)\".*" "\\1" header ${include})
    get_filename_component(included ${header} DIRECTORY)
    if(NOT EXISTS ${ROOT}/${header})
      list(APPEND faults "${file} includes ${header}, which is no path from the root of the algorithm")
    elseif(folder)
      list(FIND folders "${included}" included_layer)
      if(included_layer LESS 0 OR included_layer GREATER layer)
        list(APPEND faults "${file} includes ${header}, of a later layer")
      endif()
    endif()
  endforeach()
endforeach()
if(faults)
  list(JOIN faults "\n  " faults)
  message(FATAL_ERROR "\n  ${faults}")
endif()
