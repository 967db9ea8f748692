#pragma once
#include <tapestry/core/finite.hpp>
#include <tapestry/io/detail/npy_header.hpp>
#include <tapestry/io/detector_file.hpp>
#include <tapestry/io/text_lines.hpp>

namespace tapestry::io {

std::vector<NamedShape> detector_tensors(const detect::NetworkConfig& config,
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

}  // namespace tapestry::io

namespace tapestry::io::detail {

detect::ParameterLayout layout_of(const detect::NetworkConfig& config, std::size_t input_height,
                                  std::size_t input_width) {
  return detect::parameter_layout(
      config, detect::infer_shapes(config, input_height == 0 ? config.height : input_height,
                                   input_width == 0 ? config.width : input_width));
}

}  // namespace tapestry::io::detail

namespace tapestry::io {

detect::NetworkConfig DetectorFile::adapted(detect::NetworkConfig config) const {
  config = detect::with_decode(std::move(config), metadata_.decode);
  config.batch_norm_epsilon = metadata_.batch_norm_epsilon;
  return metadata_.is_folded ? detect::without_batch_norm(std::move(config)) : config;
}

std::vector<std::string> DetectorFile::warnings() const {
  const auto narrowed = std::ranges::count(file_.tensors(), TensorType::f64, &Tensor::type);
  if (narrowed == 0) return {};
  return {file_.path() + ": " + std::to_string(narrowed) + " tensors of F64 were rounded to F32"};
}

std::vector<Tensor> DetectorFile::matching(const std::vector<NamedShape>& expected,
                                           const std::string& cfg_name) const {
  std::map<std::string_view, const Tensor*> found;
  for (const Tensor& tensor : file_.tensors()) found.emplace(tensor.name, &tensor);
  std::vector<Tensor> matched;
  for (const NamedShape& wanted : expected) {
    const auto entry = found.find(wanted.name);
    if (entry == found.end())
      fail("tensor '" + wanted.name + "' is missing, which " + cfg_name + " needs", shape_text(wanted.shape));
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

void DetectorFile::require_fit(const Tensor& tensor, const NamedShape& wanted,
                               const std::string& cfg_name) const {
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

void DetectorFile::check_values(const Tensor& tensor, detect::ParameterRole role,
                                std::span<const float> values, std::size_t first) const {
  const bool is_variance = role == detect::ParameterRole::variance;
  if (!is_variance && are_finite(values)) return;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const bool is_negative_variance = is_variance && values[i] < 0;
    if (is_finite(values[i]) && !is_negative_variance) continue;
    throw FileError(
        ErrorKind::malformed,
        {file_.path(), "@" + std::to_string(file_.position(tensor, first + i)),
         "element " + std::to_string(first + i) + " of tensor " + in_quotes(tensor.name),
         is_negative_variance ? "a variance of at least 0" : "a finite float", std::to_string(values[i])});
  }
}

std::size_t write_detector_file(const std::string& path, const DetectorMetadata& metadata,
                                const Array<float, 1>& parameters, const std::string& cfg_name) {
  const std::size_t sound = utf8_prefix(metadata.cfg);
  if (sound < metadata.cfg.size())
    throw FileError(ErrorKind::malformed, {cfg_name, "@" + std::to_string(sound),
                                           "not UTF-8, as text within a safetensors file has to be"});
  auto config = detect::with_decode(parse_network_config(metadata.cfg, cfg_name), metadata.decode);
  config.batch_norm_epsilon = metadata.batch_norm_epsilon;
  const auto layout = detail::layout_of(config);
  if (parameters.size() != layout.count)
    throw ShapeError(
        {"write_detector_file: parameters is [", parameters.size(), "], expected [", layout.count, "]"});
  const auto fields = fields_of(metadata);
  if (!metadata.is_folded) {
    const auto tensors = detector_tensors(config, layout);
    write_safetensors(path, fields, tensors, {parameters.data(), parameters.size()});
    return tensors.size();
  }
  const auto plain = detect::without_batch_norm(config);
  const auto tensors = detector_tensors(plain, detail::layout_of(plain));
  const Array<float, 1> folded = detect::fold_batch_norm(config, layout, parameters);
  write_safetensors(path, fields, tensors, {folded.data(), folded.size()});
  return tensors.size();
}

}  // namespace tapestry::io
