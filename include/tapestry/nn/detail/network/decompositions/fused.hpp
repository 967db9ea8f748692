#pragma once
#include <tapestry/nn/detail/network/decomposition.hpp>
#include <tapestry/nn/detail/network/operators/softmax.hpp>

namespace tapestry::nn::detail {
/// x · σ(alpha · x), as ONNX Runtime's optimiser writes SiLU.
inline void decompose_quick_gelu(OperatorContext& context, Decomposer& parts) {
  const double alpha = context.number("alpha", 1.702);
  const std::string& x = parts.input(0);
  const std::string inner = alpha == 1 ? x : parts.add("Mul", {x, parts.number(alpha)});
  parts.finish(0, "Mul", {x, parts.add("Sigmoid", {inner})});
}

/// x / √(mean of x² + epsilon) · scale over the axes from `axis` on. Source: onnx.ai, RMSNormalization.
inline void decompose_rms_normalization(OperatorContext& context, Decomposer& parts) {
  const std::size_t rank = context.input(0).shape.size();
  std::vector<std::int64_t> axes(rank - context.axis(context.integer("axis", -1), rank));
  std::iota(axes.begin(), axes.end(), static_cast<std::int64_t>(rank - axes.size()));
  const double epsilon = context.number("epsilon", 1e-5);
  context.ignore("stash_type");
  const std::string& x = parts.input(0);
  const std::string mean = parts.reduced("ReduceMean", parts.add("Mul", {x, x}), axes);
  const std::string root = parts.add("Sqrt", {parts.add("Add", {mean, parts.number(epsilon)})});
  parts.finish(0, "Mul", {parts.add("Div", {x, root}), parts.input(1)});
}

/// softmax(Q·Kᵀ·scale + mask)·V of heads, [batch, heads, length, width], or [batch, length, heads · width]; 0
/// for a query whose keys are all masked. Source: onnx.ai, Attention of opset 23, with its errata (PR 8068).
class AttentionParts {
 public:
  AttentionParts(OperatorContext& context, Decomposer& parts) : context_(context), parts_(parts) {
    for (const std::size_t past : {4U, 5U})
      if (context.has_input(past)) throw DomainError({"past keys, input ", past, ", are not supported"});
    if (context.number("softcap", 0) != 0) throw DomainError("attribute 'softcap' is not supported");
    context.ignore("qk_matmul_output_mode");  // its result is refused if it is read
    context.ignore("softmax_precision");
    const Shape &q = context.input(0).shape, &k = context.input(1).shape;
    if (q.size() != k.size() || (q.size() != 3 && q.size() != 4) || context.input(2).shape.size() != q.size())
      throw ShapeError({"queries ", q, ", keys ", k, " and values ", context.input(2).shape,
                        ", expected three or four axes each"});
    is_flat_ = q.size() == 3;
    heads_ = heads_of("q_num_heads", q);
    key_heads_ = heads_of("kv_num_heads", k);
    if (heads_ % key_heads_ != 0)
      throw ShapeError({heads_, " heads of queries for ", key_heads_, " of keys"});
    length_ = q[is_flat_ ? 1 : 2];
    keys_ = k[is_flat_ ? 1 : 2];
    const std::size_t width = is_flat_ ? q[2] / heads_ : q[3];
    scale_ = context.number("scale", 1 / std::sqrt(static_cast<double>(width)));
    is_causal_ = context.flag("is_causal", 0);
  }

  void write() {
    const std::string shares =
        parts_.add("Softmax", {masked_scores()}, {{"axis", std::int64_t{-1}}, {masks_rows, std::int64_t{1}}});
    if (!is_flat_) return parts_.finish(0, "MatMul", {shares, repeated(2)});
    const std::string apart = parts_.transposed(parts_.add("MatMul", {shares, repeated(2)}), {0, 2, 1, 3});
    const std::size_t width = context_.input(2).shape[2] / key_heads_;
    const Shape flat{context_.input(0).shape[0], length_, heads_ * width};
    parts_.finish(0, "Reshape", {apart, parts_.integers({flat.begin(), flat.end()})});
  }

 private:
  [[nodiscard]] std::size_t heads_of(const char* name, const Shape& shape) {
    const std::int64_t stated = context_.integer(name, is_flat_ ? 0 : static_cast<std::int64_t>(shape[1]));
    const bool fits = stated > 0 && (is_flat_ ? shape[2] % static_cast<std::size_t>(stated) == 0
                                              : shape[1] == static_cast<std::size_t>(stated));
    if (!fits) throw DomainError({"attribute ", in_quotes(name), " is ", stated});
    return static_cast<std::size_t>(stated);
  }

  /// Queries, keys or values as [batch, heads, length, width].
  [[nodiscard]] std::string split(std::size_t i, std::size_t heads) {
    const Shape& shape = context_.input(i).shape;
    if (!is_flat_) return parts_.input(i);
    return parts_.transposed(parts_.reshaped(parts_.input(i), {shape[0], shape[1], heads, shape[2] / heads}),
                             {0, 2, 1, 3});
  }
  /// Keys or values for each head of the queries.
  [[nodiscard]] std::string repeated(std::size_t i) {
    const std::string own = split(i, key_heads_);
    if (key_heads_ == heads_) return own;
    std::vector<std::int64_t> places;
    for (std::size_t h = 0; h < heads_; ++h)
      places.push_back(static_cast<std::int64_t>(h / (heads_ / key_heads_)));
    return parts_.add("Gather", {own, parts_.integers(places)}, {{"axis", std::int64_t{1}}});
  }

  [[nodiscard]] std::string masked_scores() {
    const double nothing = -std::numeric_limits<double>::infinity();
    std::string scores =
        parts_.add("MatMul", {split(0, heads_), parts_.transposed(repeated(1), {0, 1, 3, 2})});
    scores = parts_.add("Mul", {scores, parts_.number(scale_)});
    if (context_.has_input(3)) {
      const bool is_truth = context_.input(3).type == ElementType::boolean;
      scores = is_truth ? parts_.add("Where", {parts_.input(3), scores, parts_.number(nothing)})
                        : parts_.add("Add", {scores, parts_.input(3)});
    }
    if (!is_causal_) return scores;
    require_room({length_, keys_});
    std::vector<double> mask(length_ * keys_);
    for (std::size_t i = 0; i < mask.size(); ++i)
      if (i % keys_ > i / keys_) mask[i] = nothing;
    return parts_.add("Add",
                      {scores, parts_.constant({{length_, keys_}, ElementType::floating, std::move(mask)})});
  }

  OperatorContext& context_;
  Decomposer& parts_;
  bool is_flat_ = false, is_causal_ = false;
  std::size_t heads_ = 0, key_heads_ = 0, length_ = 0, keys_ = 0;
  double scale_ = 1;
};

inline void decompose_attention(OperatorContext& context, Decomposer& parts) {
  AttentionParts(context, parts).write();
}

/// Places of patches' taps in a picture with any number of axes.
struct PatchPlaces {
  struct Axis {
    std::int64_t extent = 0, block = 0, dilation = 1, stride = 1, pad = 0;
    std::size_t count = 0;  ///< of patches
  };
  std::vector<Axis> axes{};
  std::size_t taps = 1, patches = 1, pixels = 1;

  /// \throws ShapeError for patches that do not fit the picture
  explicit PatchPlaces(OperatorContext& context) {
    const auto image = context.integers(1), block = context.integers(2);
    const std::size_t rank = image.size();
    const auto ones = std::vector<std::int64_t>(rank, 1);
    const auto dilations = context.integers("dilations", ones), strides = context.integers("strides", ones);
    const auto pads = context.integers("pads", std::vector<std::int64_t>(2 * rank, 0));
    if (rank == 0 || block.size() != rank || dilations.size() != rank || strides.size() != rank ||
        pads.size() != 2 * rank)
      throw ShapeError({"patches of ", block.size(), " axes of a picture of ", rank});
    for (std::size_t a = 0; a < rank; ++a)
      add({image[a], block[a], dilations[a], strides[a], pads[a]}, pads[rank + a]);
  }

  /// The pixel of each tap of each patch; `pixels` for one beside the picture.
  [[nodiscard]] std::vector<double> places() const {
    std::vector<double> all;
    for (std::size_t tap = 0; tap < taps; ++tap)
      for (std::size_t patch = 0; patch < patches; ++patch)
        all.push_back(static_cast<double>(place(tap, patch)));
    return all;
  }

 private:
  void add(Axis axis, std::int64_t pad_behind) {
    const auto is_count = [](std::int64_t n) { return n > 0 && n <= largest_extent; };
    if (!is_count(axis.extent) || !is_count(axis.block) || !is_count(axis.stride) ||
        !is_count(axis.dilation) || std::abs(axis.pad) > largest_extent ||
        std::abs(pad_behind) > largest_extent)
      throw ShapeError({"patches of ", axis.block, " in a picture of ", axis.extent, " pixels"});
    const std::int64_t room = axis.extent + axis.pad + pad_behind - axis.dilation * (axis.block - 1) - 1;
    if (room < 0) throw ShapeError({"patches of ", axis.block, " in a picture of ", axis.extent, " pixels"});
    axis.count = static_cast<std::size_t>(room / axis.stride + 1);
    taps *= static_cast<std::size_t>(axis.block);
    patches *= axis.count;
    pixels *= static_cast<std::size_t>(axis.extent);
    require_room({taps, patches});
    require_room({pixels});
    axes.push_back(axis);
  }

  [[nodiscard]] std::size_t place(std::size_t tap, std::size_t patch) const {
    std::size_t sum = 0, step = 1;
    for (std::size_t a = axes.size(); a-- > 0;) {
      const Axis& axis = axes[a];
      const auto block = static_cast<std::size_t>(axis.block);
      const auto at = static_cast<std::int64_t>(patch % axis.count) * axis.stride - axis.pad +
                      static_cast<std::int64_t>(tap % block) * axis.dilation;
      if (at < 0 || at >= axis.extent) return pixels;
      sum += static_cast<std::size_t>(at) * step;
      step *= static_cast<std::size_t>(axis.extent);
      tap /= block;
      patch /= axis.count;
    }
    return sum;
  }
};

/// Columns of patches added up to a picture, [N, C, …]. Source: onnx.ai, Col2Im.
inline void decompose_col2im(OperatorContext& context, Decomposer& parts) {
  const Shape& x = context.input(0).shape;
  const PatchPlaces patches(context);
  const std::size_t taps = patches.taps, count = patches.patches, pixels = patches.pixels;
  if (x.size() != 3 || x[1] % taps != 0 || x[2] != count)
    throw ShapeError({"input 0 is ", x, ", expected ", count, " patches of a multiple of ", taps});
  const std::size_t maps = x[0] * (x[1] / taps);
  require_room({pixels + 1, maps});
  // Added up along the first axis, [taps · patches, N · channels]; last, a row for places beside it.
  const std::string columns = parts.reshaped(
      parts.transposed(parts.reshaped(parts.input(0), {maps, taps * count}), {1, 0}), {taps * count, maps});
  const std::string indices = parts.constant({{taps * count, 1}, ElementType::integer, patches.places()});
  const std::string nothing =
      parts.constant({{pixels + 1, maps}, ElementType::floating, std::vector<double>((pixels + 1) * maps)});
  const std::string sums =
      parts.add("ScatterND", {nothing, indices, columns}, {{"reduction", std::string("add")}});
  const std::string inside = parts.sliced(sums, 0, static_cast<std::int64_t>(pixels), 0);
  std::vector<std::int64_t> shape{static_cast<std::int64_t>(x[0]), static_cast<std::int64_t>(x[1] / taps)};
  for (const auto& axis : patches.axes) shape.push_back(axis.extent);
  parts.finish(0, "Reshape", {parts.transposed(inside, {1, 0}), parts.integers(shape)});
}
}  // namespace tapestry::nn::detail
