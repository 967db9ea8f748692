# Streets and cars drawn by us, compiled once for programs, tests and benchmarks: the frames of a drawn car, which camouflage
# begins with, and what is drawn to train and measure.
include_guard(GLOBAL)
set(frame_sources car drawn_frames make_scene picture scene_parts)
list(TRANSFORM frame_sources REPLACE "(.+)" "${CMAKE_CURRENT_LIST_DIR}/\\1.cpp")
file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_LIST_DIR}/*.cpp)
list(REMOVE_ITEM sources ${frame_sources})
add_library(drawn_frames STATIC ${frame_sources})
add_library(scenes STATIC ${sources})
set_target_properties(drawn_frames PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 0)
target_link_libraries(drawn_frames PUBLIC tapestry_laboratory PRIVATE tapestry_strict)
target_link_libraries(scenes PUBLIC drawn_frames PRIVATE tapestry_strict)
