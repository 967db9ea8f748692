# Installs the headers, what find_package(tapestry) needs, and tapestry.pc. The components autodiff, tapestry and laboratory
# are targets of these names: find_package(tapestry COMPONENTS autodiff) looks for no other library.
include(CMakePackageConfigHelpers)
set(tapestry_cmake_dir ${CMAKE_INSTALL_DATADIR}/cmake/tapestry)
set(tapestry_components autodiff)
if(TARGET tapestry)
  list(APPEND tapestry_components tapestry laboratory)
endif()
set(tapestry_headers FILES_MATCHING PATTERN *.hpp PATTERN *.inl)
if(TARGET tapestry)
  install(DIRECTORY include/tapestry DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} ${tapestry_headers})
else()
  install(DIRECTORY include/tapestry/autodiff include/tapestry/core
          DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/tapestry ${tapestry_headers})
  install(FILES include/tapestry/autodiff.hpp include/tapestry/version.hpp
          DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/tapestry)
endif()
install(TARGETS tapestry_autodiff EXPORT autodiffTargets)
if(TARGET tapestry)
  install(TARGETS tapestry tapestry_float tapestry_compiled EXPORT tapestryTargets)
  install(TARGETS tapestry_laboratory EXPORT laboratoryTargets)
endif()
foreach(component IN LISTS tapestry_components)
  install(EXPORT ${component}Targets NAMESPACE tapestry:: DESTINATION ${tapestry_cmake_dir})
endforeach()
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/tapestryConfig.cmake.in tapestryConfig.cmake
                              INSTALL_DESTINATION ${tapestry_cmake_dir})
write_basic_package_version_file(tapestryConfigVersion.cmake COMPATIBILITY SameMinorVersion ARCH_INDEPENDENT)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/tapestryConfig.cmake
              ${CMAKE_CURRENT_BINARY_DIR}/tapestryConfigVersion.cmake ${CMAKE_CURRENT_LIST_DIR}/Findstb.cmake
              ${CMAKE_CURRENT_LIST_DIR}/Findprotozero.cmake ${CMAKE_CURRENT_LIST_DIR}/Findturbojpeg.cmake
        DESTINATION ${tapestry_cmake_dir})
if(TARGET tapestry)
  if(TARGET turbojpeg::turbojpeg)  # as found here: who has no libjpeg-turbo builds without it
    set(tapestry_pc_requires " libturbojpeg")
    set(tapestry_pc_flags " -DTAPESTRY_JPEG")
  endif()
  # Folders of an installation may be absolute; joined to a prefix, they then take its place.
  set(tapestry_pc_prefix \${pcfiledir})
  foreach(folder IN ITEMS INCLUDEDIR LIBDIR)
    set(tapestry_pc_${folder} \${prefix})
    cmake_path(APPEND tapestry_pc_${folder} ${CMAKE_INSTALL_${folder}})
  endforeach()
  set(tapestry_pc_folder ${CMAKE_INSTALL_DATADIR}/pkgconfig)
  if(IS_ABSOLUTE ${tapestry_pc_folder})
    set(tapestry_pc_prefix ${CMAKE_INSTALL_PREFIX})
  else()
    cmake_path(SET up /prefix)
    cmake_path(RELATIVE_PATH up BASE_DIRECTORY /prefix/${tapestry_pc_folder})
    string(APPEND tapestry_pc_prefix /${up})
    string(PREPEND tapestry_pc_folder \${CMAKE_INSTALL_PREFIX}/)
  endif()
  # System headers bring no warnings. Those below /usr are such anyway, and named by -isystem that folder would come
  # before that of the standard library, which then does not find the C library's headers.
  foreach(folder IN ITEMS prefix usr)
    set(tapestry_pc_include "-isystem ")
    if(folder STREQUAL usr)
      set(tapestry_pc_include "-I")
    endif()
    configure_file(${CMAKE_CURRENT_LIST_DIR}/tapestry.pc.in pkgconfig/${folder}/tapestry.pc @ONLY)
  endforeach()
  install(CODE "
    set(folder prefix)
    if(CMAKE_INSTALL_PREFIX MATCHES \"(^|/)usr/?$\")
      set(folder usr)
    endif()
    file(INSTALL DESTINATION \"${tapestry_pc_folder}\"
         FILES \"${CMAKE_CURRENT_BINARY_DIR}/pkgconfig/\${folder}/tapestry.pc\")")
endif()
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
