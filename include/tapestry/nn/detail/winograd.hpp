#pragma once
#include <tapestry/nn/detail/winograd_plan.hpp>

namespace tapestry::nn {
namespace detail {
/// One convolution by Winograd's algorithm.
template <std::floating_point T>
class WinogradConvolution {
 public:
  WinogradConvolution(const PackedConvolution<T>& packed, std::size_t images, WinogradForm form, const T* in,
                      const Epilogue<T>& end, T* out, std::size_t out_image_size, bool pairs)
      : packed_(packed),
        shape_(packed.shape),
        pairs_(pairs),
        plan_(plan_winograd<T>(packed.shape, images, form, pairs)),
        in_(in),
        end_(end),
        out_(out),
        out_image_size_(out_image_size) {}

  void run() const {
    static thread_local Buffer<T> kept;
    Buffer<T>& shared = kept;  // the calling thread's, for all threads that run the tasks
    const T* const filters = all_filters(shared);
    if (plan_.shares_filters) {
      parallel_for(plan_.ranges, [&](std::size_t range) {
        static thread_local Buffer<T> inputs;
        inputs.resize(plan_.input_range_step(line));
        transform_inputs(range, 0, tiles_of(range), inputs.data());
        for (std::size_t panel = 0; panel < plan_.panels; ++panel)
          multiply(range, panel, inputs.data(), filters + panel * filter_panel_step());
      });
      return;
    }
    shared.resize(plan_.ranges * plan_.input_range_step(line));
    constexpr std::size_t at_once = 4;
    const std::size_t chunks = block_count(plan_.tiles_per_range, at_once);
    parallel_for(plan_.ranges * chunks, [&](std::size_t task) {
      const std::size_t range = task / chunks;
      const std::size_t begin = task % chunks * at_once;
      transform_inputs(range, begin, std::min(begin + at_once, tiles_of(range)),
                       shared.data() + range * plan_.input_range_step(line));
    });
    parallel_for(plan_.ranges * plan_.panels, [&](std::size_t task) {
      const std::size_t range = task % plan_.ranges, panel = task / plan_.ranges;
      multiply(range, panel, shared.data() + range * plan_.input_range_step(line),
               filters == nullptr ? nullptr : filters + panel * filter_panel_step());
    });
  }

 private:
  static constexpr std::size_t line = 64 / sizeof(T);

  /// The transformed filters of all panels, kept or in the memory given; null where each task transforms its
  /// own.
  [[nodiscard]] const T* all_filters(Buffer<T>& memory) const {
    const std::size_t size = plan_.panels * filter_panel_step(), tasks = plan_.panels * plan_.blocks;
    if (plan_.keeps_filters && packed_.transformed) {
      auto& transformed = (*packed_.transformed)[form() + (pairs_ ? winograd_form_count : 0)];
      std::call_once(transformed.made, [&] {
        transformed.filters.resize(size);
        for (std::size_t task = 0; task < tasks; ++task) transform_block(task, transformed.filters.data());
      });
      return transformed.filters.data();
    }
    if (!plan_.shares_filters) return nullptr;
    memory.resize(size);
    parallel_for(tasks, [&](std::size_t task) { transform_block(task, memory.data()); });
    return memory.data();
  }

  struct Tile {
    std::size_t image;
    std::size_t row;  ///< row of its first output
    std::size_t column;
  };

  [[nodiscard]] Tile tile_at(std::size_t range, std::size_t index) const {
    const std::size_t number = range * plan_.tiles_per_range + index;
    const std::size_t of_image = plan_.tile_rows * plan_.tile_columns;
    return {number / of_image, number % of_image / plan_.tile_columns * plan_.axis.outputs,
            number % plan_.tile_columns * plan_.axis.outputs};
  }
  [[nodiscard]] std::size_t tiles_of(std::size_t range) const {
    return std::min(plan_.tiles_per_range, plan_.tiles - range * plan_.tiles_per_range);
  }
  [[nodiscard]] std::size_t form() const { return static_cast<std::size_t>(plan_.form); }

  /// A pixel of zeros for each thread, which stands for all pixels outside the picture.
  static const T* zeros(std::size_t channels) {
    static thread_local Buffer<T> zero;
    if (zero.size() < channels) {
      zero.resize(channels);
      zero.fill_zero();
    }
    return zero.data();
  }

  void transform_inputs(std::size_t range, std::size_t begin, std::size_t end, T* inputs) const {
    const T* pixels[36];
    const T* const zero = zeros(shape_.in_channels);
    for (std::size_t i = begin; i < end; ++i) {
      const Tile tile = tile_at(range, i);
      const T* const picture = in_ + tile.image * shape_.in_size();
      const std::size_t points = plan_.axis.points;
      for (std::size_t y = 0; y < points; ++y) {
        // Beyond an edge the position wraps to a huge number, which is outside as well.
        const std::size_t row = tile.row + y - static_cast<std::size_t>(shape_.rows.padding);
        for (std::size_t x = 0; x < points; ++x) {
          const std::size_t column = tile.column + x - static_cast<std::size_t>(shape_.columns.padding);
          const bool is_inside = row < shape_.rows.input && column < shape_.columns.input;
          pixels[y * points + x] =
              is_inside ? picture + (row * shape_.columns.input + column) * shape_.in_channels : zero;
        }
      }
      WinogradInputArguments<T> a{pixels, 0, 0, nullptr, plan_.input_point_step(line)};
      for (std::size_t block = 0; block < plan_.blocks; ++block) {
        a.first_channel = block * plan_.channels_per_block;
        a.channel_count = channels_of(block);
        a.out = inputs + block * plan_.input_block_step(line) + i * plan_.words_per_block;
        (pairs_ ? kernels<T>().winograd_input_pairs : kernels<T>().winograd_input)[form()](a);
      }
    }
  }

  [[nodiscard]] std::size_t channels_of(std::size_t block) const {
    const std::size_t first = block * plan_.channels_per_block;
    return std::min(plan_.channels_per_block, shape_.in_channels - first);
  }

  /// Filters of a panel, side by side in memory.
  [[nodiscard]] std::size_t width_of(std::size_t panel) const {
    const std::size_t lanes = kernels<T>().lanes;
    return panel_lanes(panel * 2 * lanes, round_up(shape_.out_channels, lanes), lanes);
  }
  // Distances between the transformed filters of blocks and panels, computed as if all panels were full.
  [[nodiscard]] std::size_t filter_step() const {
    return plan_.products * plan_.filter_point_step(line, 2 * kernels<T>().lanes);
  }
  [[nodiscard]] std::size_t filter_panel_step() const { return plan_.blocks * filter_step(); }

  /// Start of the packed weights of a panel's block; taps are in_channels · width apart.
  [[nodiscard]] const T* packed_filters(std::size_t panel, std::size_t block) const {
    return packed_.weights->data() + panel * 2 * kernels<T>().lanes * packed_.reduction() +
           block * plan_.channels_per_block * width_of(panel);
  }

  /// \param filters  of all panels
  void transform_block(std::size_t task, T* filters) const {
    const std::size_t panel = task / plan_.blocks, block = task % plan_.blocks;
    transform_filters(panel, block, filters + panel * filter_panel_step() + block * filter_step());
  }

  void transform_filters(std::size_t panel, std::size_t block, T* filters) const {
    const std::size_t width = width_of(panel);
    const auto& transform = pairs_ ? kernels<T>().winograd_filter_pairs : kernels<T>().winograd_filters;
    transform[form()]({packed_filters(panel, block), shape_.in_channels * width, channels_of(block), width,
                       filters, plan_.filter_point_step(line, width)});
  }

  /// \param all_filters  of the panel, transformed, or null
  void multiply(std::size_t range, std::size_t panel, const T* inputs, const T* all_filters) const {
    static thread_local Buffer<T> own_filters;
    static thread_local Buffer<T> sums;
    const std::size_t lanes = kernels<T>().lanes;
    const std::size_t width = width_of(panel);
    const std::size_t tiles = tiles_of(range);
    const std::size_t point_step = plan_.filter_point_step(line, width);
    const std::size_t sum_step = tiles * width + line;
    if (all_filters == nullptr) own_filters.resize(filter_step());
    sums.resize(plan_.products * sum_step);
    ReduceArguments<T> product{};
    product.in_row_step = static_cast<std::ptrdiff_t>(plan_.words_per_block);
    product.in_inner_step = 1;
    product.outer_count = 1;
    product.out_row_step = static_cast<std::ptrdiff_t>(width);
    product.lane_count = width;
    for (std::size_t block = 0; block < plan_.blocks; ++block) {
      if (all_filters == nullptr) transform_filters(panel, block, own_filters.data());
      const T* const filters =
          all_filters == nullptr ? own_filters.data() : all_filters + block * filter_step();
      product.inner_count = channels_of(block) / plan_.channels_per_word;
      product.end.adds = block > 0;
      for (std::size_t point = 0; point < plan_.products; ++point) {
        if (all_filters == nullptr && block + 1 < plan_.blocks) prefetch_filters(panel, block + 1, point);
        product.weights = filters + point * point_step;
        multiply_point(inputs + block * plan_.input_block_step(line) + point * plan_.input_point_step(line),
                       tiles, width / lanes, product, sums.data() + point * sum_step);
      }
    }
    const std::size_t first = panel * 2 * lanes;
    write(range, first, std::min(width, shape_.out_channels - first), width, sums.data(), sum_step);
  }

  /// Prefetches the point-th part of a block's weights while products are computed.
  void prefetch_filters(std::size_t panel, std::size_t block, std::size_t point) const {
    const std::size_t width = width_of(panel);
    const std::size_t lines_of_tap = block_count(channels_of(block) * width, line);
    const std::size_t lines = shape_.taps() * lines_of_tap;
    const T* const weights = packed_filters(panel, block);
    for (std::size_t i = lines * point / plan_.products; i < lines * (point + 1) / plan_.products; ++i)
      __builtin_prefetch(weights + i / lines_of_tap * shape_.in_channels * width + i % lines_of_tap * line);
  }

  void multiply_point(const T* inputs, std::size_t tiles, std::size_t registers, ReduceArguments<T>& product,
                      T* sums) const {
    const Kernels<T>& simd = kernels<T>();
    const std::size_t groups = block_count(tiles, simd.tile_rows);
    product.in = inputs;
    product.out = sums;
    for (std::size_t g = 0; g < groups; ++g) {
      const std::size_t height = tiles * (g + 1) / groups - tiles * g / groups;
      (pairs_ ? simd.reduce_pairs : simd.reduce)[registers - 1][height - 1](product);
      product.in += static_cast<std::ptrdiff_t>(height) * product.in_row_step;
      product.out += static_cast<std::ptrdiff_t>(height) * product.out_row_step;
    }
  }

  void write(std::size_t range, std::size_t first, std::size_t count, std::size_t width, const T* sums,
             std::size_t sum_step) const {
    WinogradOutputArguments<T> a{};
    a.point_step = sum_step;
    a.pixel_step = packed_.column_step * shape_.out_channels;
    a.row_step = packed_.row_step * packed_.out_columns * shape_.out_channels;
    a.lane_count = count;
    a.end = end_;
    a.end.origin = out_;
    if (a.end.bias != nullptr) a.end.bias += first;
    for (std::size_t i = 0; i < tiles_of(range); ++i) {
      const Tile tile = tile_at(range, i);
      a.sums = sums + i * width;
      a.rows = std::min(plan_.axis.outputs, shape_.rows.output - tile.row);
      a.columns = std::min(plan_.axis.outputs, shape_.columns.output - tile.column);
      const std::size_t row = packed_.first_row + tile.row * packed_.row_step;
      const std::size_t column = packed_.first_column + tile.column * packed_.column_step;
      a.out = out_ + tile.image * out_image_size_ +
              (row * packed_.out_columns + column) * shape_.out_channels + first;
      kernels<T>().winograd_output[form()](a);
    }
  }

  const PackedConvolution<T>& packed_;
  const ConvolutionShape& shape_;
  bool pairs_;  ///< products are of pairs of bfloat16, see bfloat16.hpp
  WinogradPlan plan_;
  const T* in_;
  Epilogue<T> end_;
  T* out_;
  std::size_t out_image_size_;
};
}  // namespace detail

/// A convolution by Winograd's minimal filtering:
///
///   Y = Aᵀ [ Σ_c (G g_c Gᵀ) ⊙ (Bᵀ d_c B) ] A
/// for each tile of outputs. Products per pixel and pair of channels; the last number is that of the plain
/// sum:
///
///   f2_taps3          2 × 2 outputs of 3 × 3 taps     4      9     points {0, ±1, ∞}
///   f4_taps3          4 × 4                           2.25   9     {0, ±2/3, ±3/2, ∞}
///   f4_taps2          4 × 4 of 2 × 2 taps             1.56   4     {±2/3, ±3/2, ∞}
///
/// The last form is one of the four parts of the adjoint of a stride of 2. The rounding error of the points
/// {0, ±2/3, ±3/2, ∞} is about half the error of the textbook's {0, ±1, ±2, ∞}. The sum over channels is
/// taken in blocks of at most 64, so that rounding does not grow with the number of channels.
///
/// Filters are transformed from the packed weights when they are needed, a block at a time, and stay in the
/// second cache. For 49 tiles that takes 7 % of the products' time, and saves four times the weights' memory
/// and bandwidth. If they are few, all are kept instead.
///
/// \param pairs  transformed inputs and filters are rounded to bfloat16, of an even number of channels in;
///               see bfloat16.hpp. Partial sums are then of 128 channels
///
/// Arguments otherwise as convolve(). The convolution must have the form; see has_form().
///
/// Sources: Lavin and Gray, "Fast algorithms for convolutional neural networks" (2016); points of the form
/// {c, −c, 1/c, −1/c}: Alam, Anderson, Barabasz and Gregg (2022).
template <std::floating_point T>
void convolve_winograd(const PackedConvolution<T>& packed, WinogradForm form, std::size_t images, const T* in,
                       const Epilogue<T>& end, T* out, std::size_t out_image_size, bool pairs = false) {
  detail::WinogradConvolution<T>(packed, images, form, in, end, out, out_image_size, pairs).run();
}
}  // namespace tapestry::nn
