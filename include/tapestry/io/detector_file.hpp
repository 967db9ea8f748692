#pragma once
#include <algorithm>
#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tapestry/core/error.hpp>
#include <tapestry/detect/batch_norm_folding.hpp>
#include <tapestry/detect/network_config.hpp>
#include <tapestry/detect/parameter_layout.hpp>
#include <tapestry/detect/weight_file.hpp>
#include <tapestry/io/detector_metadata.hpp>
#include <tapestry/io/npy_header.hpp>
#include <tapestry/io/safetensors_file.hpp>
#include <tapestry/io/text_lines.hpp>
#include <tapestry/io/utf8.hpp>
#include <utility>
#include <vector>

namespace tapestry::io {

/// The tensors of a detector in the order of its layout, named as PyTorch names the like: of layer i of the
/// cfg, counted from 0 without [net],
///
///   layers.i.weight           [filters, channels / groups, size, size]
///   layers.i.bias             [filters], of a layer without batch normalisation
///   layers.i.bn.bias          [filters], β; then bn.weight, γ, bn.running_mean and bn.running_var
[[nodiscard]] inline std::vector<NamedShape> detector_tensors(const detect::NetworkConfig& config,
                                                              const detect::ParameterLayout& layout) {
  using detect::ParameterRole;
  const auto name_of = [](ParameterRole role, bool normalises) {
    if (role == ParameterRole::weight) return "weight";
    if (role == ParameterRole::scale) return "bn.weight";
    if (role == ParameterRole::mean) return "bn.running_mean";
    if (role == ParameterRole::variance) return "bn.running_var";
    return normalises ? "bn.bias" : "bias";
  };
  std::vector<NamedShape> tensors;
  for (const detect::ParameterBlock& block : layout.blocks) {
    const detect::LayerConfig& layer = config.layers[block.layer];
    std::vector<std::size_t> shape{layer.filters};
    if (block.role == ParameterRole::weight)
      shape.insert(shape.end(),
                   {block.count / (layer.filters * layer.size * layer.size), layer.size, layer.size});
    tensors.push_back(
        {"layers." + std::to_string(block.layer) + "." + name_of(block.role, layer.batch_normalize),
         std::move(shape)});
  }
  return tensors;
}

/// Parameters read from a file: a view into it, or, when they had to be converted, into `converted`.
struct DetectorParameters {
  std::vector<float> converted{};
  std::span<const float> values{};
  std::vector<std::string> warnings{};
};

/// A detector in one .safetensors file: its cfg and its parameters, as convert_weights writes them.
class DetectorFile {
 public:
  /// \throws FileError  as SafetensorsFile and parse_detector_metadata() do; for the cfg within as
  ///                    parse_network_config() does, under the name `<path>:cfg`
  explicit DetectorFile(const std::string& path)
      : file_(path),
        metadata_(parse_detector_metadata(file_.metadata(), path)),
        config_(adapted(detect::parse_network_config(metadata_.cfg, path + ":cfg"))) {}

  [[nodiscard]] const DetectorMetadata& metadata() const { return metadata_; }
  [[nodiscard]] const detect::NetworkConfig& config() const { return config_; }

  /// A cfg of its own, with this file's epsilon and without batch normalisation if that has been folded.
  [[nodiscard]] detect::NetworkConfig adapted(detect::NetworkConfig config) const {
    config.batch_norm_epsilon = metadata_.batch_norm_epsilon;
    return metadata_.is_folded ? detect::without_batch_norm(std::move(config)) : config;
  }

  /// All parameters in the order of `layout`: straight from the mapped file, without a copy, when they are
  /// F32 and lie in that order, as convert_weights leaves them. They are valid as long as this object.
  ///
  /// \param config  config(), or another that went through adapted()
  /// \param layout  of config
  /// \throws FileError  mismatch for a tensor that is missing, not asked for, of another shape or of a type
  ///                    that is no floating point, malformed for a value that no trained network can hold;
  ///                    with the tensor's name
  [[nodiscard]] DetectorParameters parameters(const detect::NetworkConfig& config,
                                              const detect::ParameterLayout& layout) const {
    const auto expected = detector_tensors(config, layout);
    const auto tensors = matching(expected, config.name);
    DetectorParameters parameters;
    const bool in_order = std::ranges::equal(tensors, file_.tensors(), {}, &Tensor::name, &Tensor::name);
    const auto view = in_order ? file_.view(file_.tensors()) : std::nullopt;
    if (view) {
      parameters.values = *view;
    } else {
      parameters.converted.resize(layout.count);
      parameters.values = parameters.converted;
      for (std::size_t i = 0; i < tensors.size(); ++i)
        file_.copy(tensors[i],
                   std::span(parameters.converted).subspan(layout.blocks[i].offset, layout.blocks[i].count));
    }
    const auto narrowed = std::ranges::count(tensors, TensorType::f64, &Tensor::type);
    if (narrowed > 0)
      parameters.warnings.push_back(file_.path() + ": " + std::to_string(narrowed) +
                                    " tensors of F64 were rounded to F32");
    for (std::size_t i = 0; i < tensors.size(); ++i)
      check_values(tensors[i], layout.blocks[i],
                   parameters.values.subspan(layout.blocks[i].offset, layout.blocks[i].count));
    file_.require_unchanged_size();
    return parameters;
  }

 private:
  [[noreturn]] void fail(const std::string& what, const std::string& expected = "",
                         const std::string& found = "") const {
    throw FileError(ErrorKind::mismatch, {file_.path(), "", what, expected, found});
  }

  /// The file's tensors in the expected order.
  [[nodiscard]] std::vector<Tensor> matching(const std::vector<NamedShape>& expected,
                                             const std::string& cfg_name) const {
    std::map<std::string_view, const Tensor*> found;
    for (const Tensor& tensor : file_.tensors()) found.emplace(tensor.name, &tensor);
    std::vector<Tensor> matched;
    for (const NamedShape& wanted : expected) {
      const auto entry = found.find(wanted.name);
      if (entry == found.end())
        fail("tensor '" + wanted.name + "' is missing, which " + cfg_name + " needs",
             shape_text(wanted.shape));
      require_fit(*entry->second, wanted, cfg_name);
      matched.push_back(*entry->second);
      found.erase(entry);
    }
    if (!found.empty())
      detail::refuse_tensor(file_.path(), *found.begin()->second,
                            "not a part of the network that " + cfg_name + " describes", "",
                            std::to_string(found.size()) + " such tensors", ErrorKind::mismatch);
    return matched;
  }

  void require_fit(const Tensor& tensor, const NamedShape& wanted, const std::string& cfg_name) const {
    const auto refuse = [&](const std::string& what, const std::string& expected, const std::string& found) {
      detail::refuse_tensor(file_.path(), tensor, what, expected, found, ErrorKind::mismatch);
    };
    if (tensor.shape != wanted.shape)
      refuse(std::ranges::is_permutation(tensor.shape, wanted.shape)
                 ? "axes in another order; weights are [filters, channels, row, column]"
                 : "another shape than " + cfg_name + " needs",
             shape_text(wanted.shape), shape_text(tensor.shape));
    const bool is_floating = tensor.type == TensorType::f32 || tensor.type == TensorType::f64 ||
                             tensor.type == TensorType::f16 || tensor.type == TensorType::bf16;
    if (!is_floating)
      refuse("not floating point", "F32, F64, F16 or BF16", std::string(type_name(tensor.type)));
  }

  void check_values(const Tensor& tensor, const detect::ParameterBlock& block,
                    std::span<const float> values) const {
    for (std::size_t i = 0; i < values.size(); ++i) {
      const bool is_negative_variance = block.role == detect::ParameterRole::variance && values[i] < 0;
      if (detect::detail::is_finite(values[i]) && !is_negative_variance) continue;
      throw FileError(
          ErrorKind::malformed,
          {file_.path(), "@" + std::to_string(file_.position(tensor, i)),
           "element " + std::to_string(i) + " of tensor " + in_quotes(tensor.name),
           is_negative_variance ? "a variance of at least 0" : "a finite float", std::to_string(values[i])});
    }
  }

  SafetensorsFile file_;
  DetectorMetadata metadata_;
  detect::NetworkConfig config_;
};

/// Writes a detector, or leaves the old file as it was. The same arguments give the same bytes; without
/// folding, what lies behind the header are the bytes of the Darknet weights behind theirs.
///
/// \param metadata    whose cfg describes the network; is_folded folds the batch normalisation
/// \param parameters  in the order of the layout of that cfg, not folded
/// \param cfg_name    the cfg's file name, for messages
/// \throws FileError  for the cfg as parse_network_config() does, and malformed unless it is UTF-8; write
/// \throws ShapeError unless there are as many parameters as the cfg needs, NumericError as fold_batch_norm()
inline void write_detector_file(const std::string& path, const DetectorMetadata& metadata,
                                const std::vector<float>& parameters, const std::string& cfg_name) {
  const std::size_t sound = utf8_prefix(metadata.cfg);
  if (sound < metadata.cfg.size())
    throw FileError(ErrorKind::malformed, {cfg_name, "@" + std::to_string(sound),
                                           "not UTF-8, as text within a safetensors file has to be"});
  auto config = detect::parse_network_config(metadata.cfg, cfg_name);
  config.batch_norm_epsilon = metadata.batch_norm_epsilon;
  const auto layout_of = [](const detect::NetworkConfig& c) {
    return detect::parameter_layout(c, detect::infer_shapes(c, c.height, c.width));
  };
  const auto layout = layout_of(config);
  if (parameters.size() != layout.count)
    throw ShapeError("write_detector_file: parameters is [" + std::to_string(parameters.size()) +
                     "], expected [" + std::to_string(layout.count) + "]");
  const auto fields = fields_of(metadata);
  if (!metadata.is_folded) {
    write_safetensors(path, fields, detector_tensors(config, layout), parameters);
    return;
  }
  const auto plain = detect::without_batch_norm(config);
  write_safetensors(path, fields, detector_tensors(plain, layout_of(plain)),
                    detect::fold_batch_norm(config, layout, parameters));
}

}  // namespace tapestry::io
