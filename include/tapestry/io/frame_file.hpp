#pragma once
#include <tapestry/io/frame.hpp>

namespace tapestry::io {
/// Reads and validates a frame file: an .npz with the members of the CARLA set of Wang et al. (DAS, FCA),
/// `img` uint8 [H, W, 3] stored as BGR, `veh_trans` and `cam_trans` float64 [2, 3] (row 0 metres, row 1
/// pitch, yaw, roll in degrees; the camera's translation is its offset from the vehicle along world axes).
/// Frames of Tapestry add `camera_matrix` float64 [3, 4] (view_from_world, rotation and translation) and
/// `camera_fov` float64 [2] (tangents of half the field of view), and then need no poses. They may add
/// `light` float64 [8], `mask` uint8 [H, W] and `label` float64 [5].
///
/// Or of three parts, as other programs write them: `x.json` with the same members but picture and mask, as
/// nested lists of numbers, and `"format": "tapestry frame 1"`; the picture `x.png` beside it; and, where
/// there is one, the mask `masks/x.png`, of the picture's extents, in which any value but 0 shows the car.
///
/// \param path  ending in .npz or .json
/// \throws FileError: malformed (damaged file); mismatch (a member or a part is missing, has another shape or
///         type, or has impossible values: not finite, a camera in the vehicle's origin, an empty picture);
///         limit
[[nodiscard]] Frame read_frame(const std::string& path);

/// The picture of a file as RGB, [H, W, 3]: of a frame if the name ends in .npz, else of an image file.
/// \param warnings  as for read_image()
/// \throws FileError as read_frame() or read_image()
[[nodiscard]] Array<std::uint8_t, 3> read_picture(const std::string& path,
                                                  std::vector<std::string>* warnings = nullptr);

/// The files of a frame that are there: the .npz, or JSON, picture and mask.
[[nodiscard]] std::vector<std::string> frame_files(const std::string& path);

/// Writes a frame that read_frame() reads back: deflated, or in three parts if the name ends in .json, which
/// comes last. Each file is whole or not there.
/// \throws ShapeError unless the picture is [H, W, 3] and the mask, if any, [H, W]; FileError (write)
void write_frame(const std::string& path, const Frame& frame);

/// The .npz files of a folder, or if there are none the .json files, sorted by name, numbers by value: data2
/// before data10.
/// \throws FileError: malformed (not a readable folder), mismatch (no such file in it)
[[nodiscard]] std::vector<std::string> frame_paths(const std::string& folder);
}  // namespace tapestry::io
