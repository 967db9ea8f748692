# Runs check_layers.cmake on small trees below WORK_DIR, each with or without one deliberate violation.
cmake_minimum_required(VERSION 3.21)
set(include_dir "${WORK_DIR}/include/tapestry")

# Writes `header` with the given first lines into a tree that is otherwise in order, and checks the verdict.
function(expect verdict header text)
  file(REMOVE_RECURSE "${WORK_DIR}")
  foreach(name IN ITEMS core/array.hpp core/check.hpp autodiff/tape.hpp geometry/mesh.hpp image/resize.hpp
                        raster/render.hpp loss/overlap.hpp io/obj_file.hpp io/implementation.hpp
                        camouflage/training.hpp evaluate/report.hpp version.hpp autodiff.hpp tapestry.hpp)
    file(WRITE "${include_dir}/${name}" "#pragma once\n#include <vector>\n")
  endforeach()
  file(WRITE "${include_dir}/${header}" "${text}")
  execute_process(COMMAND "${CMAKE_COMMAND}" -DINCLUDE_DIR=${include_dir} -P "${CMAKE_CURRENT_LIST_DIR}/check_layers.cmake"
                  RESULT_VARIABLE result ERROR_VARIABLE complaint OUTPUT_QUIET)
  string(REGEX REPLACE "[ \n]+" " " complaint "${complaint}")  # CMake wraps its messages
  if(verdict STREQUAL "accepted" AND NOT result EQUAL 0)
    message(SEND_ERROR "should be accepted: ${header}: ${text}\n${complaint}")
  elseif(NOT verdict STREQUAL "accepted" AND result EQUAL 0)
    message(SEND_ERROR "should be refused: ${header}: ${text}")
  elseif(NOT verdict STREQUAL "accepted" AND NOT complaint MATCHES "${verdict}")
    message(SEND_ERROR "${header}: expected \"${verdict}\", found: ${complaint}")
  endif()
endfunction()

expect(accepted core/check.hpp "#pragma once\n#include <tapestry/core/array.hpp>\n#include <tapestry/version.hpp>\n")
expect(accepted raster/render.hpp "#pragma once\n#include <tapestry/geometry/mesh.hpp>\n#include <vector>\n")
expect(accepted autodiff.hpp "#pragma once\n#include <tapestry/autodiff/tape.hpp>\n")
expect(accepted tapestry.hpp "#pragma once\n#include <tapestry/evaluate/report.hpp>\n#include <tapestry/autodiff.hpp>\n")
expect(accepted io/obj_file.hpp "#pragma once\n#include <tiny_obj_loader.h>\n#include <stb/stb_image.h>\n")
expect(accepted core/array.hpp "#pragma once\n#include <xtensor/xtensor.hpp>\n")

expect("may not include raster" geometry/mesh.hpp "#pragma once\n#include <tapestry/raster/render.hpp>\n")
expect("may not include autodiff" core/array.hpp "#pragma once\n  #  include <tapestry/autodiff/tape.hpp>\n")
expect("may not include image" geometry/mesh.hpp "#pragma once\n#include <tapestry/image/resize.hpp>\n")
expect("may not include camouflage" evaluate/report.hpp "#pragma once\n#include <tapestry/camouflage/training.hpp>\n")
expect("may not include tapestry" evaluate/report.hpp "#pragma once\n#include <tapestry/tapestry.hpp>\n")
expect("may not include geometry" autodiff.hpp "#pragma once\n#include <tapestry/geometry/mesh.hpp>\n")
expect("one source file of a program" tapestry.hpp "#pragma once\n#include <tapestry/io/implementation.hpp>\n")
expect("does not exist" core/check.hpp "#pragma once\n#include <tapestry/core/absent.hpp>\n")
expect("on no level" utils/text.hpp "#pragma once\n")
expect("relative path" core/check.hpp "#pragma once\n#include \"../loss/overlap.hpp\"\n")
expect("belong to io" raster/render.hpp "#pragma once\n#include <stb/stb_image.h>\n")
expect("xtensor itself" loss/overlap.hpp "#pragma once\n#include <xtensor/xview.hpp>\n")
expect("only programs use" io/obj_file.hpp "#pragma once\n#include <nlohmann/json.hpp>\n")
expect("pragma once" core/check.hpp "#include <vector>\n")
string(REPEAT "\n" 300 too_many_lines)
expect("has 301 lines" core/check.hpp "#pragma once\n${too_many_lines}")
