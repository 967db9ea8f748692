#pragma once
#include <tapestry/camouflage/objective.hpp>
#include <tapestry/camouflage/view_store.hpp>
#include <tapestry/optim/adam.hpp>

namespace tapestry::camouflage {
/// Length, speed and conditions of a texture's training.
struct TrainingOptions {
  std::size_t epochs = 5;
  std::size_t batch = 1;   ///< views a step
  double worst_share = 1;  ///< share of a step's views that count; see worst_view_weights()
  std::uint64_t seed = 1;
  optim::AdamSettings adam{};
  image::Conditions conditions{};  ///< conditions of every step's photographs; none: unchanged pictures
};

/// Which views of every step a process computes where several train one texture together, and how they
/// exchange their results.
struct SharedSteps {
  std::size_t processes = 1;
  std::size_t own = 0;  ///< index of this process, from 0
  /// Collects the values of all processes, one after the other; all call it together, with equally many.
  std::function<std::vector<double>(const std::vector<double>&)> gathered;
};

/// Everything that changes while the texture is optimised. Two runs with the same state and settings continue
/// to the same bits.
template <std::floating_point T>
struct TrainingState {
  Array<T, 2> parameter;  ///< [texel, 3], or a row for each of the method's
  optim::AdamState<T> adam;
  std::uint64_t step = 0;               ///< steps taken
  std::vector<ObjectiveTerms> history;  ///< one entry a step
};

/// Minimises the objective over the texture by Adam, in shuffled minibatches over views.
///
/// The order of an epoch's views depends only on the seed and the epoch's number, and their photographs'
/// conditions only on the step's number, so the state needs no sampler: the step's number is enough. Source:
/// FCA (AAAI 2022), Algorithm 1.
template <std::floating_point T>
class Training {
 public:
  /// \param objective  must outlive the training
  /// \param store      must outlive the training
  /// \param usable     the store's views that show the car, at least one
  /// \param start      [texel, 3]; for another method than FCA's its first_parameter()
  Training(Objective<T>& objective, ViewStore<T>& store, std::vector<std::size_t> usable, Array<T, 2> start,
           TrainingOptions options);

  /// Bytes that a training holds by its texture: the parameter and Adam's moments.
  [[nodiscard]] static std::uint64_t kept_bytes(std::uint64_t texels) { return 9 * sizeof(T) * texels; }

  /// Bytes that a step takes by its texture: colours, their adjoint and the gradient, and the texels that
  /// views are drawn from with their adjoint. \param stored  number of raster::stored_texels()
  [[nodiscard]] static std::uint64_t step_bytes(std::uint64_t texels, std::uint64_t stored) {
    return 3 * sizeof(T) * (3 * texels + 2 * stored);
  }

  /// Minibatches in an epoch; the last one may be smaller.
  [[nodiscard]] std::size_t steps_per_epoch() const { return block_count(usable_.size(), options_.batch); }
  /// Steps of all epochs.
  [[nodiscard]] std::size_t step_count() const { return options_.epochs * steps_per_epoch(); }
  [[nodiscard]] bool finished() const { return state_.step >= step_count(); }
  /// Steps so far, including the run that this one resumes.
  [[nodiscard]] std::uint64_t steps_taken() const { return state_.step; }
  /// The trained parameter, [texel, 3] or a row for each of the method's; see method_colours().
  [[nodiscard]] const Array<T, 2>& parameter() const { return state_.parameter; }
  /// The terms of every step so far.
  [[nodiscard]] const std::vector<ObjectiveTerms>& history() const { return state_.history; }

  /// Shares the views of every step with processes that begin from the same state: the same bits for any
  /// number of them.
  void share(SharedSteps shared) { shared_ = std::move(shared); }

  /// A copy of everything a checkpoint needs.
  [[nodiscard]] TrainingState<T> state() const;

  /// Continues from a saved state.
  /// \throws ShapeError if it belongs to a texture of another size
  void restore(TrainingState<T> state);

  /// One minibatch: records and reverses each view alone, on a thread each, which takes the memory of a view
  /// a thread, prepares the next minibatch's views meanwhile, adds their gradients in the minibatch's order,
  /// carries them from texels to the parameter once, and updates: the same bits for any number of threads. If
  /// only the worst views count, the losses of all are computed first, without a tape.
  ///
  /// \returns the number of views in it
  /// \throws NumericError naming step, term and views if a term or the gradient is not finite; the state is
  ///         then unchanged
  std::size_t step();

 private:
  using ViewPointer = std::shared_ptr<const View<T>>;

  /// Views of a step, prepared one by one.
  struct Batch {
    std::uint64_t step = 0;
    std::vector<std::size_t> indices{};  ///< in the store
    std::vector<ViewPointer> views{};    ///< as many; null until prepared
  };

  /// The views that a step takes, none prepared.
  [[nodiscard]] Batch batch_of(std::uint64_t step);

  /// The views of this step, prepared here unless the last step prepared them; next_ then
  /// holds the following step's.
  [[nodiscard]] std::vector<ViewPointer> next_batch();

  void prepare_next(std::size_t i) {
    if (!next_.views[i]) next_.views[i] = store_.view(next_.indices[i]);
  }

  /// The session depends on the seed and the step's number only, as does the batch.
  [[nodiscard]] std::optional<PhotoSession> next_session(const std::vector<ViewPointer>& views) const;

  /// Derivatives by the texels and positions that a view is drawn with: by the texels that it reads, or by
  /// all where the car's shape moves. Empty if not wanted.
  struct Slopes {
    Array<T, 2> texels, positions;
  };

  /// Terms and gradient that one view adds to a step.
  struct Share {
    ObjectiveTerms terms{};
    Slopes slopes{};

    [[nodiscard]] std::vector<double> numbers() const;
    [[nodiscard]] static std::size_t count_of(const Slopes& slopes) {
      return ObjectiveTerms::all.size() + slopes.texels.size() + slopes.positions.size();
    }
    /// \param slopes  of the extents that are wanted
    static Share of(const double* numbers, Slopes slopes);
  };

  /// \param paint  not on a tape
  [[nodiscard]] Share share_of(const DrawnPaint<T>& paint, const ViewPointer& view,
                               const std::optional<PhotoSession>& session);

  /// find() of some views of a step, in their order. Each process computes its own share on several
  /// threads; then all exchange them.
  /// \param slopes  of the extents that find() gives for each
  template <class Find>
  [[nodiscard]] std::vector<Share> shares_of(const std::vector<ViewPointer>& batch,
                                             const std::vector<std::size_t>& views,
                                             const std::vector<Slopes>& slopes, Find find) {
    std::vector<Share> shares(views.size());
    std::vector<std::size_t> own;
    for (std::size_t k = shared_.own; k < views.size(); k += shared_.processes) own.push_back(k);
    const auto pixels = [&](std::size_t k) {
      const auto& window = batch[views[k]]->window;
      return window.width * window.height;
    };
    // The longest first, then the next step's, which are short: threads end together.
    std::ranges::stable_sort(own, std::greater{}, pixels);
    for_each_view(own.size() + next_.views.size(), [&](std::size_t j) {
      if (j < own.size())
        shares[own[j]] = find(views[own[j]]);
      else
        prepare_next(j - own.size());
    });
    if (shared_.processes > 1) exchange(shares, slopes);
    return shares;
  }

  /// Calls body(k) for k = 0 … count − 1, on a thread each or, for large networks, one after the other.
  template <class Body>
  void for_each_view(std::size_t count, Body body) {
    if (objective_.prefers_views_side_by_side()) return parallel_for(count, body);
    for (std::size_t k = 0; k < count; ++k) body(k);
  }

  /// Takes the shares of the other processes, a round of one view each after the other.
  void exchange(std::vector<Share>& shares, const std::vector<Slopes>& slopes) const;

  /// A step's loss is the sum of its views' losses, each divided by its entry here: the number of views, or
  /// if only the worst count, 1 / weight by worst_view_weights(), ∞ for views that do not count.
  template <class ShotOf>
  [[nodiscard]] std::vector<double> divisors_of(const DrawnPaint<T>& paint,
                                                const std::vector<ViewPointer>& views,
                                                const std::vector<std::size_t>& all, ShotOf shot_of) {
    std::vector<double> divisors(views.size(), static_cast<double>(views.size()));
    if (options_.worst_share == 1) return divisors;
    std::vector<double> losses(views.size());
    const auto loss_of = [&](std::size_t i) {
      const auto shot = shot_of(i);
      return Share{objective_.evaluate(paint, std::span(&views[i], 1), shot ? &*shot : nullptr).terms, {}};
    };
    std::ranges::transform(shares_of(views, all, std::vector<Slopes>(all.size()), loss_of), losses.begin(),
                           [](const Share& share) { return share.terms.total; });
    if (std::ranges::any_of(losses, [](double loss) { return std::isnan(loss); }))
      return divisors;  // the step then fails because of its terms
    const auto weights = worst_view_weights(losses, options_.worst_share);
    std::ranges::transform(weights, divisors.begin(), [](double weight) { return 1 / weight; });
    return divisors;
  }

  /// Slopes of the extents that share_of() gives for some views.
  [[nodiscard]] static std::vector<Slopes> slopes_of(const DrawnPaint<T>& paint,
                                                     const std::vector<ViewPointer>& views,
                                                     const std::vector<std::size_t>& counting);

  /// The parameter, which it does not own, with the mean of the views' gradients as its adjoint until the
  /// next step, or with their weighted sum if only the worst count; stores the same of the terms in terms_.
  [[nodiscard]] ArrayVariable<T, 2> differentiated(const std::vector<ViewPointer>& views);

  /// A variable, 0, whose pullback adds Σ slopes / divisors to x: the reverse sweep continues the views'
  /// sweeps.
  /// \param add  add(number of a share, its divisor, x's adjoint), called in the order of the shares
  template <class Add>
  [[nodiscard]] static Variable<T> continued(const ArrayVariable<T, 2>& x,
                                             const std::vector<double>& divisors, Add add) {
    return record_scalar(
        T(0),
        [add, divisors](T, Array<T, 2>* x_adjoint) {
          for (std::size_t k = 0; k < divisors.size(); ++k) add(k, static_cast<T>(divisors[k]), *x_adjoint);
        },
        x);
  }

  static void add_quotient(const Array<T, 2>& slopes, T divisor, Array<T, 2>& adjoint) {
    for (std::size_t i = 0; i < slopes.size(); ++i) adjoint.data()[i] += slopes.data()[i] / divisor;
  }

  void require_finite_terms(const std::vector<ViewPointer>& views) const;

  void require_finite_gradient(const Array<T, 2>& gradient, const std::vector<ViewPointer>& views) const;

  [[nodiscard]] std::string row_name(std::size_t row) const;

  [[nodiscard]] static std::string names_of(const std::vector<ViewPointer>& views);

  Objective<T>& objective_;
  ViewStore<T>& store_;
  std::vector<std::size_t> usable_;
  TrainingOptions options_;
  optim::Adam<T> adam_;
  TrainingState<T> state_;
  ObjectiveTerms terms_;  ///< of the last step
  SharedSteps shared_;
  Pool<Tape<T>> tapes_;
  std::vector<std::size_t> order_;
  std::size_t epoch_of_order_ = 0;
  Batch next_;
};

extern template class Training<float>;
}  // namespace tapestry::camouflage
