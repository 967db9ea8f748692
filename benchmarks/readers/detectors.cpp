// Darknet's networks, names of classes and ONNX.
#include <tapestry/io/darknet/model_file.hpp>
#include <tapestry/io/onnx/onnx_file.hpp>
#include <tapestry/io/text_lists.hpp>

#include "../../tests/support/onnx_builder.hpp"
#include "../../tests/support/temporary_folder.hpp"
#include "kind.hpp"

namespace tapestry::benchmarks {
namespace {
const std::string head =
    "[convolutional]\nfilters=18\nsize=1\nstride=1\npad=1\nactivation=linear\n"
    "[yolo]\nmask=0,1,2\nanchors=4,4, 8,8, 9,9\nclasses=1\nnum=3\n";
const std::string net = "[net]\nwidth=32\nheight=32\nchannels=3\n";

void read_cfg(const std::string& path) { (void)io::read_network_config(path); }

std::string full_layers(std::size_t bytes) {
  std::string layer = "[maxpool]\nsize=1\nstride=1\n";
  for (std::size_t i = 0; layer.size() < bytes / 2000; ++i)
    layer += std::string("k") + std::to_string(i) + "=1\n";
  return filled(net, layer, head)(bytes);
}

/// Names of two bytes, then of three: as many as a file can have.
std::string short_name(std::size_t i) {
  constexpr std::size_t digits = 223, first = 33;  // all bytes from 33 on
  std::string name;
  for (std::size_t left = i; name.size() < (i < digits * digits ? 2U : 3U); left /= digits)
    name += static_cast<char>(static_cast<unsigned char>(first + left % digits));
  return name + "\n";
}
void read_names(const std::string& path) { (void)io::read_class_names(path); }

/// A layer of 512 channels with as many filters as the weights have room for.
detect::NetworkConfig wide_network(std::size_t weight_count) {
  const auto layer = [](std::size_t filters) {
    return std::string("[convolutional]\nfilters=") + std::to_string(filters) +
           "\nsize=1\nstride=1\nactivation=linear\n";
  };
  return io::parse_classifier_config(
      net + layer(512) + layer(weight_count / 513 - 4) + "[avgpool]\n[softmax]\n", "a.cfg");
}
detect::ParameterLayout layout_of(const detect::NetworkConfig& config) {
  return detect::parameter_layout(config, detect::infer_shapes(config, config.height, config.width));
}
/// Denormal, which are slow to calculate with.
std::string weights(std::size_t bytes) {
  const test::TemporaryFolder folder;
  Array<float, 1> values(Extents<1>{layout_of(wide_network(bytes / 4)).count});
  std::fill(values.begin(), values.end(), 1e-40F);
  io::write_weight_file(folder.path("a.weights"), 1, values);
  return folder.read("a.weights");
}
void read_weights(const std::string& path) {
  const auto config = wide_network(std::filesystem::file_size(path) / 4 + 100);
  (void)io::read_weight_file(path, config, layout_of(config));
}

namespace onnx = test::onnx;
/// A model with these nodes, of which the last makes the output "z".
std::string model(std::vector<std::string> nodes, std::vector<std::string> initialisers = {}) {
  onnx::ModelParts parts;
  parts.inputs = {onnx::value("0", onnx::float32, {onnx::Extent(1)})};
  parts.outputs = {onnx::value("z", onnx::float32, {})};
  parts.nodes = std::move(nodes);
  parts.nodes.push_back(onnx::node("Relu", {"0"}, {"z"}));
  parts.initialisers = std::move(initialisers);
  return onnx::model(parts);
}
/// Entries until they have that many bytes, each with three more for its place in the file.
template <class Entry>
std::vector<std::string> entries(std::size_t bytes, Entry entry) {
  std::vector<std::string> list;
  for (std::size_t i = 0, size = 0; size < bytes; size += list.back().size() + 3) list.push_back(entry(i++));
  return list;
}
std::string chain(std::size_t bytes) {
  return model(entries(
      bytes, [](std::size_t i) { return onnx::node("R", {std::to_string(i)}, {std::to_string(i + 1)}); }));
}
std::string many_inputs(std::size_t bytes) {
  return model({onnx::node("R", entries(bytes, [](std::size_t) { return std::string("0"); }), {"y"})});
}
std::string many_attributes(std::size_t bytes) {
  return model({onnx::node("R", {"0"}, {"y"}, entries(bytes, [](std::size_t i) {
                             return onnx::int_attribute(std::to_string(i), 1);
                           }))});
}
std::string many_numbers(std::size_t bytes) {
  const std::vector<std::int64_t> ones(bytes, 1);
  return model({onnx::node("R", {"0"}, {"y"}, {onnx::ints_attribute("a", ones, onnx::Packing::packed)})});
}
std::string many_initialisers(std::size_t bytes) {
  return model({}, entries(bytes, [](std::size_t i) {
                 return onnx::float_tensor(std::string("i") + std::to_string(i), {0}, {});
               }));
}
void read_onnx(const std::string& path) { (void)io::read_onnx(path); }
}  // namespace

std::vector<Kind> detector_kinds() {
  const std::string wide(65000, 'w');
  return {{"cfg: distinct options", filled(net, numbered("k", "=1\n"), head), read_cfg, times_file(24), 4},
          {"cfg: long options", filled(net, numbered("", wide + "=1\n"), head), read_cfg, times_file(24), 4},
          {"cfg: repeated options", filled(net, "burn_in=1\n", head), read_cfg, times_file(24), 4},
          {"cfg: options of layers", full_layers, read_cfg, times_file(24), 4},
          {"names", filled("", numbered("", "\n")), read_names, times_file(32), 4},
          {"names: short", filled("", short_name), read_names, times_file(32), 4},
          {"weights: denormal", weights, read_weights, times_file(2)},
          {"onnx: nodes", chain, read_onnx, times_file(56)},
          {"onnx: inputs", many_inputs, read_onnx, times_file(56)},
          {"onnx: attributes", many_attributes, read_onnx, times_file(56)},
          {"onnx: numbers", many_numbers, read_onnx, times_file(56)},
          {"onnx: initialisers", many_initialisers, read_onnx, times_file(56)}};
}
}  // namespace tapestry::benchmarks
