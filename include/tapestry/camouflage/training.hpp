#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <tapestry/autodiff/tape.hpp>
#include <tapestry/camouflage/objective.hpp>
#include <tapestry/camouflage/photo_session.hpp>
#include <tapestry/camouflage/view_store.hpp>
#include <tapestry/camouflage/worst_views.hpp>
#include <tapestry/core/random.hpp>
#include <tapestry/optim/adam.hpp>
#include <utility>
#include <vector>

namespace tapestry::camouflage {

/// How long and how fast a texture is trained.
struct TrainingOptions {
  std::size_t epochs = 5;
  std::size_t batch = 1;   ///< views a step
  double worst_share = 1;  ///< of a step's views, the worst that count; see worst_view_weights()
  std::uint64_t seed = 1;
  optim::AdamSettings adam{};
  image::Conditions conditions{};  ///< what every step photographs its views under; none: as they are
};

/// Which views of every step a process looks at where several train one texture together, and how they tell
/// each other what they found.
struct SharedSteps {
  std::size_t processes = 1;
  std::size_t own = 0;  ///< of the processes, from 0
  /// The values of all processes, one after the other; each calls it at the same time with as many.
  std::function<std::vector<double>(const std::vector<double>&)> gathered;
};

/// Everything that changes while the texture is optimised. Two runs that agree in it and in their
/// settings go on to the same bits.
template <class T>
struct TrainingState {
  Array<T, 2> parameter;  ///< [texel, 3], or a row for each of the method's
  optim::AdamState<T> adam;
  std::uint64_t step = 0;               ///< steps taken
  std::vector<ObjectiveTerms> history;  ///< one entry a step
};

/// Minimises the objective over the texture by Adam, in shuffled minibatches over views.
///
/// The order of an epoch's views depends on the seed and the epoch's number only, and what they are
/// photographed under on the step's, so the state needs no sampler: the step's number says where it stands.
/// Source: FCA (AAAI 2022), Algorithm 1.
template <class T>
class Training {
 public:
  /// \param objective  and \param store must outlive the training
  /// \param usable     the store's views that show the car, at least one
  /// \param start      [texel, 3]; of another method than FCA's its first_parameter()
  Training(Objective<T>& objective, ViewStore<T>& store, std::vector<std::size_t> usable, Array<T, 2> start,
           TrainingOptions options)
      : objective_(objective),
        store_(store),
        usable_(std::move(usable)),
        options_(options),
        adam_(start.size(), options.adam) {
    if (usable_.empty()) throw Error(ErrorKind::mismatch, "training: no view shows the car");
    if (options.batch == 0) throw DomainError("training: a batch needs at least one view");
    if (!(options.worst_share > 0 && options.worst_share <= 1))
      throw DomainError("training: the worst share of views is " + std::to_string(options.worst_share) +
                        ", expected above 0 and at most 1");
    state_.parameter = std::move(start);
  }

  /// Minibatches in an epoch; the last one may be smaller.
  [[nodiscard]] std::size_t steps_per_epoch() const { return block_count(usable_.size(), options_.batch); }
  /// Steps of all epochs.
  [[nodiscard]] std::size_t step_count() const { return options_.epochs * steps_per_epoch(); }
  [[nodiscard]] bool finished() const { return state_.step >= step_count(); }
  /// Steps so far, also those of a run that this one resumes.
  [[nodiscard]] std::uint64_t steps_taken() const { return state_.step; }
  /// What is trained, [texel, 3] or a row for each of the method's; see method_colours().
  [[nodiscard]] const Array<T, 2>& parameter() const { return state_.parameter; }
  /// The terms of every step so far.
  [[nodiscard]] const std::vector<ObjectiveTerms>& history() const { return state_.history; }

  /// Shares the views of every step with processes that begin from the same state: the same bits for any
  /// number of them.
  void share(SharedSteps shared) { shared_ = std::move(shared); }

  /// A copy of everything a checkpoint needs.
  [[nodiscard]] TrainingState<T> state() const {
    TrainingState<T> state = state_;
    state.adam = adam_.state();
    return state;
  }

  /// Continues from a saved state.
  /// \throws ShapeError if it belongs to a texture of another size
  void restore(TrainingState<T> state) {
    require_shape("training", "parameter", state.parameter, state_.parameter.shape());
    adam_.restore(std::move(state.adam));
    state_ = std::move(state);
    state_.adam = {};
  }

  /// One minibatch: records and reverses each view alone, which takes the memory of one, adds their gradients
  /// in the minibatch's order, and updates. Where only the worst views count, the losses of all are computed
  /// first, without a tape.
  ///
  /// \returns the number of views in it
  /// \throws NumericError naming step, term and views if a term or the gradient is not finite; the state
  ///         is then what it was before the step
  std::size_t step() {
    const auto views = next_batch();
    const Array<T, 2> gradient = gradient_of(views);
    require_finite_terms(views);
    require_finite_gradient(gradient, views);
    const ScopedTimer timer(objective_.times().update);
    adam_.step(state_.parameter, gradient);
    state_.history.push_back(terms_);
    ++state_.step;
    return views.size();
  }

 private:
  using ViewPointer = std::shared_ptr<const View<T>>;

  [[nodiscard]] std::vector<ViewPointer> next_batch() {
    const std::size_t epoch = state_.step / steps_per_epoch();
    if (epoch_of_order_ != epoch || order_.empty()) {
      order_ = usable_;
      Random(options_.seed).fork(epoch).shuffle(order_);
      epoch_of_order_ = epoch;
    }
    const auto [begin, end] = block_range(state_.step % steps_per_epoch(), order_.size(), options_.batch);
    std::vector<ViewPointer> batch;
    for (std::size_t i = begin; i < end; ++i) batch.push_back(store_.view(order_[i]));
    return batch;
  }

  /// Depends on the seed and the step's number only, as does the batch.
  [[nodiscard]] std::optional<PhotoSession> next_session(const std::vector<ViewPointer>& views) const {
    if (options_.conditions == image::Conditions{}) return {};
    const Random random = Random(options_.seed).fork(0x70686F746FULL).fork(state_.step);
    return draw_session<T>(views, options_.conditions, random, true);
  }

  /// Leaves the terms in terms_.
  [[nodiscard]] Array<T, 2> gradient_of(const ViewPointer& view, const std::optional<PhotoSession>& session) {
    tape_.clear();
    const auto scope = tape_.activate();
    const ArrayVariable<T, 2> parameter = tape_.input(state_.parameter);
    const Variable<T> loss = objective_(parameter, std::span(&view, 1), session ? &*session : nullptr);
    terms_ = objective_.terms();
    tape_.reverse(loss);
    return parameter.adjoint();
  }

  /// Has `width` numbers found for each of some indices by the process that the index is dealt to, and takes
  /// them in order.
  /// \param find  of an index, its numbers
  /// \param take  what an index's numbers are given to
  template <class Find, class Take>
  void deal(const std::vector<std::size_t>& indices, std::size_t width, Find find, Take take) {
    for (std::size_t first = 0; first < indices.size(); first += shared_.processes) {
      std::vector<double> numbers;
      if (const std::size_t i = first + shared_.own; i < indices.size()) numbers = find(indices[i]);
      if (shared_.processes > 1) {
        numbers.resize(width);
        numbers = shared_.gathered(numbers);
      }
      const double* from = numbers.data();
      for (std::size_t i = first; i < std::min(first + shared_.processes, indices.size()); ++i, from += width)
        take(indices[i], from);
    }
  }

  /// A step's loss is the sum of its views' losses, each divided by its entry here: the number of views, or
  /// where only the worst count, 1 / weight by worst_view_weights(), ∞ for those that do not.
  template <class ShotOf>
  [[nodiscard]] std::vector<double> divisors_of(const std::vector<ViewPointer>& views,
                                                const std::vector<std::size_t>& all, ShotOf shot_of) {
    std::vector<double> divisors(views.size(), static_cast<double>(views.size()));
    if (options_.worst_share == 1) return divisors;
    std::vector<double> losses(views.size());
    const auto loss_of = [&](std::size_t i) {
      const auto shot = shot_of(i);
      const ArrayVariable<T, 2> parameter(state_.parameter);
      static_cast<void>(objective_(parameter, std::span(&views[i], 1), shot ? &*shot : nullptr));
      return std::vector<double>{objective_.terms().total};
    };
    deal(all, 1, loss_of, [&](std::size_t i, const double* loss) { losses[i] = *loss; });
    if (std::ranges::any_of(losses, [](double loss) { return std::isnan(loss); }))
      return divisors;  // the step is refused by its terms
    const auto weights = worst_view_weights(losses, options_.worst_share);
    std::ranges::transform(weights, divisors.begin(), [](double weight) { return 1 / weight; });
    return divisors;
  }

  /// The mean of the views' gradients, or their weighted sum where only the worst count. Leaves the terms' in
  /// terms_.
  [[nodiscard]] Array<T, 2> gradient_of(const std::vector<ViewPointer>& views) {
    constexpr auto& terms = ObjectiveTerms::all;
    const auto session = next_session(views);
    const auto shot_of = [&](std::size_t i) {
      return session ? std::optional(PhotoSession{session->print, {session->shots[i]}}) : std::nullopt;
    };
    std::vector<std::size_t> counting(views.size());
    std::iota(counting.begin(), counting.end(), std::size_t{0});
    const auto divisors = divisors_of(views, counting, shot_of);
    std::erase_if(counting, [&](std::size_t i) { return std::isinf(divisors[i]); });
    Array<T, 2> gradient = zeros<T, 2>(state_.parameter.shape());
    ObjectiveTerms mean{};
    const auto find = [&](std::size_t i) {
      const Array<T, 2> slopes = gradient_of(views[i], shot_of(i));
      std::vector<double> numbers;
      for (const auto& [name, term] : terms) numbers.push_back(terms_.*term);
      numbers.insert(numbers.end(), slopes.begin(), slopes.end());
      return numbers;
    };
    const auto add = [&](std::size_t i, const double* numbers) {
      for (std::size_t k = 0; k < terms.size(); ++k) mean.*terms[k].second += numbers[k] / divisors[i];
      const double* const slopes = numbers + terms.size();
      for (std::size_t k = 0; k < gradient.size(); ++k)
        gradient.data()[k] += static_cast<T>(slopes[k]) / static_cast<T>(divisors[i]);
    };
    deal(counting, terms.size() + gradient.size(), find, add);
    terms_ = mean;
    return gradient;
  }

  void require_finite_terms(const std::vector<ViewPointer>& views) const {
    for (const auto& [name, term] : ObjectiveTerms::all)
      if (!std::isfinite(terms_.*term))
        throw NumericError("step " + std::to_string(state_.step + 1) + ": term " + name + " is " +
                           std::to_string(terms_.*term) + " in the minibatch of " + names_of(views));
  }

  void require_finite_gradient(const Array<T, 2>& gradient, const std::vector<ViewPointer>& views) const {
    for (std::size_t i = 0; i < gradient.size(); ++i)
      if (!std::isfinite(gradient.data()[i]))
        throw NumericError("step " + std::to_string(state_.step + 1) + ": the gradient of " +
                           row_name(i / 3) + " is not finite in the minibatch of " + names_of(views));
  }

  [[nodiscard]] std::string row_name(std::size_t row) const {
    const auto& shape = objective_.method().shape;
    const std::size_t texels = state_.parameter.shape(0) - (shape ? shape->row_count() : 0);
    return row < texels ? "texel " + std::to_string(row) : "position " + std::to_string(row - texels);
  }

  [[nodiscard]] static std::string names_of(const std::vector<ViewPointer>& views) {
    std::string names;
    for (const auto& view : views) names += (names.empty() ? "" : ", ") + view->name;
    return names;
  }

  Objective<T>& objective_;
  ViewStore<T>& store_;
  std::vector<std::size_t> usable_;
  TrainingOptions options_;
  optim::Adam<T> adam_;
  TrainingState<T> state_;
  ObjectiveTerms terms_;  ///< of the last step
  SharedSteps shared_;
  Tape<T> tape_;
  std::vector<std::size_t> order_;
  std::size_t epoch_of_order_ = 0;
};

}  // namespace tapestry::camouflage
