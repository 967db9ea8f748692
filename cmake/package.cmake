# `cpack` in a build folder makes Debian packages: libtapestry-dev and, where their targets are, tapestry-tools and
# python3-tapestry. The same sources, compiler and libraries give the same bytes, in any folder and at any time. For Windows it
# makes one zip of everything.
set(CPACK_PACKAGE_NAME tapestry)
set(CPACK_STRIP_FILES ON)
if(WIN32)
  set(CPACK_GENERATOR ZIP)
  include(CPack)
  return()
endif()
set(CPACK_GENERATOR DEB)
set(TAPESTRY_CONTACT "The Tapestry developers <maintainers@tapestry.invalid>" CACHE STRING
    "Whom users of the Debian packages write to, as \"Name <address>\"")
set(CPACK_PACKAGE_CONTACT "${TAPESTRY_CONTACT}")
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SOURCE tapestry)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_CONFLICTS tapestry)  # all of it in one package, as it was up to 0.3
set(CPACK_DEBIAN_PACKAGE_REPLACES tapestry)
find_program(DPKG_SHLIBDEPS dpkg-shlibdeps)  # finds the libraries that programs are linked with, by file
find_program(FILE_UTILITY file)
if(DPKG_SHLIBDEPS AND FILE_UTILITY)
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
elseif(TARGET programs OR TARGET tapestry_python)
  message(STATUS "A Debian package made here states no libraries: that needs dpkg-dev and file")
endif()

# deb_package(<component> <package> <section> <dependencies> <summary> <line of the description>…)
macro(deb_package component package section depends summary)
  string(TOUPPER ${component} upper)
  list(APPEND CPACK_COMPONENTS_ALL ${component})
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${package})
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${section})
  set(CPACK_DEBIAN_${upper}_PACKAGE_DEPENDS "${depends}")
  string(REPLACE ";" "\n" CPACK_DEBIAN_${upper}_DESCRIPTION "${summary};${ARGN}")
endmacro()
set(folder ${PROJECT_BINARY_DIR}/package)
set(CPACK_COMPONENTS_ALL "")
set(headers "")
if(TARGET tapestry)
  set(headers "libeigen3-dev (>= 3.4), libxtensor-dev, libstb-dev, libprotozero-dev, nlohmann-json3-dev, zlib1g-dev")
  if(TARGET turbojpeg::turbojpeg)
    string(APPEND headers ", libturbojpeg0-dev")
  endif()
endif()
deb_package(development libtapestry-dev libdevel "${headers}"
  "differentiable rendering and object detectors (development)"
  "Tapestry is a C++20 library for research on the robustness of object"
  "detectors. On a reverse-mode tape it has a differentiable rasteriser,"
  "compositing, losses, and detectors read from Darknet or ONNX files."
  "."
  "This package has the headers, their bodies as static libraries, what CMake"
  "and pkg-config need, the pages for developers, and a list of the libraries"
  "that it was built with.")
if(TARGET programs)
  deb_package(programs tapestry-tools science ""
    "optimise and measure camouflages against object detectors"
    "Tapestry optimises a full-coverage camouflage for a car, measures over"
    "held-out views how easily an object detector loses the car, and trains"
    "detectors that lose it less easily, on an ordinary processor."
    "."
    "This package has the programs, their manual pages and completions, and a"
    "small detector, cars and street scenes to try them on.")
endif()
if(TARGET tapestry_python)
  find_package(Python QUIET COMPONENTS Interpreter)  # whose version examples/python alone knows
  math(EXPR next "${Python_VERSION_MINOR} + 1")
  deb_package(python python3-tapestry python
    "python3 (>= 3.${Python_VERSION_MINOR}~), python3 (<< 3.${next}), python3-numpy"
    "differentiable rendering and object detectors (Python 3)"
    "Tapestry is a library for research on the robustness of object detectors:"
    "detectors read from Darknet or ONNX files, a differentiable rasteriser,"
    "compositing, losses and full-coverage camouflages, with gradients."
    "."
    "This package has them as functions of NumPy arrays.")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS python3-torch)
  foreach(step IN ITEMS postinst=py3compile prerm=py3clean)  # bytecode comes and goes with the package
    string(REPLACE "=" ";" step ${step})
    list(POP_BACK step tool)
    file(WRITE ${folder}/${step}
         "#!/bin/sh\nset -e\nif command -v ${tool} >/dev/null; then ${tool} -p python3-tapestry; fi\n")
    list(APPEND CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA ${folder}/${step})
  endforeach()
endif()
if(TARGET MPI::MPI_CXX)  # linked by camouflage and evaluate, which do not start without it
  message(STATUS "tapestry-tools made here depends on the MPI library that was found; TAPESTRY_MPI=OFF leaves it out")
endif()

# Debian's own files, which are no part of an installation: who may do what, and a changelog in Debian's form.
file(READ ${PROJECT_SOURCE_DIR}/LICENSE licence)
file(WRITE ${folder}/copyright "Tapestry, by its developers, under the MIT licence:\n\n${licence}
What is compiled from headers of other libraries has their licences, which tapestry.spdx.json beside this file names.\n")
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
file(WRITE ${folder}/changelog.Debian "tapestry (${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE}) unstable; urgency=medium

  * Changes are listed in changelog.gz.

 -- ${TAPESTRY_CONTACT}  ${date}\n")
configure_file(${PROJECT_SOURCE_DIR}/CHANGELOG.md ${folder}/changelog COPYONLY)
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/packaging/debian.cmake)
set(CPACK_POST_BUILD_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/packaging/deb_modes.cmake)
set(CPACK_PROJECT_CONFIG_FILE ${folder}/settings.cmake)
file(WRITE ${folder}/settings.cmake "set(tapestry_debian_files \"${folder}\")\nset(ENV{SOURCE_DATE_EPOCH} $ENV{SOURCE_DATE_EPOCH})\n")
include(CPack)
