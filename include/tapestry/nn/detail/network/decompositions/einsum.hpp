#pragma once
#include <tapestry/nn/detail/network/decomposition.hpp>

namespace tapestry::nn::detail {
/// The axes of an operand or of the result of Einsum, a letter each. Axes of an ellipsis are called 0, 1, …
/// from its last, so that shorter ones meet the end of longer ones.
using Subscripts = std::vector<char>;

/// An equation such as "bij,bjk->bik".
struct EinsumEquation {
  std::vector<Subscripts> operands{};
  Subscripts result{};
};

/// Reads an equation.
class EinsumParser {
 public:
  /// \param ranks  of the operands
  /// \throws DomainError for a text that is no equation or does not fit the operands
  EinsumParser(std::string text, const std::vector<std::size_t>& ranks) : text_(std::move(text)) {
    std::erase(text_, ' ');
    const std::size_t arrow = text_.find("->");
    std::vector<std::string> terms{""};
    for (const char c : text_.substr(0, arrow))
      if (c == ',')
        terms.emplace_back();
      else
        terms.back() += c;
    if (terms.size() != ranks.size())
      refuse(" has " + std::to_string(terms.size()) + " operands, expected " + std::to_string(ranks.size()));
    for (std::size_t i = 0; i < terms.size(); ++i) add_operand(i, terms[i], ranks[i]);
    if (arrow != std::string::npos)
      equation_.result = expanded(text_.substr(arrow + 2), longest_);
    else
      imply_result();
    check_result();
  }

  [[nodiscard]] EinsumEquation take() { return std::move(equation_); }

 private:
  [[noreturn]] void refuse(const std::string& reason) const {
    throw DomainError({"the equation ", in_quotes(text_), reason});
  }

  /// The axes of a term whose ellipsis stands for `covered`.
  [[nodiscard]] Subscripts expanded(const std::string& term, std::size_t covered) const {
    Subscripts axes;
    bool has_dots = false;
    for (std::size_t i = 0; i < term.size(); ++i) {
      if (term.compare(i, 3, "...") == 0 && !has_dots) {
        for (std::size_t k = covered; k-- > 0;) axes.push_back(static_cast<char>('0' + k));
        has_dots = true;
        i += 2;
      } else if ((term[i] >= 'a' && term[i] <= 'z') || (term[i] >= 'A' && term[i] <= 'Z')) {
        axes.push_back(term[i]);
      } else {
        refuse(" has an unknown letter " + in_quotes(term.substr(i, 1)));
      }
    }
    return axes;
  }

  void add_operand(std::size_t i, const std::string& term, std::size_t rank) {
    constexpr std::size_t most = 10;  // axes of an ellipsis
    const bool has_dots = term.find("...") != std::string::npos;
    const std::size_t letters = term.size() - (has_dots ? 3 : 0);
    if (has_dots ? letters > rank : letters != rank)
      refuse(" names " + std::to_string(letters) + " axes of operand " + std::to_string(i) + ", which has " +
             std::to_string(rank));
    const std::size_t covered = has_dots ? rank - letters : 0;
    if (covered > most) refuse(" has an ellipsis of more than 10 axes");
    longest_ = std::max(longest_, covered);
    equation_.operands.push_back(expanded(term, covered));
  }

  /// All axes of the ellipsis, then the letters that are there once, in order.
  void imply_result() {
    std::map<char, int> counts;
    for (const auto& operand : equation_.operands)
      for (const char axis : operand) ++counts[axis];
    for (std::size_t k = longest_; k-- > 0;) equation_.result.push_back(static_cast<char>('0' + k));
    for (const auto& [axis, count] : counts)
      if (count == 1 && axis > '9') equation_.result.push_back(axis);
  }

  void check_result() const {
    for (const char axis : equation_.result) {
      const auto has = [&](const Subscripts& operand) {
        return std::ranges::find(operand, axis) != operand.end();
      };
      if (std::ranges::none_of(equation_.operands, has))
        refuse(" has a letter in its result alone, " + in_quotes(std::string(1, axis)));
      if (std::ranges::count(equation_.result, axis) > 1)
        refuse(" has a letter twice in its result, " + in_quotes(std::string(1, axis)));
    }
  }

  std::string text_;
  std::size_t longest_ = 0;  ///< axes of an ellipsis
  EinsumEquation equation_{};
};

/// Einsum as transpositions and products of matrices, two operands at a time from the left.
class EinsumParts {
 public:
  EinsumParts(const OperatorContext& context, EinsumEquation equation, Decomposer& parts)
      : equation_(std::move(equation)), parts_(parts) {
    for (std::size_t i = 0; i < equation_.operands.size(); ++i) {
      const Shape& shape = context.input(i).shape;
      for (std::size_t axis = 0; axis < shape.size(); ++axis) {
        std::size_t& extent = extents_.try_emplace(equation_.operands[i][axis], 1).first->second;
        if (extent != shape[axis] && extent != 1 && shape[axis] != 1)
          throw ShapeError({"axis ", std::string(1, equation_.operands[i][axis]), " has extents ", extent,
                            " and ", shape[axis]});
        if (extent == 1) extent = shape[axis];
      }
    }
  }

  void write(const OperatorContext& context) {
    Term all = term(context, 0);
    for (std::size_t i = 1; i < equation_.operands.size(); ++i) all = product(all, term(context, i), i + 1);
    all = without_unused(std::move(all), equation_.operands.size());
    std::vector<std::size_t> order;
    for (const char axis : equation_.result)
      order.push_back(static_cast<std::size_t>(std::ranges::find(all.axes, axis) - all.axes.begin()));
    parts_.finish(0, "Transpose", {all.value},
                  {{"perm", std::vector<std::int64_t>(order.begin(), order.end())}});
  }

 private:
  struct Term {
    std::string value;
    Subscripts axes;  ///< each letter once, of its extents
  };

  [[nodiscard]] static bool has(const Subscripts& axes, char axis) {
    return std::ranges::find(axes, axis) != axes.end();
  }
  /// Whether the result or an operand from `first` on has an axis.
  [[nodiscard]] bool is_used(char axis, std::size_t first) const {
    if (has(equation_.result, axis)) return true;
    for (std::size_t i = first; i < equation_.operands.size(); ++i)
      if (has(equation_.operands[i], axis)) return true;
    return false;
  }
  [[nodiscard]] Shape shape_of(const Subscripts& axes) const {
    Shape shape;
    for (const char axis : axes) shape.push_back(extents_.at(axis));
    return shape;
  }

  /// An operand with each axis once, expanded to the letters' extents, without axes of this operand alone.
  [[nodiscard]] Term term(const OperatorContext& context, std::size_t i) {
    Term own{parts_.input(i), equation_.operands[i]};
    const Shape shape = shape_of(own.axes);
    if (shape != context.input(i).shape)
      own.value = parts_.add("Expand", {own.value, parts_.integers({shape.begin(), shape.end()})});
    for (std::size_t a = 0; a < own.axes.size(); ++a)
      while (std::ranges::count(own.axes, own.axes[a]) > 1) own = diagonal(own, own.axes[a]);
    Subscripts unused;
    for (const char axis : own.axes) {
      bool elsewhere = has(equation_.result, axis);
      for (std::size_t k = 0; k < equation_.operands.size(); ++k)
        elsewhere = elsewhere || (k != i && has(equation_.operands[k], axis));
      if (!elsewhere) unused.push_back(axis);
    }
    return summed(std::move(own), unused);
  }

  /// The first two axes of a letter as one.
  [[nodiscard]] Term diagonal(const Term& from, char letter) {
    std::vector<std::size_t> order, both;
    for (std::size_t a = 0; a < from.axes.size(); ++a)
      (from.axes[a] == letter && both.size() < 2 ? both : order).push_back(a);
    Subscripts rest;
    for (const std::size_t a : order) rest.push_back(from.axes[a]);
    order.insert(order.end(), both.begin(), both.end());
    const std::size_t extent = extents_.at(letter);
    Shape flat = shape_of(rest);
    flat.push_back(extent * extent);
    std::vector<std::int64_t> places;
    for (std::size_t k = 0; k < extent; ++k) places.push_back(static_cast<std::int64_t>(k * (extent + 1)));
    const std::string value = parts_.reshaped(parts_.transposed(from.value, order), flat);
    rest.push_back(letter);
    return {parts_.add("Gather", {value, parts_.integers(places)},
                       {{"axis", static_cast<std::int64_t>(rest.size() - 1)}}),
            rest};
  }

  [[nodiscard]] Term summed(Term from, const Subscripts& gone) {
    if (gone.empty()) return from;
    std::vector<std::int64_t> places;
    Subscripts rest;
    for (std::size_t a = 0; a < from.axes.size(); ++a)
      if (has(gone, from.axes[a]))
        places.push_back(static_cast<std::int64_t>(a));
      else
        rest.push_back(from.axes[a]);
    return {parts_.reduced("ReduceSum", from.value, places, false), rest};
  }

  [[nodiscard]] Term without_unused(Term from, std::size_t next) {
    Subscripts unused;
    for (const char axis : from.axes)
      if (!is_used(axis, next)) unused.push_back(axis);
    return summed(std::move(from), unused);
  }

  /// A term with its axes in the order of several groups, each as one axis.
  [[nodiscard]] std::string grouped(const Term& from, const std::vector<Subscripts>& groups) {
    std::vector<std::size_t> order;
    Shape shape;
    for (const Subscripts& group : groups) {
      for (const char axis : group)
        order.push_back(static_cast<std::size_t>(std::ranges::find(from.axes, axis) - from.axes.begin()));
      shape.push_back(size_of(shape_of(group)));
    }
    return parts_.reshaped(parts_.transposed(from.value, order), shape);
  }

  /// \param next  the first operand that is still to come
  [[nodiscard]] Term product(const Term& a, const Term& b, std::size_t next) {
    Subscripts batch, summed_axes, of_a, of_b;
    for (const char axis : a.axes)
      (!has(b.axes, axis) ? of_a : is_used(axis, next) ? batch : summed_axes).push_back(axis);
    for (const char axis : b.axes)
      if (!has(a.axes, axis)) of_b.push_back(axis);
    Subscripts axes = batch;
    axes.insert(axes.end(), of_a.begin(), of_a.end());
    axes.insert(axes.end(), of_b.begin(), of_b.end());
    std::string value;
    if (summed_axes.empty()) {
      value =
          parts_.add("Mul", {parts_.reshaped(grouped(a, {batch, of_a}), grouped_shape({batch, of_a}, 2)),
                             parts_.reshaped(grouped(b, {batch, of_b}), grouped_shape({batch, of_b}, 1))});
    } else {
      value = parts_.add("MatMul",
                         {grouped(a, {batch, of_a, summed_axes}), grouped(b, {batch, summed_axes, of_b})});
    }
    return {parts_.reshaped(value, shape_of(axes)), axes};
  }

  /// Extents of two groups, with an axis of extent 1 at a place.
  [[nodiscard]] Shape grouped_shape(const std::vector<Subscripts>& groups, std::size_t one) const {
    Shape shape;
    for (const Subscripts& group : groups) shape.push_back(size_of(shape_of(group)));
    shape.insert(shape.begin() + static_cast<std::ptrdiff_t>(one), 1);
    return shape;
  }

  EinsumEquation equation_;
  Decomposer& parts_;
  std::map<char, std::size_t> extents_{};
};

/// Einsum. Source: onnx.ai, Operators.md; NumPy's einsum.
inline void decompose_einsum(OperatorContext& context, Decomposer& parts) {
  std::vector<std::size_t> ranks;
  for (std::size_t i = 0; i < context.inputs.size(); ++i) ranks.push_back(context.input(i).shape.size());
  EinsumParts(context, EinsumParser(context.text("equation", ""), ranks).take(), parts).write(context);
}
}  // namespace tapestry::nn::detail
