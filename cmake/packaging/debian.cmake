# Run by cpack between installing and packing: lays Debian's files into each package, and gives all the same modes whatever
# the umask was.
set(sbom "${tapestry_debian_files}/../tapestry.spdx.json")
foreach(component IN LISTS CPACK_COMPONENTS_ALL)
  string(TOUPPER ${component} upper)
  set(root "${CPACK_TEMPORARY_INSTALL_DIRECTORY}/${component}")
  set(documents "${root}/usr/share/doc/${CPACK_DEBIAN_${upper}_PACKAGE_NAME}")
  if(EXISTS "${root}/usr/share/doc/tapestry")
    file(RENAME "${root}/usr/share/doc/tapestry" "${documents}")
    file(REMOVE "${documents}/LICENSE")
    file(CREATE_LINK copyright "${documents}/LICENSE" SYMBOLIC)  # where it stands
  endif()
  file(COPY "${sbom}" "${tapestry_debian_files}/copyright" "${tapestry_debian_files}/changelog"
            "${tapestry_debian_files}/changelog.Debian" DESTINATION "${documents}")
  file(WRITE "${root}/usr/share/lintian/overrides/${CPACK_DEBIAN_${upper}_PACKAGE_NAME}"
       "# It is made of any commit and uploaded nowhere, so that there is no bug that it could close.\n"
       "${CPACK_DEBIAN_${upper}_PACKAGE_NAME}: initial-upload-closes-no-bugs *\n")
  execute_process(COMMAND gzip -9n "${documents}/changelog" "${documents}/changelog.Debian" COMMAND_ERROR_IS_FATAL ANY)
  execute_process(COMMAND chmod -R u=rwX,go=rX "${root}" COMMAND_ERROR_IS_FATAL ANY)
endforeach()
