# Makes tapestry.spdx.json, SPDX 2.3: the libraries that this build uses, in the versions that CMake found. The same sources
# and libraries give the same bytes.
function(write_sbom file)
  set(packages)
  set(relations "{\"spdxElementId\": \"SPDXRef-DOCUMENT\", \"relationshipType\": \"DESCRIBES\", \
\"relatedSpdxElement\": \"SPDXRef-tapestry\"}")
  # spdx_add(<name> <version> <licence> [<relation of Tapestry to it>])
  macro(spdx_add name version licence)
    set(package "{\"SPDXID\": \"SPDXRef-${name}\", \"name\": \"${name}\"")
    if(NOT "${version}" STREQUAL "")
      string(APPEND package ", \"versionInfo\": \"${version}\"")
    endif()
    list(APPEND packages "${package}, \"downloadLocation\": \"NOASSERTION\", \"filesAnalyzed\": false, \
\"licenseConcluded\": \"${licence}\", \"licenseDeclared\": \"${licence}\", \"copyrightText\": \"NOASSERTION\"}")
    if(${ARGC} GREATER 3)
      list(APPEND relations "{\"spdxElementId\": \"SPDXRef-tapestry\", \"relationshipType\": \"${ARGV3}\", \
\"relatedSpdxElement\": \"SPDXRef-${name}\"}")
    endif()
  endmacro()

  spdx_add(tapestry ${PROJECT_VERSION} MIT)
  if(TARGET tapestry)  # the tape alone uses no other library
    spdx_add(eigen "${Eigen3_VERSION}" "MPL-2.0 AND BSD-3-Clause" STATIC_LINK)
    spdx_add(xtensor "${xtensor_VERSION}" BSD-3-Clause STATIC_LINK)
    spdx_add(xtl "${xtl_VERSION}" BSD-3-Clause STATIC_LINK)
    spdx_add(stb "${stb_VERSION}" "MIT OR Unlicense" STATIC_LINK)
    spdx_add(protozero "${protozero_VERSION}" "BSD-2-Clause AND Apache-2.0" STATIC_LINK)
    spdx_add(nlohmann-json "${nlohmann_json_VERSION}" MIT STATIC_LINK)
    spdx_add(zlib "${ZLIB_VERSION_STRING}" Zlib DYNAMIC_LINK)
  endif()
  if(TARGET turbojpeg::turbojpeg)
    spdx_add(libjpeg-turbo "${turbojpeg_VERSION}" "IJG AND BSD-3-Clause AND Zlib" DYNAMIC_LINK)
  endif()
  # Versions that a subfolder found are unknown here.
  if(TARGET programs)
    find_package(CLI11 CONFIG QUIET)
    spdx_add(CLI11 "${CLI11_VERSION}" BSD-3-Clause STATIC_LINK)
  endif()
  if(TARGET MPI::MPI_CXX)
    find_package(MPI QUIET COMPONENTS CXX)
    string(REGEX MATCH "[0-9]+(\\.[0-9]+)+" version "${MPI_CXX_LIBRARY_VERSION_STRING}")
    spdx_add(mpi "${version}" NOASSERTION DYNAMIC_LINK)
  endif()
  if(TARGET tapestry_python)
    find_package(pybind11 QUIET)
    spdx_add(pybind11 "${pybind11_VERSION}" BSD-3-Clause STATIC_LINK)
  endif()

  list(JOIN packages ",\n    " packages)
  list(JOIN relations ",\n    " relations)
  set(body "\"packages\": [\n    ${packages}\n  ],\n  \"relationships\": [\n    ${relations}\n  ]\n}\n")
  string(TIMESTAMP created "%Y-%m-%dT%H:%M:%SZ" UTC)
  string(UUID namespace NAMESPACE 6ba7b811-9dad-11d1-80b4-00c04fd430c8 NAME "${created} ${body}" TYPE SHA1)
  file(CONFIGURE OUTPUT ${file} CONTENT "{
  \"spdxVersion\": \"SPDX-2.3\",
  \"dataLicense\": \"CC0-1.0\",
  \"SPDXID\": \"SPDXRef-DOCUMENT\",
  \"name\": \"tapestry-${PROJECT_VERSION}\",
  \"documentNamespace\": \"urn:uuid:${namespace}\",
  \"creationInfo\": {\"created\": \"${created}\", \"creators\": [\"Tool: CMake-${CMAKE_VERSION}\"]},
  ${body}" @ONLY)
endfunction()
