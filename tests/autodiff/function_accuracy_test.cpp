#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "function_rows.hpp"

using tapestry::Variable, tapestry::test::ActiveTape, tapestry::test::ulps, tapestry::test::Wide;

namespace {
constexpr double infinity = std::numeric_limits<double>::infinity();

/// Powers of ten over the range of doubles, and points between −limit and limit.
std::vector<double> points(double low, double high) {
  std::vector<double> all;
  for (int k = 0; k <= 2000; ++k) all.push_back(low + (high - low) * (k + 0.375) / 2001);
  for (double size = 1e-307; size < 1e308; size *= 31.7)
    for (const double x : {-size, size})
      if (x > low && x < high) all.push_back(x);
  return all;
}

template <class Function>
double slope_on_tape(const Function& f, double x) {
  ActiveTape<double> tape;
  const Variable<double> input = tape.input(x);
  tape.reverse(Variable<double>(f(input)));
  return input.adjoint();
}

/// The worst distance of the tape's derivative from the reference, which must be within 4 ulp.
template <class Function, class Reference>
void check_ulps(const char* name, const Function& f, const Reference& reference,
                const std::vector<double>& at) {
  double worst = 0, worst_at = 0;
  for (const double x : at) {
    const double error = ulps(slope_on_tape(f, x), reference(static_cast<Wide>(x)));
    if (!(error <= worst)) worst = error, worst_at = x;
  }
  INFO(name << " at " << worst_at);
  CHECK(worst <= 4);
}

struct Entry {
  double x;
  Wide expected;
};
}  // namespace

TEST_CASE("derivatives of functions of one number are within 4 ulp over their range",
          "[autodiff][accuracy]") {
  tapestry::test::for_each_function([](const tapestry::test::FunctionRow& row, const auto& f) {
    if (row.slope == nullptr) return;
    for (const double bound : {infinity, 10.0})
      check_ulps(row.name, f, row.slope, points(std::max(row.low, -bound), std::min(row.high, bound)));
  });
}

TEST_CASE("derivatives of functions of two numbers are within 4 ulp over their range",
          "[autodiff][accuracy]") {
  for (const double y : {-600.123, -3.7, 0.1, 2.5, 650.777}) {
    check_ulps(
        "logsumexp", [=](auto x) { return logsumexp(x, y); },
        [=](Wide x) { return 1 / (1 + std::exp(static_cast<Wide>(y) - x)); }, points(y - 740, y + 740));
  }
  for (const double y : {-3.0, 0.7, 1e10}) {
    const auto wide = static_cast<Wide>(y);
    check_ulps(
        "atan2 by y", [=](auto x) { return atan2(x, y); },
        [=](Wide x) { return wide / (x * x + wide * wide); }, points(-1e100, 1e100));
    check_ulps(
        "atan2 by x", [=](auto x) { return atan2(y, x); },
        [=](Wide x) { return -wide / (x * x + wide * wide); }, points(-20, 20));
  }
  for (const double y : {-2.5, -1.0, 0.5, 1.0, 2.0, 3.0, 10.25, 100.0}) {
    const auto wide = static_cast<Wide>(y);
    check_ulps(
        "pow by x", [=](auto x) { return pow(x, y); }, [=](Wide x) { return wide * std::pow(x, wide - 1); },
        points(0, 1e3));
    check_ulps(
        "pow by y", [=](auto x) { return pow(std::abs(y), x); },
        [=](Wide x) { return std::pow(std::abs(wide), x) * std::log(std::abs(wide)); }, points(-100, 100));
  }
  for (const double y : {-3.0, 1e-8, 1e200})
    check_ulps(
        "hypot", [=](auto x) { return hypot(x, y); },
        [=](Wide x) { return x / std::sqrt(x * x + static_cast<Wide>(y) * static_cast<Wide>(y)); },
        points(-1e150, 1e150));
}

TEST_CASE("derivatives of lengths, fma, fmod and remainder are within 4 ulp over their range",
          "[autodiff][accuracy]") {
  for (const double y : {-3e5, 0.7, 1e150}) {
    const auto wide = static_cast<Wide>(y);
    const auto length = [=](Wide x, Wide z) { return std::hypot(std::hypot(x, wide), z); };
    check_ulps(
        "hypot", [=](auto x) { return hypot(x, y); }, [=](Wide x) { return x / std::hypot(x, wide); },
        points(-1e300, 1e300));
    check_ulps(
        "hypot of three", [=](auto x) { return hypot(y, x, 2.5); },
        [=](Wide x) { return x / length(x, 2.5L); }, points(-1e300, 1e300));
    check_ulps(
        "hypot of three, twice", [=](auto x) { return hypot(x, y, x); },
        [=](Wide x) { return 2 * x / length(x, x); }, points(-1e300, 1e300));
    check_ulps(
        "fma by a factor", [=](auto x) { return fma(x, y, 3.0); }, [=](Wide) { return wide; },
        points(-1e150, 1e150));
    check_ulps(
        "fma by the summand", [=](auto x) { return fma(y, 3.0, x); }, [=](Wide) { return 1; },
        points(-1e150, 1e150));
    check_ulps(
        "fmod by x", [=](auto x) { return fmod(x, y); }, [](Wide) { return 1; }, points(-1e10, 1e10));
  }
  // The quotient of long doubles is right as long as it has at most 64 bits and no jump within a rounding.
  check_ulps(
      "fmod by y", [](auto y) { return fmod(1e6, y); }, [](Wide y) { return -std::trunc(1e6L / y); },
      points(0.1, 1e5));
  check_ulps(
      "remainder by y", [](auto y) { return remainder(1e6, y); }, [](Wide y) { return -std::rint(1e6L / y); },
      points(0.1, 1e5));
}

TEST_CASE("digamma is within 1 ulp of 22 digits", "[autodiff][accuracy]") {
  const std::vector<Entry> table = {
      {1e-300, -9.999999999999999749409e+299L}, {1e-20, -100000000000000005485.3L},
      {1e-08, -100000000.5772156463599L},       {0.001, -1000.575571931810279655L},
      {0.1, -10.4237549404110762321L},          {0.5, -1.963510026021423479441L},
      {0.9999, -0.5773801703298691236638L},     {1.0, -0.5772156649015328606065L},
      {1.25, -0.2274535333762654080895L},       {1.46, -0.001580561987083452106151L},
      {1.5, 0.03648997397857652055902L},        {1.9999, 0.4227198396711309653306L},
      {2.0, 0.4227843350984671393935L},         {2.01, 0.4292135520323154649092L},
      {3.7, 1.167153539361511440948L},          {8.0, 2.015641477955609996536L},
      {11.99, 2.441792283668334885148L},        {12.5, 2.48519565127491204815L},
      {30.0, 3.384438132685524876562L},         {170.3, 5.134622719020003808589L},
      {100000.0, 11.51292046496189508676L},     {1000000000000000.0, 34.53877639491068476027L},
      {1e+300, 690.7755278982137052579L},       {-1e-300, 9.999999999999999749409e+299L},
      {-1e-08, 99999999.42278431655687L},       {-0.25, 2.914139120213527830373L},
      {-0.5, 0.03648997397857652055902L},       {-0.504083008264455, 4.042965717222496339214e-15L},
      {-0.75, -2.894120200042932074756L},       {-1.5, 0.7031566406452431872257L},
      {-2.6, 0.1148975066969341955897L},        {-7.3, 4.337307305510050142181L},
      {-20.5, 3.044616882512524630889L},        {-100.25, 7.754238959208645448412L},
      {-1000.125, 14.49285571711376346529L},
  };
  for (const auto& [x, expected] : table) {
    INFO("at " << x);
    CHECK(ulps(tapestry::digamma(x), expected) <= 1);
    CHECK(slope_on_tape([](auto v) { return lgamma(v); }, x) == tapestry::digamma(x));
  }
}

TEST_CASE("digamma and the slopes of lgamma and tgamma keep their digits at digamma's roots",
          "[autodiff][accuracy]") {
  // The doubles nearest to the first 20 negative roots, others beside four of them, and the positive root.
  const std::vector<Entry> table = {
      {-0.5040830082644554, 7.289763902976894944462e-17L},
      {-1.5734984731623904, 1.564978848183845336723e-16L},
      {-2.6107208684441447, -1.072027593641000207125e-15L},
      {-3.635293366436901, -6.354883894064686250493e-16L},
      {-4.653237761743142, 3.153352998238749258284e-15L},
      {-5.6671624415568855, 4.186779446452480087747e-17L},
      {-6.678418213073427, -4.726829380455339912844e-15L},
      {-7.687788325031626, 1.915345249870863275507e-15L},
      {-8.695764163816401, 4.825794938582724147603e-15L},
      {-9.702672540001863, 4.939256869086382196531e-15L},
      {-10.708740838254144, 9.822169913611686569156e-15L},
      {-11.714133061228955, -1.38020396053513735347e-14L},
      {-12.718971025749207, 7.822379332320526256336e-15L},
      {-13.723347457363827, -7.629620868307767682964e-15L},
      {-14.727334416018529, 6.305749002764492970392e-16L},
      {-15.730988906332882, -1.854593944673241731514e-15L},
      {-16.734356723955734, 2.157149132755980290015e-14L},
      {-17.73747515997759, 9.352337929775358959597e-15L},
      {-18.7403749447801, -1.439932904725137240677e-14L},
      {-19.74308167259022, -1.227475057036058162304e-14L},
      {-0.5050530082644554, -0.008672395559256440047134L},
      {-0.5040930082644554, -0.00008939806655424644664116L},
      {-0.5040830092644554, -8.939798233869070766764e-9L},
      {-0.5040827082644554, 0.000002681939494451179805381L},
      {-0.5030930082644554, 0.008849638631646847093343L},
      {-1.5744684731623904, -0.009650646143339529898211L},
      {-1.5735084731623905, -0.00009941591645904649402025L},
      {-1.5734984741623905, -9.941514289793410915673e-9L},
      {-1.5734981731623905, 0.00000298245338223526824455L},
      {-1.5725084731623904, 0.009834489831421831120214L},
      {-7.688758325031626, -0.01377459424963670302482L},
      {-7.687798325031626, -0.000141716413453758123922L},
      {-7.687788326031626, -1.417133992050793497704e-8L},
      {-7.687788025031626, 0.000004251399484921043387488L},
      {-7.686798325031626, 0.01400026222406583420996L},
      {-19.744051672590217, -0.01835548614400403544277L},
      {-19.743091672590218, -0.000188683348920814210342L},
      {-19.74308167359022, -1.886777973691025871704e-8L},
      {-19.74308137259022, 0.000005660324618869469944486L},
      {-19.742091672590217, 0.01862354374002307986226L},
      {1.4616321449683622, -9.241265521729427516792e-17L},
      {1.4616321449683625, 1.224537462200406903132e-16L},
  };
  for (const auto& [x, expected] : table) {
    INFO("at " << x);
    CHECK(ulps(tapestry::digamma(x), expected) <= 1);
    CHECK(slope_on_tape([](auto v) { return lgamma(v); }, x) == tapestry::digamma(x));
    const Wide by_gamma = std::tgamma(static_cast<Wide>(x)) * expected;
    CHECK(ulps(slope_on_tape([](auto v) { return tgamma(v); }, x), by_gamma) <= 4);
  }
}

TEST_CASE("polygamma functions and the slope of the gamma function are within 4 ulp of 22 digits",
          "[autodiff][accuracy]") {
  struct Row {
    double x;
    Wide first, second, third;
  };
  const Row rows[] = {
      {1e-08, 10000000000000001.22648L, -1.999999999999999874465e+24L, 5.999999999999999497859e+32L},
      {0.1, 101.4332991507927477047L, -2001.861457378343673222L, 60004.51287679025338427L},
      {0.5, 4.934802200544679309417L, -16.8287966442343199956L, 97.40909103400243723644L},
      {1.0, 1.644934066848226436472L, -2.404113806319188570799L, 6.493939402266829149096L},
      {1.5, 0.9348022005446793094172L, -0.8287966442343199955963L, 1.40909103400243723644L},
      {2.0, 0.6449340668482264364724L, -0.4041138063191885707995L, 0.493939402266829149096L},
      {5.5, 0.1993423869896276591275L, -0.03960894752130204297143L, 0.01569059267588281914697L},
      {17.0, 0.06058753340323936178171L, -0.003669728873958962154187L, 0.0004444085253892188298988L},
      {40.0, 0.0253151038412910281576L, -0.0006408202718352985877564L, 0.00003244140015156350032188L},
      {1000000.0, 0.000001000000500000166666667L, -1.0000010000005e-12L, 2.000003000002e-18L},
      {-0.25, 18.5418796476716064984L, 122.6973667836623603686L, 1555.76331253485059976L},
      {-0.5, 8.934802200544679309417L, -0.8287966442343199955963L, 193.4090910340024372364L},
      {-1.25, 19.1818796476716064984L, 123.7213667836623603686L, 1558.22091253485059976L},
      {-3.75, 19.50498006059957527329L, -124.0797271337892540456L, 1558.520092024034342015L},
      {-20.5, 9.821994344649879482074L, -0.002266289919637796934179L, 194.8179663529729690866L},
  };
  for (const Row& row : rows) {
    INFO("at " << row.x);
    CHECK(ulps(tapestry::polygamma<1>(row.x), row.first) <= 4);
    CHECK(ulps(tapestry::polygamma<2>(row.x), row.second) <= 4);
    CHECK(ulps(tapestry::polygamma<3>(row.x), row.third) <= 4);
  }
  const std::vector<Entry> gamma_slopes = {
      {1e-08, -9999999999999998.592493L},     {0.1, -99.1664728746369960628L},
      {0.5, -3.480230906913262026939L},       {1.0, -0.5772156649015328606065L},
      {1.25, -0.2061644460672675963103L},     {1.4616321449683622, -8.184094266442788991818e-17L},
      {2.0, 0.4227843350984671393935L},       {3.7, 4.867790990902607585949L},
      {11.99, 95116963.55431938366878L},      {30.0, 2.992439645174224037662e+31L},
      {120.5, 2.920512946777671497184e+198L}, {170.3, 1.022605071830095285012e+306L},
      {-0.25, -14.2841390048673407328L},      {-1.5, 1.661750260668596505586L},
      {-2.6, -0.1021077728500670993079L},     {-7.3, 0.001814676778158472991014L},
      {-20.5, -8.630443262516978338468e-19L},
  };
  for (const auto& [x, expected] : gamma_slopes) {
    INFO("at " << x);
    CHECK(ulps(slope_on_tape([](auto v) { return tgamma(v); }, x), expected) <= 4);
  }
}

TEST_CASE("special values of functions and their derivatives", "[autodiff][accuracy]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto check = [](const char* name, auto f, std::initializer_list<std::pair<double, double>> table) {
    for (const auto& [x, expected] : table) {
      const double found = slope_on_tape(f, x);
      INFO(name << " at " << x << ": " << found);
      CHECK((std::isnan(expected) ? std::isnan(found) : found == expected));
    }
  };
  check("exp", [](auto x) { return exp(x); }, {{0, 1}, {-infinity, 0}, {infinity, infinity}});
  check("log", [](auto x) { return log(x); }, {{0, infinity}, {infinity, 0}, {1, 1}});
  check("log1p", [](auto x) { return log1p(x); }, {{-1, infinity}, {0, 1}, {infinity, 0}});
  check("sqrt", [](auto x) { return sqrt(x); }, {{0, infinity}, {infinity, 0}, {-1, nan}});
  check("cbrt", [](auto x) { return cbrt(x); }, {{0, infinity}, {8, 1.0 / 12}, {-infinity, 0}});
  check("asin", [](auto x) { return asin(x); }, {{1, infinity}, {-1, infinity}, {0, 1}, {2, nan}});
  check("acos", [](auto x) { return acos(x); }, {{1, -infinity}, {-1, -infinity}, {0, -1}});
  check("atan", [](auto x) { return atan(x); }, {{infinity, 0}, {-infinity, 0}, {0, 1}});
  check("tanh", [](auto x) { return tanh(x); }, {{infinity, 0}, {-infinity, 0}, {0, 1}});
  check("atanh", [](auto x) { return atanh(x); }, {{1, infinity}, {-1, infinity}, {0, 1}});
  check("acosh", [](auto x) { return acosh(x); }, {{1, infinity}, {infinity, 0}});
  check("asinh", [](auto x) { return asinh(x); }, {{0, 1}, {infinity, 0}});
  check("erf", [](auto x) { return erf(x); }, {{infinity, 0}, {-infinity, 0}});
  check("sigmoid", [](auto x) { return sigmoid(x); }, {{infinity, 0}, {-infinity, 0}, {0, 0.25}});
  check("softplus", [](auto x) { return softplus(x); }, {{infinity, 1}, {-infinity, 0}, {0, 0.5}});
  check("lgamma", [](auto x) { return lgamma(x); },
        {{0, -infinity}, {-0.0, infinity}, {-1, nan}, {infinity, infinity}, {nan, nan}});
  check("abs", [](auto x) { return abs(x); }, {{0, 0}, {-0.0, 0}, {-infinity, -1}, {infinity, 1}});
  check("digamma", [](auto x) { return digamma(x); }, {{0, infinity}, {infinity, 0}});
}
