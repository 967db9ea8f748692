# build_before_install(<component> <target>…): `cmake --install` and cpack build these targets where one of them is missing.
# Further arguments of install(CODE) stand in install_options.
function(build_before_install component)
  list(TRANSFORM ARGN REPLACE ".+" "\"$<TARGET_FILE:\\0>\"" OUTPUT_VARIABLE files)
  list(JOIN files " " files)
  list(JOIN ARGN " " targets)
  install(CODE "foreach(file IN ITEMS ${files})
      if(NOT EXISTS \"\${file}\")
        execute_process(COMMAND \"${CMAKE_COMMAND}\" --build \"${PROJECT_BINARY_DIR}\" --config $<CONFIG> --target ${targets}
                        COMMAND_ERROR_IS_FATAL ANY)
      endif()
    endforeach()" COMPONENT ${component} ${install_options})
endfunction()
