# Streets and cars drawn by us, compiled once for programs, tests and benchmarks.
include_guard(GLOBAL)
file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_LIST_DIR}/*.cpp)
add_library(scenes STATIC ${sources})
target_link_libraries(scenes PUBLIC tapestry_all PRIVATE tapestry_strict)
