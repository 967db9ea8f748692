#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/io/onnx/protobuf_message.hpp>

namespace tapestry::io {

/// How much an ONNX model may hold.
struct OnnxLimits {
  std::uint64_t file_bytes = std::uint64_t(1) << 31U;      ///< what protobuf itself allows
  std::uint64_t external_bytes = std::uint64_t(1) << 32U;  ///< of the tensors that lie in files beside it
  std::size_t records = std::size_t(1) << 22U;  ///< nodes, their values' names, attributes, tensors
};

/// Counts what takes more memory than the bytes that it comes from, up to a limit.
class OnnxRecords {
 public:
  explicit OnnxRecords(std::size_t most) : most_(most) {}

  /// One more. \throws FileError (limit)
  void count(const ProtobufMessage& message) {
    if (count_ == most_)
      message.fail("too many nodes, names, attributes and tensors", "at most " + std::to_string(most_),
                   "more", ErrorKind::limit);
    ++count_;
  }

 private:
  std::size_t most_;
  std::size_t count_ = 0;
};

}  // namespace tapestry::io
