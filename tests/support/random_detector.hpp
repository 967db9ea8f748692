#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <tapestry/core/random.hpp>
#include <tapestry/detect/network.hpp>
#include <utility>

namespace tapestry::test {
/// A detector with every layer that Darknet and OpenCV both understand, at an odd number of cells.
inline const std::string common_layers = R"([net]
width=104
height=104
channels=3
[convolutional]
batch_normalize=1
filters=16
size=3
stride=1
pad=1
activation=leaky
[maxpool]
size=2
stride=2
[convolutional]
batch_normalize=1
filters=24
size=3
stride=2
pad=1
activation=leaky
[convolutional]
batch_normalize=1
filters=12
size=1
stride=1
pad=1
activation=leaky
[convolutional]
batch_normalize=1
filters=24
size=3
stride=1
pad=1
activation=leaky
[shortcut]
from=-3
activation=linear
[convolutional]
batch_normalize=1
filters=48
size=3
stride=2
pad=1
activation=leaky
[maxpool]
size=2
stride=1
[maxpool]
size=5
stride=1
[route]
layers=-1,-3
[convolutional]
filters=21
size=1
stride=1
pad=1
activation=linear
[yolo]
mask=3,4,5
anchors=10,14, 23,27, 37,58, 81,82, 135,169, 344,319
classes=2
num=6
[route]
layers=-4
[upsample]
stride=2
[route]
layers=-1,5
[convolutional]
filters=21
size=3
stride=1
pad=1
activation=linear
[yolo]
mask=0,1,2
anchors=10,14, 23,27, 37,58, 81,82, 135,169, 344,319
classes=2
num=6
)";

/// The layers of `common_layers` and what only Darknet's relatives know: depthwise and grouped
/// convolutions, dropout, and further activations.
inline const std::string relatives_layers = R"([net]
width=64
height=64
channels=3
[convolutional]
batch_normalize=1
filters=16
size=3
stride=2
pad=1
activation=mish
[convolutional]
batch_normalize=1
filters=16
groups=16
size=5
stride=1
pad=1
activation=relu
[convolutional]
batch_normalize=1
filters=24
groups=4
size=3
stride=2
pad=1
activation=swish
[dropout]
probability=.15
[convolutional]
filters=24
size=1
stride=1
activation=logistic
[shortcut]
from=-3
activation=linear
[route]
layers=-1
groups=2
group_id=1
[convolutional]
filters=21
size=1
stride=1
pad=1
activation=linear
[yolo]
mask=0,1,2
anchors=10,14, 23,27, 37,58
classes=2
num=3
)";

/// Shortcuts of a layer of fewer channels and of one of more.
inline const std::string unequal_layers = R"([net]
width=32
height=32
channels=3
[convolutional]
filters=16
size=3
stride=2
pad=1
activation=leaky
[convolutional]
filters=24
size=1
stride=1
pad=1
activation=leaky
[shortcut]
from=-2
activation=linear
[convolutional]
filters=12
size=3
stride=1
pad=1
activation=leaky
[shortcut]
from=-2
activation=linear
[maxpool]
size=2
stride=2
[upsample]
stride=2
[convolutional]
filters=21
size=1
stride=1
pad=1
activation=linear
[yolo]
mask=0,1,2
anchors=10,14, 23,27, 37,58
classes=2
num=3
)";

/// The network of a cfg with random weights, shifts, scales and running statistics.
template <class T>
detect::Network<T> random_detector(detect::NetworkConfig config, std::uint64_t seed, std::size_t size = 0) {
  detect::Network<T> network(std::move(config), size, size);
  Random random(seed);
  network.initialise(random);
  auto& parameters = network.parameters();
  for (const auto& block : network.layout().blocks) {
    if (block.role == detect::ParameterRole::weight) continue;
    const bool is_positive =
        block.role == detect::ParameterRole::scale || block.role == detect::ParameterRole::variance;
    for (std::size_t i = 0; i < block.count; ++i)
      parameters[block.offset + i] =
          static_cast<T>(random.uniform(is_positive ? 0.5 : -0.3, is_positive ? 1.5 : 0.3));
  }
  return network;
}
}  // namespace tapestry::test
