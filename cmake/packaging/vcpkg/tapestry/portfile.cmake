# An overlay port: vcpkg install tapestry --overlay-ports=<clone>/cmake/packaging/vcpkg builds the clone that it lies in. An
# archive of the sources is built instead where TAPESTRY_ARCHIVE names it; VCPKG_KEEP_ENV_VARS then holds that name.
vcpkg_check_linkage(ONLY_STATIC_LIBRARY)
if(DEFINED ENV{TAPESTRY_ARCHIVE})
  vcpkg_extract_source_archive(SOURCE_PATH ARCHIVE "$ENV{TAPESTRY_ARCHIVE}")
else()
  get_filename_component(SOURCE_PATH "${CMAKE_CURRENT_LIST_DIR}/../../../.." ABSOLUTE)
endif()
vcpkg_check_features(OUT_FEATURE_OPTIONS features INVERTED_FEATURES jpeg CMAKE_DISABLE_FIND_PACKAGE_turbojpeg)
vcpkg_cmake_configure(SOURCE_PATH "${SOURCE_PATH}"
                      OPTIONS -DTAPESTRY_BUILD_TESTS=OFF -DTAPESTRY_BUILD_EXAMPLES=OFF ${features})
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH share/cmake/tapestry)
vcpkg_fixup_pkgconfig()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include" "${CURRENT_PACKAGES_DIR}/debug/share")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
file(INSTALL "${CMAKE_CURRENT_LIST_DIR}/usage" DESTINATION "${CURRENT_PACKAGES_DIR}/share/${PORT}")
