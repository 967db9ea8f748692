#pragma once
#include <tapestry/camouflage/training.hpp>

namespace tapestry::camouflage {
template <std::floating_point T>
Training<T>::Training(Objective<T>& objective, ViewStore<T>& store, std::vector<std::size_t> usable,
                      Array<T, 2> start, TrainingOptions options)
    : objective_(objective),
      store_(store),
      usable_(std::move(usable)),
      options_(options),
      adam_(start.size(), options.adam) {
  if (usable_.empty()) throw Error(ErrorKind::mismatch, "training: no view shows the car");
  if (options.batch == 0) throw DomainError("training: a batch needs at least one view");
  if (!(options.worst_share > 0 && options.worst_share <= 1))
    throw DomainError(
        {"training: the worst share of views is ", options.worst_share, ", expected above 0 and at most 1"});
  state_.parameter = std::move(start);
}

template <std::floating_point T>
TrainingState<T> Training<T>::state() const {
  TrainingState<T> state = state_;
  state.adam = adam_.state();
  return state;
}

template <std::floating_point T>
void Training<T>::restore(TrainingState<T> state) {
  require_shape("training", "parameter", state.parameter, state_.parameter.shape());
  adam_.restore(std::move(state.adam));
  state_ = std::move(state);
  state_.adam = {};
}

template <std::floating_point T>
std::size_t Training<T>::step() {
  const auto views = next_batch();
  const ArrayVariable<T, 2> parameter = differentiated(views);
  const Array<T, 2>& gradient = parameter.adjoint();
  require_finite_terms(views);
  require_finite_gradient(gradient, views);
  const ScopedTimer timer(objective_.times().update);
  const ScopedWorkTimer work(objective_.times().adam);
  adam_.step(state_.parameter, gradient);
  state_.history.push_back(terms_);
  ++state_.step;
  return views.size();
}

template <std::floating_point T>
auto Training<T>::batch_of(std::uint64_t step) -> Batch {
  const std::size_t epoch = step / steps_per_epoch();
  if (epoch_of_order_ != epoch || order_.empty()) {
    order_ = usable_;
    Random(options_.seed).fork(epoch).shuffle(order_);
    epoch_of_order_ = epoch;
  }
  const auto [begin, end] = block_range(step % steps_per_epoch(), order_.size(), options_.batch);
  const auto first = order_.begin();
  Batch batch{
      step, {first + static_cast<std::ptrdiff_t>(begin), first + static_cast<std::ptrdiff_t>(end)}, {}};
  batch.views.resize(batch.indices.size());
  return batch;
}

template <std::floating_point T>
std::vector<typename Training<T>::ViewPointer> Training<T>::next_batch() {
  if (next_.step != state_.step || next_.views.empty()) {
    next_ = batch_of(state_.step);
    parallel_for(next_.views.size(), [&](std::size_t i) { prepare_next(i); });
  }
  const std::vector<ViewPointer> views = std::move(next_.views);
  next_ = state_.step + 1 < step_count() ? batch_of(state_.step + 1) : Batch{};
  return views;
}

template <std::floating_point T>
std::optional<PhotoSession> Training<T>::next_session(const std::vector<ViewPointer>& views) const {
  if (options_.conditions == image::Conditions{}) return {};
  const Random random = Random(options_.seed).fork(0x70686F746FULL).fork(state_.step);
  return draw_session<T>(views, options_.conditions, random, true);
}

template <std::floating_point T>
auto Training<T>::share_of(const DrawnPaint<T>& paint, const ViewPointer& view,
                           const std::optional<PhotoSession>& session) -> Share {
  const auto tape = tapes_.take();
  tape->clear();
  const auto scope = tape->activate();
  const bool moves = paint.positions.size() > 0;
  DrawnPaint<T> own;
  own.is_of_view = !moves;
  own.texels = tape->input(moves ? paint.texels.value()
                                 : raster::own_texels(*view->paint_to_picture, paint.texels.value()));
  if (moves) own.positions = tape->input(paint.positions.value());
  const auto [loss, terms] = objective_.evaluate(own, std::span(&view, 1), session ? &*session : nullptr);
  tape->reverse(loss);
  return {terms, {own.texels.adjoint(), own.positions.adjoint()}};
}

template <std::floating_point T>
auto Training<T>::slopes_of(const DrawnPaint<T>& paint, const std::vector<ViewPointer>& views,
                            const std::vector<std::size_t>& counting) -> std::vector<Slopes> {
  std::vector<Slopes> slopes;
  const Extents<2> positions = paint.positions.shape();
  for (const std::size_t i : counting) {
    const std::size_t own = views[i]->paint_to_picture->texel_count;
    const std::size_t texels = positions[0] > 0 ? paint.texels.shape()[0] : own;
    slopes.push_back({Array<T, 2>(Extents<2>{texels, 3}), Array<T, 2>(positions)});
  }
  return slopes;
}

template <std::floating_point T>
ArrayVariable<T, 2> Training<T>::differentiated(const std::vector<ViewPointer>& views) {
  std::optional<ScopedWorkTimer> work(objective_.times().paint);
  const auto session = next_session(views);
  const auto shot_of = [&](std::size_t i) {
    return session ? std::optional(PhotoSession{session->print, {session->shots[i]}}) : std::nullopt;
  };
  const auto tape = tapes_.take();
  tape->clear();
  const auto scope = tape->activate();
  const std::shared_ptr<const Array<T, 2>> not_owned(std::shared_ptr<void>(), &state_.parameter);
  const ArrayVariable<T, 2> parameter = tape->input(ArrayVariable<T, 2>(not_owned));
  const auto [paint, of_paint] = objective_.paint_of(parameter, views, session ? &*session : nullptr);
  const DrawnPaint<T> still{ArrayVariable<T, 2>(paint.texels.shared_value()),
                            ArrayVariable<T, 2>(paint.positions.shared_value())};
  work.emplace(objective_.times().views);
  std::vector<std::size_t> counting(views.size());
  std::iota(counting.begin(), counting.end(), std::size_t{0});
  auto divisors = divisors_of(still, views, counting, shot_of);
  std::erase_if(counting, [&](std::size_t i) { return std::isinf(divisors[i]); });
  std::erase_if(divisors, [](double divisor) { return std::isinf(divisor); });
  const bool moves = paint.positions.size() > 0;
  const auto shares = shares_of(views, counting, slopes_of(still, views, counting),
                                [&](std::size_t i) { return share_of(still, views[i], shot_of(i)); });
  work.emplace(objective_.times().pullback);
  terms_ = of_paint.terms;
  for (std::size_t k = 0; k < shares.size(); ++k) terms_.add(shares[k].terms, divisors[k]);
  const auto add_texels = [&](std::size_t k, T divisor, Array<T, 2>& adjoint) {
    if (moves)
      add_quotient(shares[k].slopes.texels, divisor, adjoint);
    else
      raster::add_own_texels(*views[counting[k]]->paint_to_picture, shares[k].slopes.texels, divisor,
                             adjoint);
  };
  const auto add_positions = [&](std::size_t k, T divisor, Array<T, 2>& adjoint) {
    add_quotient(shares[k].slopes.positions, divisor, adjoint);
  };
  Variable<T> loss = of_paint.loss + continued(paint.texels, divisors, add_texels);
  if (moves) loss += continued(paint.positions, divisors, add_positions);
  tape->reverse(loss);
  return parameter;
}

template <std::floating_point T>
void Training<T>::exchange(std::vector<Share>& shares, const std::vector<Slopes>& slopes) const {
  for (std::size_t first = 0; first < shares.size(); first += shared_.processes) {
    const std::size_t end = std::min(first + shared_.processes, shares.size()), own = first + shared_.own;
    std::size_t width = 0;
    for (std::size_t i = first; i < end; ++i) width = std::max(width, Share::count_of(slopes[i]));
    std::vector<double> numbers;
    if (own < shares.size()) numbers = shares[own].numbers();
    numbers.resize(width);
    numbers = shared_.gathered(numbers);
    for (std::size_t i = first; i < end; ++i)
      shares[i] = Share::of(numbers.data() + (i - first) * width, slopes[i]);
  }
}

template <std::floating_point T>
std::vector<double> Training<T>::Share::numbers() const {
  std::vector<double> numbers;
  for (const auto& term : ObjectiveTerms::all) numbers.push_back(terms.*term.value);
  numbers.insert(numbers.end(), slopes.texels.begin(), slopes.texels.end());
  numbers.insert(numbers.end(), slopes.positions.begin(), slopes.positions.end());
  return numbers;
}

template <std::floating_point T>
typename Training<T>::Share Training<T>::Share::of(const double* numbers, Slopes slopes) {
  Share share{{}, std::move(slopes)};
  for (const auto& term : ObjectiveTerms::all) share.terms.*term.value = *numbers++;
  for (T& slope : share.slopes.texels.storage()) slope = static_cast<T>(*numbers++);
  for (T& slope : share.slopes.positions.storage()) slope = static_cast<T>(*numbers++);
  return share;
}

template <std::floating_point T>
void Training<T>::require_finite_terms(const std::vector<ViewPointer>& views) const {
  for (const auto& term : ObjectiveTerms::all)
    if (const double value = terms_.*term.value; !std::isfinite(value))
      throw NumericError({"step ", state_.step + 1, ": term ", term.name, " is ", value,
                          " in the minibatch of ", names_of(views)});
}

template <std::floating_point T>
void Training<T>::require_finite_gradient(const Array<T, 2>& gradient,
                                          const std::vector<ViewPointer>& views) const {
  constexpr std::size_t block = std::size_t(1) << 16U;
  parallel_for_blocks(gradient.size(), block, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      if (!std::isfinite(gradient.data()[i]))
        throw NumericError({"step ", state_.step + 1, ": the gradient of ", row_name(i / 3),
                            " is not finite in the minibatch of ", names_of(views)});
  });
}

template <std::floating_point T>
std::string Training<T>::row_name(std::size_t row) const {
  const auto& shape = objective_.method().shape;
  const std::size_t texels = state_.parameter.shape(0) - (shape ? shape->row_count() : 0);
  return row < texels ? "texel " + std::to_string(row) : "position " + std::to_string(row - texels);
}

template <std::floating_point T>
std::string Training<T>::names_of(const std::vector<ViewPointer>& views) {
  return listed(views, [](const ViewPointer& view) { return view->name; });
}

template <std::floating_point T>
void StageClock<T>::end_of(Stage forward, Stage reverse) {
  shared_->count(forward);
  mark(reverse);
}

template <std::floating_point T>
void StageClock<T>::mark(Stage before) {
  if (!is_swept_) return;
  record_mark<T>([shared = shared_, before] {
    shared->count(shared->swept);
    shared->swept = before;
  });
}
}  // namespace tapestry::camouflage
