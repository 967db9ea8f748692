#pragma once
/// \file
/// All of loss/ that programs name: terms of the objective.
#include <tapestry/loss/adversarial.hpp>
#include <tapestry/loss/attention.hpp>
#include <tapestry/loss/cross_entropy.hpp>
#include <tapestry/loss/mesh_regularity.hpp>
#include <tapestry/loss/prediction.hpp>
#include <tapestry/loss/printability.hpp>
#include <tapestry/loss/smoothness.hpp>
#include <tapestry/loss/yolo_training.hpp>
#include <tapestry/loss/yolox_training.hpp>
