// Monotone curves through points: closed properties.
#include "models/scene_file/curve.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/check.h"
#include "tests/support/random.h"

namespace feder {
namespace {

Curve sampled(double (*f)(double), double from, double to, int pieces) {
  std::vector<double> x, y;
  for (int i = 0; i <= pieces; ++i) {
    x.push_back(from + (to - from) * i / pieces);
    y.push_back(f(x.back()));
  }
  return {"curve", x, y};
}

struct Points {
  std::vector<double> x, y;
};

Points random_points(Random& random, bool rising) {
  Points out{{random.uniform()}, {random.uniform()}};
  for (int count = 1 + random.below(12); count > 0; --count) {
    out.x.push_back(out.x.back() + std::pow(10.0, random.uniform(-2.0, 1.0)));
    const double step = random.below(4) == 0 ? 0.0 : std::pow(10.0, random.uniform(-3.0, 2.0));
    out.y.push_back(out.y.back() + (rising || random.below(2) == 0 ? step : -step));
  }
  return out;
}

TEST(Curve, GoesThroughItsPointsWithOneSlope) {
  Random random(1);
  for (int i = 0; i < 500; ++i) {
    const auto [x, y] = random_points(random, false);
    const Curve curve("curve", x, y);
    for (std::size_t k = 0; k < x.size(); ++k) {
      const Jet before = curve.at(std::nextafter(x[k], -1e9)), at = curve.at(x[k]),
                after = curve.at(std::nextafter(x[k], 1e9));
      EXPECT_EQ(at.value, y[k]);
      // one place of rounding away: slope times a step, and the cancellation of the cubic
      const double tiny =
          1e-11 * (1.0 + std::abs(at.first)) * (1.0 + std::abs(before.second) + std::abs(after.second));
      EXPECT_NEAR(before.value, at.value, tiny);
      EXPECT_NEAR(after.value, at.value, tiny);
      EXPECT_NEAR(before.first, at.first, tiny);
      EXPECT_NEAR(after.first, at.first, tiny);
    }
  }
}

TEST(Curve, RisesWhereItsPointsDo) {
  Random random(2);
  int bent = 0;
  for (int i = 0; i < 500; ++i) {
    const auto [x, y] = random_points(random, true);
    const Curve curve("curve", x, y);
    for (std::size_t k = 0; k + 1 < x.size(); ++k)
      for (int j = 0; j <= 50; ++j) {
        const Jet at = curve.at(x[k] + (x[k + 1] - x[k]) * j / 50);
        EXPECT_GE(at.first, -1e-12 * (y[k + 1] - y[k]) / (x[k + 1] - x[k]));
        EXPECT_GE(at.value, y[k] - 1e-13 * (1.0 + std::abs(y[k])));
        EXPECT_LE(at.value, y[k + 1] + 1e-13 * (1.0 + std::abs(y[k + 1])));
        bent += std::abs(at.second) > 1.0;
      }
  }
  EXPECT_GT(bent, 1000);
}

TEST(Curve, HasTheSlopesOfFritschAndButland) {
  const Curve curve("curve", {0.0, 1.0, 3.0}, {0.0, 1.0, 7.0});
  EXPECT_NEAR(curve.at(0.0).first, 1.0 / 3.0, 1e-15);
  EXPECT_NEAR(curve.at(1.0).first, 27.0 / 19.0, 1e-15);  // 9/(5/1 + 4/3)
  EXPECT_NEAR(curve.at(3.0).first, 13.0 / 3.0, 2e-15);
}

TEST(Curve, IsExactOnLinesAndBeyondItsEnds) {
  const std::vector<double> x = {-1.0, 0.25, 0.5, 2.0, 7.0};
  std::vector<double> y;
  for (const double at : x) y.push_back(3.0 - 0.5 * at);
  const Curve line("line", x, y), two("two", {0.0, 2.0}, {1.0, 5.0});
  for (double at = -20.0; at < 20.0; at += 0.37) {
    EXPECT_NEAR(line.at(at).value, 3.0 - 0.5 * at, 4e-15);
    EXPECT_EQ(line.at(at).first, -0.5);
    EXPECT_EQ(line.at(at).second, 0.0);
    EXPECT_NEAR(two.at(at).value, 1.0 + 2.0 * at, 8e-15);
    EXPECT_NEAR(two.integral(at), at + at * at, 1e-13);
  }
}

TEST(Curve, DerivativesAndIntegralBelongToItsValue) {
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    Points points{{0.0}, {random.uniform()}};
    for (int k = 0; k < 6; ++k) {
      points.x.push_back(points.x.back() + random.uniform(0.5, 1.5));
      points.y.push_back(random.uniform());
    }
    const Curve curve("curve", points.x, points.y);
    for (std::size_t k = 0; k + 1 < points.x.size(); ++k) {
      // inside one piece the differences of a cubic are exact but for rounding
      const double x = points.x[k] + 0.5 * (points.x[k + 1] - points.x[k]), h = 0.05;
      auto slope = [&](auto f) {
        return (8 * (f(x + h) - f(x - h)) - (f(x + 2 * h) - f(x - 2 * h))) / (12 * h);
      };
      const Jet at = curve.at(x);
      EXPECT_NEAR(at.first, slope([&](double s) { return curve.at(s).value; }), 1e-13);
      EXPECT_NEAR(at.second, slope([&](double s) { return curve.at(s).first; }), 1e-12);
      EXPECT_NEAR(at.value, slope([&](double s) { return curve.integral(s); }), 1e-13);
    }
    for (const double end : {points.x.front(), points.x.back()})
      EXPECT_NEAR(curve.integral(end + 1e-9), curve.integral(end - 1e-9), 1e-8);
  }
}

/// Largest errors of value and slope on `pieces` equal pieces.
std::pair<double, double> errors(double (*f)(double), double (*df)(double), double from, double to,
                                 int pieces) {
  const Curve curve = sampled(f, from, to, pieces);
  std::pair<double, double> worst{};
  for (int i = 0; i <= 10000; ++i) {
    const double x = from + (to - from) * i / 10000;
    worst.first = std::max(worst.first, std::abs(curve.at(x).value - f(x)));
    worst.second = std::max(worst.second, std::abs(curve.at(x).first - df(x)));
  }
  return worst;
}

TEST(Curve, ConvergesOnSmoothDataInItsOrder) {
  const auto exponential = [](double x) { return std::exp(x); };
  const auto sine = [](double x) { return std::sin(x); };
  const auto cosine = [](double x) { return std::cos(x); };
  // monotone data: slopes of second order, hence values of third; at an extremum the slope 0 costs one order
  const auto coarse = errors(exponential, exponential, 0.0, 2.0, 64),
             fine = errors(exponential, exponential, 0.0, 2.0, 128);
  EXPECT_NEAR(std::log2(coarse.first / fine.first), 3.0, 0.1);  // 2.98
  EXPECT_NEAR(std::log2(coarse.second / fine.second), 2.0, 0.1);
  const auto turned = errors(sine, cosine, 0.1, 6.0, 64), turned_fine = errors(sine, cosine, 0.1, 6.0, 128);
  const double order = std::log2(turned.first / turned_fine.first);
  RecordProperty("orders",
                 std::to_string(std::log2(coarse.first / fine.first)) + " " + std::to_string(order));
  EXPECT_GT(order, 1.5);  // 1.81
  EXPECT_LT(order, 2.5);
}

TEST(Curve, RefusesPointsThatAreNoCurve) {
  struct Wrong {
    std::vector<double> x, y;
    std::vector<const char*> parts;
  };
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN(),
                   kInf = std::numeric_limits<double>::infinity();
  for (const Wrong& w :
       std::vector<Wrong>{{{}, {}, {"table 'lift': points = 0", "at least 2"}},
                          {{1.0}, {1.0}, {"points = 1", "at least 2"}},
                          {{0.0, 1.0, 1.0}, {0, 0, 0}, {"point 2: abscissa = 1", "more than the one before"}},
                          {{0.0, -1.0}, {0, 0}, {"point 1: abscissa = -1"}},
                          {{0.0, kNaN}, {0, 0}, {"point 1: abscissa = nan", "finite"}},
                          {{-kInf, 0.0}, {0, 0}, {"point 0: abscissa = -inf"}},
                          {{0.0, 1.0}, {0, kInf}, {"point 1: value = inf"}},
                          {{0.0, 1e-300}, {0, 1e300}, {"point 1: value = 1", "a finite slope"}}}) {
    try {
      const Curve accepted("table 'lift'", w.x, w.y);
      ADD_FAILURE() << "accepted, " << w.parts[0];
    } catch (const InputError& error) {
      for (const char* part : w.parts)
        EXPECT_NE(std::string(error.what()).find(part), std::string::npos)
            << error.what() << "\nlacks " << part;
    }
  }
  EXPECT_THROW(Curve("table", {0.0, 1.0}, {0.0}), MisuseError);
}

}  // namespace
}  // namespace feder
