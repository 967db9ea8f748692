// The curvature of an adversarial loss by the paint on a car: its largest eigenvalues by Lanczos' method,
// from Hessian products through detector and renderer alone, and Newton's method by conjugate gradients
// beside gradient descent at equal cost. Takes an .onnx or a .weights file, the latter with its .cfg beside
// it.
#include <Eigen/Eigenvalues>
#include <tapestry/autodiff/array_derivatives.hpp>
#include <tapestry/detect/detector_variable.hpp>
#include <tapestry/image/over.hpp>
#include <tapestry/io/frame_file.hpp>
#include <tapestry/io/obj_file.hpp>
#include <tapestry/io/read_detector.hpp>
#include <tapestry/loss/adversarial.hpp>
#include <tapestry/optim/adam.hpp>
#include <tapestry/raster/painted.hpp>

using namespace tapestry;

namespace {
using Texels = Array<float, 2>;

double dot(const Texels& a, const Texels& b) { return xt::sum(xt::cast<double>(a) * b)(); }
void add(Texels& to, double factor, const Texels& from) { to += static_cast<float>(factor) * from; }
void scale(Texels& x, double factor) { x *= static_cast<float>(factor); }

/// Extreme eigenvalues of a symmetric operator, ascending, from `steps` products. \param start  not zero
template <class Product>
Eigen::VectorXd lanczos(const Product& product, Texels start, int steps) {
  std::vector<Texels> basis;
  std::vector<double> diagonal, beside;
  for (int i = 0; i < steps; ++i) {
    scale(start, 1 / std::sqrt(dot(start, start)));
    basis.push_back(start);
    start = product(basis.back());
    diagonal.push_back(dot(start, basis.back()));
    for (int twice = 0; twice < 2; ++twice)
      for (const Texels& before : basis) add(start, -dot(start, before), before);
    beside.push_back(std::sqrt(dot(start, start)));
    if (beside.back() < 1e-6 * std::abs(diagonal.front())) break;  // the basis is whole
  }
  const auto n = static_cast<Eigen::Index>(diagonal.size());
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
  solver.computeFromTridiagonal(Eigen::Map<Eigen::VectorXd>(diagonal.data(), n),
                                Eigen::Map<Eigen::VectorXd>(beside.data(), n - 1), Eigen::EigenvaluesOnly);
  return solver.eigenvalues();
}

/// About (H + damping)⁻¹·gradient, from a few products; a shorter step where the loss curves down.
template <class Product>
Texels newton_step(const Product& product, const Texels& gradient, double damping, int products) {
  Texels step = zeros<float, 2>(gradient.shape()), residual = gradient, direction = gradient;
  for (int i = 0; i < products; ++i) {
    Texels along = product(direction);
    add(along, damping, direction);
    const double curvature = dot(direction, along), before = dot(residual, residual);
    if (curvature <= 0 || before == 0) break;
    add(step, before / curvature, direction);
    add(residual, -before / curvature, along);
    scale(direction, dot(residual, residual) / before);
    add(direction, 1, residual);
  }
  return dot(step, step) > 0 ? step : gradient;
}
/// The loss of a car in a photograph by its paint, on a tape of numbers or of duals.
struct LossOfPaint {
  detect::Detector<float> detector;
  raster::PaintedMesh car;
  std::vector<std::shared_ptr<const raster::CompactOperator<float>>> views{};
  std::vector<image::Backdrop<float>> backdrops{};
  std::vector<loss::Target> targets{};
  LossOfPaint(const std::filesystem::path& weights, const std::string& assets)
      : detector(io::read_detector<float>(
            {.weights = weights,
             .config = io::is_onnx(weights) ? "" : std::filesystem::path(weights).replace_extension("cfg")})),
        car(raster::painted(io::read_obj(assets + "car_sedan.obj").mesh, {.material = "body"})) {
    const auto frame = io::read_frame(assets + "frames/test/027.npz");
    views.push_back(std::make_shared<const raster::CompactOperator<float>>(raster::compacted(
        raster::texture_operator<float>(car, *frame.camera, detector.input_height(), detector.input_width(),
                                        io::frame_light(frame, car.space)))));
    backdrops.emplace_back(image::from_bytes<float>(frame.image), views[0]);
    targets.push_back({frame.label->class_index, frame.label->box});
  }
  template <class Paint>
  auto operator()(const Paint& paint) const {
    const Paint colours = (tanh(paint) + 1.0F) / 2.0F;
    const auto drawn = raster::render(views, image::linearised(colours));
    const auto logits = detect::forward(detector, image::over(drawn, backdrops, car.space));
    const auto kind = loss::AdversarialLoss::max_score;
    return loss::adversarial(detector, logits, std::span(targets), kind).total;
  }
};

Texels product_of(const LossOfPaint& loss, const Texels& at, const Texels& along) {
  return std::get<0>(hessian_product(loss, at, along).product);
}
Texels gradient_of(const LossOfPaint& loss, const Texels& at) {
  Tape<float> tape;
  const auto scope = tape.activate();
  const auto input = tape.input(at);
  tape.reverse(loss(input));
  return input.adjoint();
}
}  // namespace
int main(int argc, char** argv) {
  const std::string assets = TAPESTRY_ASSETS "/";
  const LossOfPaint loss(argc > 1 ? argv[1] : assets + "detector.weights", assets);
  const auto loss_at = [&](const Texels& at) {
    return static_cast<double>(loss(ArrayVariable<float, 2>(at)).value());
  };
  const auto paint = zeros<float, 2>({loss.car.layout.texel_count(loss.car.mesh), 3});  // mid grey
  const auto eigenvalues =
      lanczos([&](const Texels& v) { return product_of(loss, paint, v); }, gradient_of(loss, paint), 24);
  std::printf("loss %.4f, largest eigenvalues", loss_at(paint));
  for (Eigen::Index i = 1; i <= std::min<Eigen::Index>(5, eigenvalues.size()); ++i)
    std::printf(" %.3g", eigenvalues[eigenvalues.size() - i]);
  std::printf(", smallest %.3g\n", eigenvalues[0]);
  constexpr int newton_steps = 6, products = 8, gradients = newton_steps * (2 * products + 1);
  Texels by_newton = paint, by_adam = paint;  // a product costs about two gradients
  for (int i = 0; i < newton_steps; ++i)
    add(by_newton, -1,
        newton_step([&](const Texels& v) { return product_of(loss, by_newton, v); },
                    gradient_of(loss, by_newton), 0.05 * eigenvalues[eigenvalues.size() - 1], products));
  optim::Adam<float> adam(by_adam.size(), {});
  for (int i = 0; i < gradients; ++i) adam.step(by_adam, gradient_of(loss, by_adam));
  std::printf("loss after the cost of %d gradients: Newton %.4f, Adam %.4f\n", gradients, loss_at(by_newton),
              loss_at(by_adam));
}
