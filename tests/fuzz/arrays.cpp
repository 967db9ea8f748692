// NumPy's arrays and archives of them, and the frames and checkpoints that are such archives.

#include <tapestry/camouflage/run_state.hpp>
#include <tapestry/io/frame_file.hpp>
#include <tapestry/io/npy.hpp>

#include "target.hpp"

namespace {
using namespace tapestry;

void read_npy(const std::string& bytes) {
  const io::NpyArray array = io::parse_npy(bytes, "a.npy");
  (void)array.as<double>();
}

std::vector<std::string> npy_seeds() {
  const std::size_t shape[]{2, 3};
  const double numbers[]{1, -0.0, 1e300, 5e-324, 0.5, 3};
  const std::uint8_t bytes[]{0, 1, 2, 3, 4, 255};
  std::string columns = io::npy_bytes<double>(shape, numbers);
  columns.replace(columns.find("False,"), 6, "True, ");
  std::string swapped = io::npy_bytes<double>(shape, numbers);
  swapped.replace(swapped.find('<'), 1, ">");
  return {io::npy_bytes<double>(shape, numbers), columns, swapped, io::npy_bytes<std::uint8_t>(shape, bytes)};
}

/// Members, stored and deflated, of sound arrays.
std::vector<std::string> npz_seeds() {
  io::ZipWriter writer;
  const auto arrays = npy_seeds();
  writer.add("stored.npy", arrays.front(), false);
  writer.add("deflated.npy", arrays.back(), true);
  writer.add("readme.txt", "no array", false);
  return {writer.bytes(), io::ZipWriter().bytes()};
}

std::uint32_t little_endian(const std::string& file, std::size_t at, std::size_t size) {
  std::uint32_t value = 0;
  for (std::size_t i = size; i-- > 0;) value = value << 8U | static_cast<unsigned char>(file[at + i]);
  return value;
}

/// Puts the checksum of every member's content right, as far as members can be found.
std::string with_zip_checksums(std::string file) {
  for (std::size_t at = 0; (at = file.find("PK\x01\x02", at)) != std::string::npos; at += 4) {
    if (at + 46 > file.size()) break;
    const std::size_t local = little_endian(file, at + 42, 4), packed = little_endian(file, at + 20, 4);
    if (local + 30 > file.size()) continue;
    const std::size_t begin =
        local + 30 + little_endian(file, local + 26, 2) + little_endian(file, local + 28, 2);
    if (begin > file.size() || packed > file.size() - begin) continue;
    std::string content = file.substr(begin, packed);
    if (little_endian(file, at + 10, 2) == 8) {
      std::string unpacked(1U << 16U, '\0');
      z_stream stream{};
      if (inflateInit2(&stream, -15) != Z_OK) continue;
      stream.next_in = reinterpret_cast<Bytef*>(content.data());
      stream.avail_in = static_cast<uInt>(content.size());
      stream.next_out = reinterpret_cast<Bytef*>(unpacked.data());
      stream.avail_out = static_cast<uInt>(unpacked.size());
      (void)inflate(&stream, Z_FINISH);
      content.assign(unpacked, 0, stream.total_out);
      inflateEnd(&stream);
    }
    const auto sum = crc32_z(0, reinterpret_cast<const Bytef*>(content.data()), content.size());
    for (std::size_t i = 0; i < 4; ++i)
      file[at + 16 + i] = file[local + 14 + i] = static_cast<char>(sum >> (8 * i) & 0xFFU);
  }
  return file;
}

void read_npz(const std::string& bytes) {
  const auto file = io::NpzFile::parse(bytes, "a.npz");
  for (const auto& name : file.names()) (void)file.get(name).as<float>();
}

void read_frame(const std::string& bytes) { (void)io::read_frame(fuzz::folder().write("frame.npz", bytes)); }

std::vector<std::string> frame_seeds() {
  io::Frame frame;
  frame.image = Array<std::uint8_t, 3>(Extents<3>{3, 4, 3});
  std::fill(frame.image.begin(), frame.image.end(), std::uint8_t(7));
  frame.mask = Array<std::uint8_t, 2>(Extents<2>{3, 4});
  std::fill(frame.mask->begin(), frame.mask->end(), std::uint8_t(1));
  frame.label = io::Label{2, {2, 1, 2, 1}};
  frame.pose = geometry::CarlaPose{};
  frame.pose->camera_translation = {-4, 0, 2};
  frame.light = raster::Light{};
  io::write_frame(fuzz::folder().path("frame_seed.npz"), frame);
  return {fuzz::folder().read("frame_seed.npz")};
}

void read_checkpoint(const std::string& bytes) {
  (void)camouflage::read_checkpoint<float>(fuzz::folder().write("checkpoint.npz", bytes));
}

std::vector<std::string> checkpoint_seeds() {
  camouflage::TrainingState<float> state;
  state.step = 2;
  state.parameter = Array<float, 2>(Extents<2>{2, 3});
  std::fill(state.parameter.begin(), state.parameter.end(), 0.5F);
  state.adam.step = 2;
  state.adam.first_moment.assign(6, 0.25F);
  state.adam.second_moment.assign(6, 0.125F);
  state.history.resize(2);
  camouflage::write_checkpoint(fuzz::folder().path("checkpoint_seed.npz"), state, "settings");
  return {fuzz::folder().read("checkpoint_seed.npz")};
}

const fuzz::Registered npy({"npy", read_npy, npy_seeds});
const fuzz::Registered npz({"npz", read_npz, npz_seeds, with_zip_checksums});
const fuzz::Registered frame({"frame", read_frame, frame_seeds, with_zip_checksums});
const fuzz::Registered checkpoint({"checkpoint", read_checkpoint, checkpoint_seeds, with_zip_checksums});
}  // namespace
