#pragma once
#include <tapestry/io/darknet/model_file.hpp>
#include <tapestry/io/detector_file.hpp>
#include <tapestry/io/json.hpp>

namespace tapestry::shell {
/// The entry of a block of parameters in the JSON of an old file, and its name.
inline std::pair<std::string, nlohmann::json> old_entry(const detect::NetworkConfig& config,
                                                        const detect::ParameterBlock& block) {
  constexpr const char* words[] = {"bn.bias", "bn.weight", "bn.running_mean", "bn.running_var", "weight"};
  const bool is_plain_bias =
      block.role == detect::ParameterRole::bias && !config.layers[block.layer].batch_normalize;
  return {"layers." + std::to_string(block.layer) + "." +
              (is_plain_bias ? "bias" : words[static_cast<std::size_t>(block.role)]),
          {{"dtype", "F32"},
           {"shape", detect::constant_shape(config, block)},
           {"data_offsets", {4 * block.offset, 4 * (block.offset + block.count)}}}};
}

/// The JSON text of an old file, behind the eight bytes of its length.
/// \throws FileError (malformed) for a text beyond the file or 16 MiB
inline std::string old_header(const io::RegularFile& file) {
  static_assert(std::endian::native == std::endian::little);
  std::uint64_t length = 0;
  const std::uint64_t most =
      std::min(file.size(), 8 + (std::uint64_t(16) << 20U)) - std::min<std::uint64_t>(file.size(), 8);
  if (file.size() >= 8) file.read_at(0, std::as_writable_bytes(std::span(&length, 1)));
  if (length == 0 || length > most)
    throw malformed_file({file.path(), "@0", "header passes the end of the file, or 16 MiB",
                          "1 to " + std::to_string(most) + " bytes", std::to_string(length) + " bytes"});
  std::string text(static_cast<std::size_t>(length), '\0');
  file.read_at(8, std::as_writable_bytes(std::span<char>(text)));
  return text;
}

/// Checks that an old file has the tensors of a layout, one after another up to its end.
/// \throws FileError (mismatch)
inline void require_old_tensors(const io::RegularFile& file, std::uint64_t begin, const io::JsonText& header,
                                const detect::NetworkConfig& config, const detect::ParameterLayout& layout) {
  const auto fail = [&](const std::string& place, const std::string& what, const std::string& expected,
                        const std::string& found) {
    throw file_mismatch({file.path(), place, what, expected, found});
  };
  for (const detect::ParameterBlock& block : layout.blocks) {
    const auto [name, entry] = old_entry(config, block);
    const auto found = header.value.find(name);
    if (found == header.value.end() || *found != entry)
      fail(found == header.value.end() ? "" : header.positions.at(name),
           "tensor " + in_quotes(name) + " is not that of " + config.name, entry.dump(),
           found == header.value.end() ? "none" : printable(found->dump().substr(0, 200)));
  }
  if (header.value.size() != layout.blocks.size() + 1)
    fail("", "tensors of no layer", std::to_string(layout.blocks.size()),
         std::to_string(header.value.size() - 1));
  if (file.size() - begin != 4 * std::uint64_t(layout.count))
    fail("", "another size than that of its tensors", std::to_string(begin + 4 * layout.count) + " bytes",
         std::to_string(file.size()) + " bytes");
}

struct ModelWithCfg {
  detect::DarknetModel<float> model;
  std::string cfg;
};

/// Reads a detector as releases before 0.3 wrote it, in one .safetensors file: the length of a JSON text; the
/// text, with the metadata and the place of each tensor; the parameters in the order of Darknet's weights, as
/// F32. Tensors of other types or in another order are refused.
/// \throws FileError  as RegularFile, old_header(), read_json(), parse_detector_metadata(),
///                  parse_network_config() and require_old_tensors() do; malformed for weights
///                  that are not finite
inline ModelWithCfg read_old_detector(const std::string& path) {
  const io::RegularFile file(path);
  const std::string text = old_header(file);
  const std::uint64_t begin = 8 + text.size();
  const io::JsonText header = io::read_json(text, path, 8, 3);
  const auto is_text = [](const nlohmann::json& value) { return value.is_string(); };
  const auto fields =
      header.value.is_object() ? header.value.value("__metadata__", nlohmann::json()) : nlohmann::json();
  if (!fields.is_object() || !std::ranges::all_of(fields, is_text))
    throw malformed_file(
        {path, "@8", "not the header of a detector", "__metadata__, an object of strings", ""});
  auto metadata = io::parse_detector_metadata(fields.get<std::map<std::string, std::string>>(), path);
  detect::DarknetModel<float> model(
      io::adapted(io::parse_network_config(metadata.cfg, path + ":cfg"), metadata));
  model.set_images_seen(metadata.images_seen);
  require_old_tensors(file, begin, header, model.config(), model.layout());
  const std::span<float> values(model.parameters().data(), model.layout().count);
  file.read_at(begin, std::as_writable_bytes(values));
  file.require_unchanged();
  if (!are_finite(std::span<const float>(values)))
    throw malformed_file({path, "", "weights that are not finite"});
  return {std::move(model), std::move(metadata.cfg)};
}
}  // namespace tapestry::shell
