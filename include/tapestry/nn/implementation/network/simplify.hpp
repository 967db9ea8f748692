#pragma once
#include <tapestry/nn/network/description.hpp>
#include <tapestry/nn/network/simplify.hpp>
#include <tapestry/nn/network/simplify/editable_graph.hpp>
#include <tapestry/nn/network/simplify/fold_scaling.hpp>
#include <tapestry/nn/network/simplify/fuse_convolution.hpp>
#include <tapestry/nn/network/simplify/merge_patterns.hpp>
#include <tapestry/nn/network/simplify/merge_views.hpp>
#include <utility>

namespace tapestry::nn {

NetworkDescription simplified(NetworkDescription description, const NetworkFacts& facts, bool in_float) {
  EditableGraph graph(std::move(description), facts, in_float);
  remove_copies(graph);
  merge_patterns(graph);
  merge_views(graph);
  fold_scalings(graph);
  fuse_convolutions(graph);
  return std::move(graph).finish();
}

}  // namespace tapestry::nn
