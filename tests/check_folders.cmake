# Holds the algorithm to its layers: cmake -DROOT=<its folder> -P check_folders.cmake
#
# A file includes headers of its own folder and of those before it in this list alone, each in quotes and by its path
# from the root of the algorithm. The files in that root make the pipeline of them, and may include any.
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

if(NOT ROOT OR NOT IS_DIRECTORY "${ROOT}")
  message(FATAL_ERROR "ROOT is '${ROOT}': it is to be the folder of the algorithm")
endif()
get_filename_component(root "${ROOT}" ABSOLUTE)

set(faults "")
set(empty_folders ${folders})
file(GLOB_RECURSE files RELATIVE ${root} ${root}/*)
foreach(file ${files})
  if(NOT file MATCHES "\\.(h|cpp)$")
    list(APPEND faults "${file}: neither .h nor .cpp")
    continue()
  endif()
  get_filename_component(folder ${file} DIRECTORY)
  list(LENGTH folders layer)
  if(folder)
    list(FIND folders ${folder} layer)
    if(layer LESS 0)
      list(APPEND faults "${file}: its folder is not in the list of this script")
      continue()
    endif()
    list(REMOVE_ITEM empty_folders ${folder})
  endif()
  file(READ ${root}/${file} text)
  string(REGEX MATCHALL "#[ \t]*include[ \t]*[<\"][^>\"\n]*" includes "${text}")
  foreach(include ${includes})
    string(REGEX MATCH "[<\"]" quote "${include}")
    string(REGEX REPLACE "^.*[<\"]" "" header "${include}")
    if(NOT EXISTS ${root}/${header})
      if(quote STREQUAL "\"")
        list(APPEND faults "${file} includes ${header}, which is no path from the root of the algorithm")
      endif()
      continue()
    endif()
    if(quote STREQUAL "<")
      list(APPEND faults "${file} includes ${header}, without quotes")
    endif()
    get_filename_component(included ${header} DIRECTORY)
    list(FIND folders "${included}" included_layer)
    if(folder AND (included_layer LESS 0 OR included_layer GREATER layer))
      list(APPEND faults "${file} includes ${header}, which is neither of its own nor of an earlier folder")
    endif()
  endforeach()
endforeach()
foreach(folder ${empty_folders})
  list(APPEND faults "${folder}: no files")
endforeach()
if(faults)
  list(JOIN faults "\n  " faults)
  message(FATAL_ERROR "\n  ${faults}")
endif()
