# `cpack` in a build folder makes tapestry_VERSION_ARCHITECTURE.deb: headers, and the programs that were built there with
# what they bundle, their manual pages and completions. The libraries that headers include are recommended, not required:
# the programs run without.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME tapestry)
set(TAPESTRY_CONTACT "The Tapestry developers <maintainers@tapestry.invalid>" CACHE STRING
    "Whom users of the Debian package write to, as \"Name <address>\"")
set(CPACK_PACKAGE_CONTACT "${TAPESTRY_CONTACT}")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "differentiable rendering and object detectors on one reverse-mode tape")
set(CPACK_PACKAGE_DESCRIPTION
    "C++20 headers, and programs that optimise, measure and harden against camouflages of cars.")
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS
    "libeigen3-dev, libxtensor-dev, libstb-dev, libprotozero-dev, zlib1g-dev, nlohmann-json3-dev, libturbojpeg0-dev")
find_program(DPKG_SHLIBDEPS dpkg-shlibdeps)  # finds the libraries that the programs are linked with, by file
find_program(FILE_UTILITY file)
if(TAPESTRY_BUILD_EXAMPLES)
  if(DPKG_SHLIBDEPS AND FILE_UTILITY)
    set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
  else()
    message(STATUS "A Debian package made here states no dependencies: that needs dpkg-dev and file")
  endif()
endif()
if(TARGET MPI::MPI_CXX)  # linked by camouflage and evaluate, which do not start without it
  message(STATUS "A Debian package made here depends on the MPI library that was found; TAPESTRY_MPI=OFF leaves it out")
endif()
# What Debian asks for beside the files: who may do what, and a changelog in its form, compressed.
file(READ ${PROJECT_SOURCE_DIR}/LICENSE licence)
file(WRITE ${PROJECT_BINARY_DIR}/package/copyright
     "Tapestry, by its developers, under the MIT licence:\n\n${licence}\nWhat CHANGELOG.md beside this file says has changed.\n")
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
file(WRITE ${PROJECT_BINARY_DIR}/package/changelog
     "tapestry (${PROJECT_VERSION}) unstable; urgency=medium\n\n  * See CHANGELOG.md.\n\n -- ${TAPESTRY_CONTACT}  ${date}\n")
find_program(GZIP gzip)
if(GZIP)
  execute_process(COMMAND ${GZIP} -9nf ${PROJECT_BINARY_DIR}/package/changelog)
  install(FILES ${PROJECT_BINARY_DIR}/package/copyright ${PROJECT_BINARY_DIR}/package/changelog.gz
                ${PROJECT_SOURCE_DIR}/CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
endif()
include(CPack)
