# Headers, library and options must be of one MeshLab: the first generation loads any plugin, and a wrong scalar or
# version then corrupts memory; the second refuses to load it. So what does not fit together is refused here.

function(check_meshlab_options)
  if(NOT SHRINKWRAP_MESHLAB_GENERATION MATCHES "^(2020|2021)?$")
    message(FATAL_ERROR "SHRINKWRAP_MESHLAB_GENERATION is '${SHRINKWRAP_MESHLAB_GENERATION}': 2020, 2021 or empty")
  endif()
  if(NOT SHRINKWRAP_MESHLAB_SCALAR MATCHES "^(float|double)$")
    message(FATAL_ERROR "SHRINKWRAP_MESHLAB_SCALAR is '${SHRINKWRAP_MESHLAB_SCALAR}': float or double")
  endif()
endfunction()

# Version and generation of the interface of the sources in `folder`.
function(meshlab_of_sources folder version_result generation_result)
  if(NOT EXISTS ${folder}/ML_VERSION)
    message(FATAL_ERROR "No ML_VERSION in ${folder}: it is not the top folder of MeshLab's sources")
  endif()
  file(STRINGS ${folder}/ML_VERSION version LIMIT_COUNT 1)
  string(STRIP "${version}" version)
  if(EXISTS ${folder}/src/common/interfaces.h)
    set(generation 2020)
  elseif(EXISTS ${folder}/src/common/plugins/interfaces/filter_plugin.h)
    set(generation 2021)
  else()
    message(FATAL_ERROR "The headers of MeshLab ${version} in ${folder} are of neither generation that this plugin "
                        "knows: 2020.09, and 2021.05 and later")
  endif()
  if(SHRINKWRAP_MESHLAB_GENERATION AND NOT SHRINKWRAP_MESHLAB_GENERATION EQUAL generation)
    message(FATAL_ERROR "SHRINKWRAP_MESHLAB_GENERATION is ${SHRINKWRAP_MESHLAB_GENERATION}, but the headers of MeshLab "
                        "${version} in ${folder} are of generation ${generation}: leave the option empty, or pass the "
                        "sources of the MeshLab to build for as SHRINKWRAP_MESHLAB_SOURCE_DIR")
  endif()
  set(${version_result} ${version} PARENT_SCOPE)
  set(${generation_result} ${generation} PARENT_SCOPE)
endfunction()

# The library must be of the headers' version and of the scalar that was asked for, as far as it tells: by the version
# that it was compiled with, and by the type that a constructor takes.
function(check_meshlab_library library version)
  file(STRINGS ${library} versions REGEX "^20[0-9][0-9]\\.[0-9][0-9]d?$")
  string(REGEX REPLACE "d(;|$)" "\\1" versions "${versions}")
  if(versions AND NOT version IN_LIST versions)
    list(GET versions 0 other)
    message(FATAL_ERROR "${library} is of MeshLab ${other}, but the headers are of ${version}: pass the sources of the "
                        "same release as SHRINKWRAP_MESHLAB_SOURCE_DIR, or remove the fetched ones to have them fetched "
                        "again")
  endif()
  file(STRINGS ${library} constructors REGEX "^_ZN9RichFloatC[12]ERK7QString[fd]")
  if(constructors MATCHES "7QStringf")
    set(scalar float)
  elseif(constructors MATCHES "7QStringd")
    set(scalar double)
  else()
    message(STATUS "MeshLab's library does not tell its scalar: ${SHRINKWRAP_MESHLAB_SCALAR} is taken")
    return()
  endif()
  if(NOT scalar STREQUAL SHRINKWRAP_MESHLAB_SCALAR)
    message(FATAL_ERROR "${library} was built with ${scalar}, but SHRINKWRAP_MESHLAB_SCALAR is "
                        "${SHRINKWRAP_MESHLAB_SCALAR}: set it to ${scalar}, or pass the library to build for as "
                        "SHRINKWRAP_MESHLAB_COMMON")
  endif()
endfunction()
