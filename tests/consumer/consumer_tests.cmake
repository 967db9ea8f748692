# Installs Tapestry into a temporary folder and builds, links and runs projects against that: one that uses all of it,
# one that uses the tape alone. Then the same with Tapestry as a subfolder of theirs.
set(consumer_dir ${CMAKE_CURRENT_BINARY_DIR}/consumer)

# add_consumer_test(<what> <folder of the project> <option>): the test "consumer: <what>".
function(add_consumer_test what folder option)
  string(MAKE_C_IDENTIFIER ${what} build_folder)
  add_test(NAME "consumer: ${what}"
           COMMAND ${CMAKE_COMMAND} -DSOURCE_DIR=${CMAKE_CURRENT_SOURCE_DIR}/${folder}
                   -DBINARY_DIR=${consumer_dir}/${build_folder} -DOPTION=${option} -DCOMPILER=${CMAKE_CXX_COMPILER}
                   -DGENERATOR=${CMAKE_GENERATOR} -P ${CMAKE_CURRENT_SOURCE_DIR}/consumer/build_consumer.cmake)
  set_tests_properties("consumer: ${what}" PROPERTIES TIMEOUT 300 COST 200)
  if(TAPESTRY_CCACHE_PROGRAM)
    set_tests_properties("consumer: ${what}" PROPERTIES
      ENVIRONMENT "CMAKE_CXX_COMPILER_LAUNCHER=ccache;CCACHE_BASEDIR=${PROJECT_SOURCE_DIR};CCACHE_NOHASHDIR=1")
  endif()
endfunction()

add_consumer_test("add_subdirectory" consumer -DTAPESTRY_SOURCES=${PROJECT_SOURCE_DIR})
add_consumer_test("add_subdirectory of the tape alone" consumer/autodiff -DTAPESTRY_SOURCES=${PROJECT_SOURCE_DIR})
if(TAPESTRY_INSTALL)
  add_test(NAME "consumer: install"
           COMMAND ${CMAKE_COMMAND} --install ${PROJECT_BINARY_DIR} --prefix ${consumer_dir}/prefix)
  set_tests_properties("consumer: install" PROPERTIES FIXTURES_SETUP installed_tapestry)
  add_consumer_test("find_package" consumer -DCMAKE_PREFIX_PATH=${consumer_dir}/prefix)
  add_consumer_test("find_package of the tape alone" consumer/autodiff -DCMAKE_PREFIX_PATH=${consumer_dir}/prefix)
  set(installed_tests "consumer: find_package" "consumer: find_package of the tape alone")
  find_program(PKG_CONFIG NAMES pkg-config pkgconf)
  if(PKG_CONFIG)
    add_test(NAME "consumer: pkg-config" COMMAND ${PKG_CONFIG} --cflags --print-errors tapestry)
    set_tests_properties("consumer: pkg-config" PROPERTIES PASS_REGULAR_EXPRESSION "-isystem [^ ]*/include .*eigen3"
                         ENVIRONMENT "PKG_CONFIG_PATH=${consumer_dir}/prefix/${CMAKE_INSTALL_DATADIR}/pkgconfig")
    list(APPEND installed_tests "consumer: pkg-config")
    set(configure ${CMAKE_COMMAND} -S ${PROJECT_SOURCE_DIR} -B ${consumer_dir}/absolute -DTAPESTRY_BUILD_TESTS=OFF
        -DTAPESTRY_BUILD_EXAMPLES=OFF -DCMAKE_INSTALL_INCLUDEDIR=/opt/x/include -DCMAKE_INSTALL_LIBDIR=/opt/x/lib)
    list(JOIN configure " " configure)
    add_test(NAME "consumer: pkg-config with absolute folders"
             COMMAND sh -c "${configure} && ${PKG_CONFIG} --cflags --libs tapestry")
    set_tests_properties("consumer: pkg-config with absolute folders" PROPERTIES
                         PASS_REGULAR_EXPRESSION "-isystem /opt/x/include .*-L/opt/x/lib "
                         ENVIRONMENT "PKG_CONFIG_PATH=${consumer_dir}/absolute/pkgconfig/prefix")
    # The tape alone, installed by itself: a program that pkg-config compiles, with no other library in its flags.
    set(alone ${consumer_dir}/alone)
    set(install ${CMAKE_COMMAND} -S ${PROJECT_SOURCE_DIR} -B ${alone} -DTAPESTRY_AUTODIFF_ONLY=ON
        -DCMAKE_INSTALL_PREFIX=${alone}/prefix && ${CMAKE_COMMAND} --install ${alone})
    list(JOIN install " " install)
    add_test(NAME "consumer: pkg-config of the tape alone"
             COMMAND sh -c "${install} && flags=$(${PKG_CONFIG} --cflags --libs --print-errors tapestry-autodiff) && echo $flags && \
${CMAKE_CXX_COMPILER} -std=c++20 ${CMAKE_CURRENT_SOURCE_DIR}/consumer/autodiff/main.cpp $flags -o ${alone}/program && \
${alone}/program && echo works")
    set_tests_properties("consumer: pkg-config of the tape alone" PROPERTIES
                         PASS_REGULAR_EXPRESSION "\n-isystem [^ \n]*/alone/prefix/[^ \n]*include *\nworks\n"
                         ENVIRONMENT "PKG_CONFIG_LIBDIR=${alone}/prefix/${CMAKE_INSTALL_DATADIR}/pkgconfig")
  endif()
  add_test(NAME "consumer: the SBOM has what SPDX 2.3 demands"
           COMMAND ${CMAKE_COMMAND} -DSBOM=${consumer_dir}/prefix/${CMAKE_INSTALL_DOCDIR}/tapestry.spdx.json
                   -DPKG_CONFIG=${PKG_CONFIG} -P ${CMAKE_CURRENT_SOURCE_DIR}/consumer/check_sbom.cmake)
  add_test(NAME "consumer: links of installed pages lead somewhere"
           COMMAND ${CMAKE_COMMAND} -DFOLDER=${consumer_dir}/prefix/${CMAKE_INSTALL_DOCDIR}
                   -P ${CMAKE_CURRENT_SOURCE_DIR}/consumer/check_links.cmake)
  list(APPEND installed_tests "consumer: the SBOM has what SPDX 2.3 demands"
       "consumer: links of installed pages lead somewhere")
  set_tests_properties(${installed_tests} PROPERTIES FIXTURES_REQUIRED installed_tapestry)
endif()

# The recipes of package managers that are not installed run here by stand-ins; a project is built on what they install.
add_test(NAME "consumer: vcpkg port"
         COMMAND ${CMAKE_COMMAND} -DSOURCE_DIR=${PROJECT_SOURCE_DIR} -DWORK_DIR=${consumer_dir}/vcpkg
                 -P ${CMAKE_CURRENT_SOURCE_DIR}/consumer/try_vcpkg_port.cmake)
add_consumer_test("find_package behind the vcpkg port" consumer/linked -DCMAKE_PREFIX_PATH=${consumer_dir}/vcpkg/packages)
add_test(NAME "consumer: Conan recipe"
         COMMAND python3 ${CMAKE_CURRENT_SOURCE_DIR}/consumer/try_conan_recipe.py ${PROJECT_SOURCE_DIR} ${consumer_dir}/conan)
add_consumer_test("find_package behind the Conan recipe" consumer/linked -DCMAKE_PREFIX_PATH=${consumer_dir}/conan/package)
foreach(recipe IN ITEMS "vcpkg port" "Conan recipe")
  set_tests_properties("consumer: ${recipe}" PROPERTIES FIXTURES_SETUP ${recipe} TIMEOUT 900 COST 200)
  set_tests_properties("consumer: find_package behind the ${recipe}" PROPERTIES FIXTURES_REQUIRED ${recipe})
endforeach()
