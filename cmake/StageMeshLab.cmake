# cmake -DSTAGE=folder -DPREFIX=/usr -DLIBRARY_DIR=/usr/lib/<triplet>/meshlab -DPLUGIN=file -P StageMeshLab.cmake
#
# The host looks for plugins relative to its own executable, symbolic links resolved: so the programs are copies, and
# everything else is links into the installed MeshLab, with our plugin beside the stock ones.
file(RELATIVE_PATH library_dir ${PREFIX} ${LIBRARY_DIR})

file(MAKE_DIRECTORY ${STAGE}/bin ${STAGE}/${library_dir}/plugins)
foreach(program meshlab meshlabserver)
  if(EXISTS ${PREFIX}/bin/${program})
    file(COPY ${PREFIX}/bin/${program} DESTINATION ${STAGE}/bin)
  else()
    file(REMOVE ${STAGE}/bin/${program})  # of the release that was installed before
  endif()
endforeach()

file(GLOB libraries ${LIBRARY_DIR}/*.so*)
foreach(library ${libraries})
  get_filename_component(name ${library} NAME)
  file(CREATE_LINK ${library} ${STAGE}/${library_dir}/${name} SYMBOLIC)
endforeach()
file(GLOB plugins ${LIBRARY_DIR}/plugins/*.so)
foreach(plugin ${plugins} ${PLUGIN})
  get_filename_component(name ${plugin} NAME)
  file(CREATE_LINK ${plugin} ${STAGE}/${library_dir}/plugins/${name} SYMBOLIC)
endforeach()
