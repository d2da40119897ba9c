# What is installed, and where: the plugin among MeshLab's own, so that the prefix is MeshLab's unless another is asked
# for. `cpack` makes a Debian package of it.
set(SHRINKWRAP_PACKAGE_CONTACT "" CACHE STRING
    "Maintainer of the Debian package, 'name <address>': whoever publishes it must say. Empty: DEBFULLNAME and DEBEMAIL \
of the environment; without these, who built it, for use on this machine alone")

if(CMAKE_INSTALL_PREFIX_INITIALIZED_TO_DEFAULT)
  set(CMAKE_INSTALL_PREFIX ${meshlab_prefix} CACHE PATH "MeshLab's own prefix: elsewhere it finds no plugin" FORCE)
endif()
file(RELATIVE_PATH plugin_destination ${meshlab_prefix} ${MESHLAB_PLUGIN_DIR})
install(TARGETS filter_shrinkwrap_recon LIBRARY DESTINATION ${plugin_destination})

# --- documents -----------------------------------------------------------------------------------------------------
set(package_name meshlab-plugin-shrinkwrap)
set(package_release 1+meshlab${meshlab_version})  # in the file's name too, since a package is for one release only
set(package_contact ${SHRINKWRAP_PACKAGE_CONTACT})
if(NOT package_contact AND DEFINED ENV{DEBFULLNAME} AND DEFINED ENV{DEBEMAIL})
  set(package_contact "$ENV{DEBFULLNAME} <$ENV{DEBEMAIL}>")
elseif(NOT package_contact)
  execute_process(COMMAND id -un OUTPUT_VARIABLE builder OUTPUT_STRIP_TRAILING_WHITESPACE)
  cmake_host_system_information(RESULT builder_host QUERY FQDN)
  set(package_contact "unpublished local build <${builder}@${builder_host}>")
  message(STATUS "Maintainer of the Debian package: ${package_contact}; to publish it, set SHRINKWRAP_PACKAGE_CONTACT")
endif()

# Debian wants both changelogs compressed, without a date inside (-n), so that the same sources give the same package.
find_program(SHRINKWRAP_GZIP gzip REQUIRED)
string(TIMESTAMP package_date "%a, %d %b %Y %H:%M:%S +0000" UTC)  # or SOURCE_DATE_EPOCH
set(package_documents ${PROJECT_BINARY_DIR}/package)
configure_file(cmake/package/changelog.Debian.in ${package_documents}/changelog.Debian @ONLY)
configure_file(CHANGELOG.md ${package_documents}/changelog COPYONLY)
foreach(changelog changelog changelog.Debian)
  execute_process(COMMAND ${SHRINKWRAP_GZIP} -9nf ${package_documents}/${changelog} RESULT_VARIABLE gzip_result)
  if(NOT gzip_result EQUAL 0)
    message(FATAL_ERROR "${package_documents}/${changelog} could not be compressed")
  endif()
endforeach()

set(document_destination share/doc/${package_name})
install(FILES cmake/package/copyright README.md ${package_documents}/changelog.gz
              ${package_documents}/changelog.Debian.gz
        DESTINATION ${document_destination})
install(DIRECTORY docs DESTINATION ${document_destination} FILES_MATCHING PATTERN "*.md" PATTERN "*.png"
        PATTERN "*.svg")
install(FILES sample_clouds/reconstruct.mlx DESTINATION ${document_destination}/examples)

# --- the Debian package --------------------------------------------------------------------------------------------
# Without these CPack fails, or leaves the libraries out of what the package depends on: said while there is time.
foreach(tool file dpkg-shlibdeps)
  find_program(SHRINKWRAP_TOOL_${tool} ${tool})
  mark_as_advanced(SHRINKWRAP_TOOL_${tool})
  if(NOT SHRINKWRAP_TOOL_${tool})
    message(STATUS "${tool} is missing: no Debian package can be made (apt-get install dpkg-dev file)")
  endif()
endforeach()
set(CPACK_VERBATIM_VARIABLES ON)  # there are quotes in the description
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME ${package_name})
set(CPACK_PACKAGE_CONTACT ${package_contact})
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "complete surface reconstruction for MeshLab")
set(CPACK_PACKAGE_DESCRIPTION
    "A MeshLab plugin that turns a point cloud without normals into a closed
2-manifold mesh whose vertices are exactly the points. It adds the filter
\"Surface Reconstruction: Shrink Wrap\", the stages of the method one by one,
and a report on how a mesh matches its samples.")
set(CPACK_PACKAGING_INSTALL_PREFIX ${meshlab_prefix})
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE ${package_release})
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${meshlab_library_dir})
# MeshLab's own library has no stable interface, so that a plugin belongs to one release of it: "2020.09.~" is above
# every Debian revision of 2020.09 and below whatever comes after it.
set(CPACK_DEBIAN_PACKAGE_DEPENDS "meshlab (>= ${meshlab_version}), meshlab (<< ${meshlab_version}.~)")
include(CPack)
