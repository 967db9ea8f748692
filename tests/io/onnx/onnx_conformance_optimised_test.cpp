// Runs ONNX's own test vectors, as Debian's package libonnx-testdata installs them: a model, and for each set
// of inputs the results of a reference implementation.
#include <tapestry/io/onnx/onnx_file.hpp>
#include <tapestry/nn/detail/network/decomposition.hpp>
#include <tapestry/nn/network/staged_network.hpp>

#include <fstream>
#include <iostream>
#include <iterator>

#include "../../support/catch.hpp"

namespace files = std::filesystem;
using namespace tapestry;

namespace {
/// Vectors of supported operators that are not run: part of the name, part of the
/// network's error, and the reason.
struct Exception {
  std::string name, complaint, reason;
};
const std::vector<Exception> exceptions = {
    {"dynamicquantizelinear", "result 0 of 8 bytes", "a tie in single precision"},
    {"convtranspose_3d", "three axes are not supported", "three axes of space"},
    {"BatchNorm", "only pictures", "not a picture"},
    {"multiparam", "do not go together", "a form of opset 6 alone"},
    {"training_mode", "only the form for inference", "training in the file"},
    {"training_dropout", "training_mode is true", "training in the file"},
    {"_to_BFLOAT16", "expected 16117", "numbers are not rounded to BFLOAT16"},
    {"_to_INT4", "element type 22", "integers of four bits"},
    {"_to_UINT4", "element type 21", "integers of four bits"},
    {"antialias", "'antialias' is not supported", "Resize that filters before it shrinks"},
    // The reference divides by the new extent before that is rounded to a whole number, as no other mode
    // does.
    {"resize_downsample_scales_cubic_align_corners", "is 2.5", "the reference divides by a part of a pixel"},
    {"resize_downsample_scales_linear_align_corners", "is 4.0", "the reference divides by a part of a pixel"},
};

struct TestSet {
  std::vector<nn::Constant> inputs, outputs;
};

struct Tally {
  std::size_t passed = 0, passed_as_newer = 0, passed_first_result = 0;
  std::map<std::string, std::vector<std::string>> refusals{};  ///< names by reason
  std::vector<std::string> failures{};
};

std::string folder_of_vectors() {
  const char* const named = std::getenv("TAPESTRY_ONNX_TESTDATA");
  return named != nullptr ? named : "/usr/share/libonnx-testdata/data";
}

TestSet read_set(const files::path& folder) {
  TestSet set;
  for (const bool is_input : {true, false})
    for (int i = 0;; ++i) {
      const auto path = folder / ((is_input ? "input_" : "output_") + std::to_string(i) + ".pb");
      if (!files::exists(path)) break;
      (is_input ? set.inputs : set.outputs).push_back(io::read_onnx_tensor(path.string()));
    }
  return set;
}

/// BFLOAT16 as these vectors keep it, in the bits of UINT16.
void read_bfloat16(nn::Constant& constant) {
  constant.type = nn::ElementType::floating;
  for (double& value : std::get<std::vector<double>>(constant.values))
    value = static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(value) << 16U));
}

/// A model, of opset 1 or 6 as one of opset 7: where these differ, the attributes do not exist in the newer
/// one, and are refused by name.
nn::NetworkDescription read_model(const files::path& path, bool& is_as_newer) {
  std::ifstream file(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(file), {}};
  for (const char version : {'\1', '\6'})
    for (const std::string& import : {std::string("B\2\20"), std::string("B\4\12\0\20", 5)})
      if (bytes.ends_with(import + version)) {
        bytes.back() = '\7';
        is_as_newer = true;
      }
  return io::parse_onnx(bytes, path.filename().string());
}

/// The tolerances of ONNX's own runner. Source: ONNX, onnx/backend/test/case/test_case.py.
bool is_close(double found, double expected) {
  if (std::isnan(expected)) return std::isnan(found);
  return found == expected || std::abs(found - expected) <= 1e-7 + 1e-3 * std::abs(expected);
}

/// Compares a network's results for the first inputs of a set; returns the error, or empty text.
template <class T>
std::string run(const nn::NetworkDescription& description, const TestSet& set) {
  std::map<std::string, nn::Shape> shapes;
  std::vector<nn::Buffer<T>> buffers;
  std::vector<const T*> inputs;
  for (std::size_t k = 0; k < description.inputs.size(); ++k) {
    const nn::Constant& constant = set.inputs.at(k);
    shapes[description.inputs[k].name] = constant.shape;
    buffers.emplace_back(constant.size());
    for (std::size_t i = 0; i < constant.size(); ++i)
      buffers.back().data()[i] = static_cast<T>(constant.at(i));
    inputs.push_back(buffers.back().data());
  }
  const nn::StagedNetwork<T> network(description, shapes);
  nn::StagedPass<T> pass;
  network.forward(inputs, pass);
  for (std::size_t o = 0; o < pass.output_count(); ++o) {
    const nn::Constant& expected = set.outputs.at(o);
    const std::string result = "result " + std::to_string(o) + " of " + std::to_string(sizeof(T)) + " bytes ";
    if (pass.output_shape(o) != expected.shape)
      return result + "is " + detail::to_text(pass.output_shape(o)) + ", expected " +
             detail::to_text(expected.shape);
    for (std::size_t i = 0; i < expected.size(); ++i)
      if (!is_close(static_cast<double>(pass.output(o)[i]), expected.at(i)))
        return result + "at " + std::to_string(i) + " is " + std::to_string(pass.output(o)[i]) +
               ", expected " + std::to_string(expected.at(i));
  }
  return "";
}

/// The model with the inputs from `first` on as constants, as in most models in use.
nn::NetworkDescription bound(nn::NetworkDescription description, const TestSet& set, std::size_t first) {
  for (std::size_t i = first; i < description.inputs.size(); ++i)
    description.constants[description.inputs[i].name] = set.inputs.at(i);
  description.inputs.resize(std::min(first, description.inputs.size()));
  return description;
}

/// Runs a set with all inputs given, with the first one alone and with none: each way that can be built must
/// give the expected results, and one must be possible.
/// \returns the fault, or empty
std::string judge(const nn::NetworkDescription& description, const TestSet& set) {
  std::string refusal;
  bool has_run = false;
  for (const std::size_t count : {description.inputs.size(), std::size_t(1), std::size_t(0)}) {
    if (count > description.inputs.size()) continue;
    const auto described = bound(description, set, count);
    try {
      std::string complaint = run<float>(described, set);
      if (complaint.empty()) complaint = run<double>(described, set);
      if (!complaint.empty()) return std::to_string(count) + " inputs given: " + complaint;
      has_run = true;
    } catch (const Error& error) {
      refusal = error.what();
    }
  }
  return has_run ? "" : refusal;
}

/// Leaves out all results but the first, if there is one node with several.
bool drop_later_results(nn::NetworkDescription& description) {
  if (description.nodes.size() != 1 || description.outputs.size() < 2) return false;
  description.outputs.resize(1);
  description.nodes[0].outputs.resize(1);
  return true;
}

std::string unsupported_operator(const nn::NetworkDescription& description) {
  for (const nn::Node& node : description.nodes)
    if (!nn::operators<double>().contains(node.operation) && !nn::decompositions().contains(node.operation) &&
        node.operation != "Shape" && node.operation != "Size")
      return node.operation;
  return "";
}

/// The reason why a file is refused, without its names and places.
std::string reason_of(const FileError& error) {
  const auto& [path, position, what, expected, found] = error.details();
  const auto mark = what.rfind(": ");
  return what.substr(mark == std::string::npos ? 0 : mark + 2) + (found.empty() ? "" : ", found " + found);
}

std::vector<TestSet> read_sets(const files::path& folder, const nn::NetworkDescription& description) {
  std::vector<TestSet> sets;
  for (;;) {
    const auto data = folder / ("test_data_set_" + std::to_string(sets.size()));
    if (!files::exists(data)) return sets;
    sets.push_back(read_set(data));
    for (std::size_t i = 0; i < description.inputs.size(); ++i)
      if (sets.back().inputs.at(i).type == nn::ElementType::integer &&
          description.inputs[i].type == nn::ElementType::floating)
        read_bfloat16(sets.back().inputs[i]);
  }
}

void judge(const files::path& folder, const std::string& name, Tally& tally) {
  const auto refuse = [&](const std::string& reason) { tally.refusals[reason].push_back(name); };
  nn::NetworkDescription description;
  std::vector<TestSet> sets;
  bool is_as_newer = false, has_first_alone = false;
  try {
    description = read_model(folder / "model.onnx", is_as_newer);
    sets = read_sets(folder, description);
  } catch (const FileError& error) {
    return refuse(reason_of(error));
  }
  if (const auto unsupported = unsupported_operator(description); !unsupported.empty())
    return refuse("operator " + unsupported);
  std::string complaint = sets.empty() ? "no test data" : "";
  for (const TestSet& set : sets) {
    if (complaint.empty()) complaint = judge(description, set);
    if (complaint.ends_with("result 1 is not supported") && drop_later_results(description)) {
      has_first_alone = true;
      complaint = judge(description, set);
    }
  }
  if (complaint.empty()) {
    ++(is_as_newer ? tally.passed_as_newer : has_first_alone ? tally.passed_first_result : tally.passed);
    return;
  }
  for (const Exception& exception : exceptions)
    if (name.find(exception.name) != std::string::npos &&
        complaint.find(exception.complaint) != std::string::npos)
      return refuse(exception.reason);
  if (is_as_newer && complaint.find("): attribute '") != std::string::npos)
    return refuse("a form of opset 6 alone");
  tally.failures.push_back(name + ": " + complaint);
}
}  // namespace

TEST_CASE("ONNX's own test vectors pass", "[io][onnx][conformance]") {
  const files::path root = folder_of_vectors();
  if (!files::exists(root)) {
    WARN("no ONNX test vectors at " << root.string()
                                    << "; install libonnx-testdata or set TAPESTRY_ONNX_TESTDATA");
    return;
  }
  Tally tally;
  for (const char* part : {"node", "pytorch-operator", "pytorch-converted", "simple"}) {
    std::vector<files::path> folders;
    for (const auto& entry : files::directory_iterator(root / part)) folders.push_back(entry.path());
    std::ranges::sort(folders);
    for (const auto& folder : folders) judge(folder, part + ("/" + folder.filename().string()), tally);
  }
  std::cout << tally.passed << " passed, " << tally.passed_as_newer
            << " of opset 1 or 6 passed as of opset 7, " << tally.passed_first_result
            << " passed for their first result alone; refused:\n";
  for (const auto& [reason, names] : tally.refusals) {
    std::cout << "  " << names.size() << " " << reason << ":";
    for (const std::string& name : names) std::cout << " " << name.substr(name.find("test_") + 5);
    std::cout << "\n";
  }
  for (const std::string& failure : tally.failures) FAIL_CHECK(failure);
  CHECK(tally.passed >= 790);  // of the 1072 of version 1.12
}
