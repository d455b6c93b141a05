// Values are judged by muParser, derivatives by closed forms and by differences of the values.
#include "models/scene_file/expression.h"

#include <gtest/gtest.h>
#include <muParser.h>

#include <array>
#include <cmath>
#include <functional>
#include <limits>

#include "tests/models/random_expression.h"
#include "tests/support/allocations.h"

namespace feder {
namespace {

const std::vector<std::string> kNames = {"x", "y", "t"};
using Point = std::array<double, 3>;

double muparser(const std::string& text, Point at) {
  mu::Parser parser;
  parser.EnableOptimizer(false);
  for (std::size_t i = 0; i < 3; ++i) parser.DefineVar(kNames[i], &at[i]);
  // its own abs(-0) is -0, which a division turns into the other infinity
  parser.DefineFun("abs", static_cast<double (*)(double)>(std::abs));
  parser.DefineConst("pi", 3.14159265358979323846);
  parser.SetExpr(text);
  return parser.Eval();
}

Jet in_t(const std::string& text, double t) {
  const double forward = 1.0;
  return Expression(text, {"t"}).along({&t, 1}, {&forward, 1});
}

/// muParser lets comparisons swallow NaN; here it stays NaN.
bool may_swallow(const std::string& text) {
  for (const char* part : {"<", ">", "=", "&&", "||", "?", "min", "max", "sign"})
    if (text.find(part) != std::string::npos) return true;
  return false;
}

TEST(Expression, HasTheValueOfMuParserToTheBit) {
  constexpr std::uint64_t kSeed = 20240611;
  RecordProperty("seed", std::to_string(kSeed));
  RandomExpression texts(kSeed);
  Random random(kSeed + 1);
  int finite = 0, longest = 0;
  for (int i = 0; i < 10000; ++i) {
    const std::string text = texts.text(1 + random.below(5));
    const Point at = {random.uniform(-2.0, 2.0), random.below(3) == 0 ? 0.0 : random.uniform(),
                      random.uniform(0.0, 3.0)};
    const double own = Expression(text, kNames).value(at), judge = muparser(text, at);
    longest = std::max(longest, static_cast<int>(text.size()));
    finite += std::isfinite(own);
    if (std::isnan(own))
      EXPECT_TRUE(std::isnan(judge) || may_swallow(text)) << text << " judge " << judge;
    else
      EXPECT_EQ(own, judge) << text << " at " << at[0] << " " << at[1] << " " << at[2];
  }
  EXPECT_GT(finite, 5500);  // 5870
  EXPECT_GT(longest, 300);
}

TEST(Expression, ReadsPowersAndSignsAsMuParserDoes) {
  const Point at = {-2.0, 3.0, 0.5};
  for (const auto& [text, value] :
       std::vector<std::pair<const char*, double>>{{"-2^2", -4.0},
                                                   {"2^-1", 0.5},
                                                   {"2^-2^2", 0.0625},
                                                   {"2^3^2", 512.0},
                                                   {"-x^2", -4.0},
                                                   {"x^3", -8.0},
                                                   {"2*-y", -6.0},
                                                   {"2--y", 5.0},
                                                   {"1/2/4", 0.125},
                                                   {"1 ? 2 : 0 ? 3 : 4", 2.0},
                                                   {"1 || 0 && 0", 1.0},
                                                   {"min(3,1,2) + max(3,1,2)", 4.0}}) {
    EXPECT_EQ(Expression(text, kNames).value(at), value) << text;
    EXPECT_EQ(muparser(text, at), value) << text;
  }
}

struct ClosedForm {
  const char* text;
  std::function<double(double)> value, first, second;
};

TEST(Expression, DerivativesAreTheClosedForms) {
  const std::vector<ClosedForm> forms = {
      {"sin(3*t)", [](double t) { return std::sin(3 * t); }, [](double t) { return 3 * std::cos(3 * t); },
       [](double t) { return -9 * std::sin(3 * t); }},
      {"cos(t^2)", [](double t) { return std::cos(t * t); },
       [](double t) { return -2 * t * std::sin(t * t); },
       [](double t) { return -2 * std::sin(t * t) - 4 * t * t * std::cos(t * t); }},
      {"tan(t)", [](double t) { return std::tan(t); }, [](double t) { return std::pow(std::cos(t), -2); },
       [](double t) { return 2 * std::sin(t) * std::pow(std::cos(t), -3); }},
      {"asin(t)", [](double t) { return std::asin(t); }, [](double t) { return 1 / std::sqrt(1 - t * t); },
       [](double t) { return t * std::pow(1 - t * t, -1.5); }},
      {"acos(t)", [](double t) { return std::acos(t); }, [](double t) { return -1 / std::sqrt(1 - t * t); },
       [](double t) { return -t * std::pow(1 - t * t, -1.5); }},
      {"atan(t)", [](double t) { return std::atan(t); }, [](double t) { return 1 / (1 + t * t); },
       [](double t) { return -2 * t / std::pow(1 + t * t, 2); }},
      {"atan2(2*sin(5*t), 2*cos(5*t))", [](double t) { return std::atan2(std::sin(5 * t), std::cos(5 * t)); },
       [](double) { return 5.0; }, [](double) { return 0.0; }},
      {"atan2(t, 2)", [](double t) { return std::atan2(t, 2.0); }, [](double t) { return 2 / (4 + t * t); },
       [](double t) { return -4 * t / std::pow(4 + t * t, 2); }},
      {"sinh(t)", [](double t) { return std::sinh(t); }, [](double t) { return std::cosh(t); },
       [](double t) { return std::sinh(t); }},
      {"cosh(2*t)", [](double t) { return std::cosh(2 * t); }, [](double t) { return 2 * std::sinh(2 * t); },
       [](double t) { return 4 * std::cosh(2 * t); }},
      {"tanh(t)", [](double t) { return std::tanh(t); }, [](double t) { return std::pow(std::cosh(t), -2); },
       [](double t) { return -2 * std::sinh(t) * std::pow(std::cosh(t), -3); }},
      {"exp(-2*t)", [](double t) { return std::exp(-2 * t); }, [](double t) { return -2 * std::exp(-2 * t); },
       [](double t) { return 4 * std::exp(-2 * t); }},
      {"ln(t)", [](double t) { return std::log(t); }, [](double t) { return 1 / t; },
       [](double t) { return -1 / (t * t); }},
      {"log10(t)", [](double t) { return std::log10(t); }, [](double t) { return 1 / (t * std::log(10.0)); },
       [](double t) { return -1 / (t * t * std::log(10.0)); }},
      {"sqrt(t)", [](double t) { return std::sqrt(t); }, [](double t) { return 0.5 * std::pow(t, -0.5); },
       [](double t) { return -0.25 * std::pow(t, -1.5); }},
      {"abs(t - 1)", [](double t) { return std::abs(t - 1); }, [](double t) { return t < 1 ? -1.0 : 1.0; },
       [](double) { return 0.0; }},
      {"t^3.5", [](double t) { return std::pow(t, 3.5); }, [](double t) { return 3.5 * std::pow(t, 2.5); },
       [](double t) { return 8.75 * std::pow(t, 1.5); }},
      {"2^t", [](double t) { return std::pow(2.0, t); },
       [](double t) { return std::log(2.0) * std::pow(2.0, t); },
       [](double t) { return std::log(2.0) * std::log(2.0) * std::pow(2.0, t); }},
      {"t^t", [](double t) { return std::pow(t, t); },
       [](double t) { return std::pow(t, t) * (std::log(t) + 1); },
       [](double t) { return std::pow(t, t) * (std::pow(std::log(t) + 1, 2) + 1 / t); }},
      {"t/(1 + t)", [](double t) { return t / (1 + t); }, [](double t) { return std::pow(1 + t, -2); },
       [](double t) { return -2 * std::pow(1 + t, -3); }},
      {"t*exp(t)*3", [](double t) { return 3 * t * std::exp(t); },
       [](double t) { return 3 * (1 + t) * std::exp(t); },
       [](double t) { return 3 * (2 + t) * std::exp(t); }},
      {"max(t^2, 4*t) + min(t, 9)", [](double t) { return 5 * t; }, [](double) { return 5.0; },
       [](double) { return 0.0; }},
      {"t > 0.5 ? t^2 : t^3", [](double t) { return t > 0.5 ? t * t : t * t * t; },
       [](double t) { return t > 0.5 ? 2 * t : 3 * t * t; }, [](double t) { return t > 0.5 ? 2 : 6 * t; }}};
  Random random(7);
  double worst = 0.0;
  for (const ClosedForm& form : forms)
    for (int i = 0; i < 100; ++i) {
      const double t = random.uniform(0.05, 0.95);
      const Jet jet = in_t(form.text, t);
      for (const auto& [own, exact] :
           {std::pair(jet.value, form.value(t)), std::pair(jet.first, form.first(t)),
            std::pair(jet.second, form.second(t))}) {
        const double error = std::abs(own - exact) / (1.0 + std::abs(exact));
        worst = std::max(worst, error);
        EXPECT_LT(error, 2e-14)  // 6.2e-15
            << form.text << " at " << t << ": " << own << " for " << exact;
      }
    }
  RecordProperty("worst", std::to_string(worst * 1e16) + "e-16");
}

TEST(Expression, DerivativesAlongALineAreThoseOfItsDifferences) {
  constexpr std::uint64_t kSeed = 31;
  RandomExpression texts(kSeed);
  Random random(kSeed + 1);
  int close = 0;
  for (int i = 0; i < 1000; ++i) {
    const std::string text = texts.smooth(4);
    const Expression f(text, kNames);
    const Point x = {random.uniform(), random.uniform(), random.uniform()},
                d = {random.uniform(), random.uniform(), random.below(2) == 0 ? 0.0 : random.uniform()};
    auto at = [&](double s) {
      Point moved;
      for (std::size_t k = 0; k < 3; ++k) moved[k] = x[k] + s * d[k];
      return f.along(moved, d);
    };
    auto slope = [&](double Jet::*member, double h) {
      const double near = at(h).*member - at(-h).*member, far = at(2 * h).*member - at(-2 * h).*member;
      return (8.0 * near - far) / (12.0 * h);
    };
    const Jet jet = at(0.0);
    EXPECT_EQ(jet.value, f.value(x)) << text;
    for (const auto& [own, member] :
         {std::pair(jet.first, &Jet::value), std::pair(jet.second, &Jet::first)}) {
      const double fine = slope(member, 1e-3), coarse = slope(member, 2e-3);
      // the coarse difference has 16 times the error of the fine one
      const double bound = std::abs(fine - coarse) + 1e-11 * (1.0 + std::abs(jet.*member));
      EXPECT_NEAR(own, fine, bound) << text;
      close += std::abs(own - fine) < 1e-8 * (1.0 + std::abs(own));
    }
  }
  RecordProperty("close", close);
  EXPECT_GT(close, 1900);  // 1984 of 2000
}

TEST(Expression, DerivativesAtCornersAreTheStatedOnes) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  struct Corner {
    const char* text;
    double t, value, first, second;
  };
  for (const Corner& c : std::vector<Corner>{{"t^2", 0, 0, 0, 2},
                                             {"t^1", 0, 0, 1, 0},
                                             {"t^0", 0, 1, 0, 0},
                                             {"(t - 3)^3", 1, -8, 12, -12},
                                             {"t^-2", -2, 0.25, 0.25, 0.375},
                                             {"abs(t)", 0, 0, 0, 0},
                                             {"sqrt(t)", 0, 0, kInf, -kInf},
                                             {"3*sqrt(t)/2", 0, 0, kInf, -kInf},
                                             {"sqrt(0)*t", 2, 0, 0, 0},
                                             {"t + 0*ln(2)^0.5", 0, 0, 1, 0},
                                             {"t > 0 ? sqrt(t) : 0", 0, 0, 0, 0},
                                             {"t >= 0 ? t : 1/0", 0, 0, 1, 0},
                                             {"t == 0 ? 1 : sin(t)/t", 0, 1, 0, 0},
                                             {"sign(t)*t", -2, 2, -1, 0},
                                             {"min(t, 2*t)", 0, 0, 1, 0},
                                             {"max(2*t, t)", 0, 0, 2, 0},
                                             {"(t > 1) + (t <= 1)*t", 1, 1, 1, 0}}) {
    const Jet jet = in_t(c.text, c.t);
    EXPECT_EQ(jet.value, c.value) << c.text;
    EXPECT_EQ(jet.first, c.first) << c.text;
    EXPECT_EQ(jet.second, c.second) << c.text;
  }
}

TEST(Expression, DoesNotLoseANaN) {
  for (const char* text : {"sqrt(-t) > 0", "sqrt(-t) > 0 ? 1 : 2", "min(1, ln(-t))", "max(ln(-t), 1)",
                           "sign(ln(-t))", "0 || ln(-t)", "ln(-t) && 0", "1 + (ln(-t) != 1 ? t : 3*t)"}) {
    const Jet jet = in_t(text, 1.0);
    EXPECT_TRUE(std::isnan(jet.value) && std::isnan(jet.first) && std::isnan(jet.second)) << text;
  }
  EXPECT_EQ(in_t("t > 0 || ln(-t)", 1.0).value, 1.0);
}

TEST(Expression, KnowsItsVariables) {
  const Expression f("x*sin(t) + 0*pi", kNames);
  EXPECT_TRUE(f.uses("x") && f.uses("t"));
  EXPECT_FALSE(f.uses("y") || f.uses("z") || f.uses("sin") || Expression().uses("x"));
  EXPECT_EQ(f.text(), "x*sin(t) + 0*pi");
}

TEST(Expression, EvaluatesWithoutAllocating) {
  const Expression f("x > 0 ? sin(x)^2 + max(x, y, t)*atan2(y, x) : exp(-t)", kNames);
  const Point x = {0.3, 0.2, 0.1}, d = {1.0, 0.0, 0.0};
  double sum = 0.0;
  const auto before = allocations();
  for (int i = 0; i < 100; ++i) sum += f.value(x) + f.along(x, d).second;
  EXPECT_EQ(allocations(), before);
  EXPECT_GT(std::abs(sum), 0.0);
}

struct Wrong {
  std::string text;
  int column;
  std::vector<const char*> parts;
};

std::string repeated(const std::string& text, int count) {
  std::string out;
  for (int i = 0; i < count; ++i) out += text;
  return out;
}

TEST(Expression, ErrorsNameColumnFindingAndExpectation) {
  const std::vector<Wrong> wrong = {
      {"", 1, {"found the end", "expected a number, a variable"}},
      {"   ", 4, {"found the end"}},
      {"t +", 4, {"found the end", "expected a number"}},
      {"t + * 2", 5, {"found '*'", "expected a number"}},
      {"sni(t)", 1, {"'sni'", "did you mean 'sin'?"}},
      {"2*sqr(t)", 3, {"'sqr'", "did you mean 'sqrt'?"}},
      {"log(t)", 1, {"'log'", "ln", "log10"}},
      {"2 + time", 5, {"'time'", "expected a variable (t)", "did you mean 't'?"}},
      {"3*PI", 3, {"'PI'"}},
      {"2t", 2, {"found 't'", "an operator before it"}},
      {"2 (t)", 3, {"found '('", "an operator before it"}},
      {"t t", 3, {"found 't'", "an operator before it"}},
      {"(t + 1", 7, {"found the end", "')'"}},
      {"t + 1)", 6, {"found ')'", "an operator or the end"}},
      {"()", 2, {"found ')'"}},
      {"sin t", 5, {"found 't'", "'(' after the function sin"}},
      {"sin", 4, {"found the end", "'(' after the function sin"}},
      {"sin()", 5, {"found ')'"}},
      {"sin(t, 2)", 1, {"2 arguments of sin", "expected 1"}},
      {"t + atan2(t)", 5, {"1 arguments of atan2", "expected 2"}},
      {"atan2(1,2,3)", 1, {"3 arguments of atan2", "expected 2"}},
      {"min(t)", 1, {"1 arguments of min", "at least 2"}},
      {"min(t,)", 7, {"found ')'"}},
      {"sin(t", 6, {"found the end", "')', ','"}},
      {"--t", 2, {"found '-'"}},
      {"t = 1", 3, {"found '='", "equality is '=='"}},
      {"!t", 1, {"found '!'"}},
      {"t & 1", 3, {"found '&'"}},
      {"t ? 1", 6, {"found the end", "':'"}},
      {"t ? : 2", 5, {"found ':'"}},
      {"1 : 2", 3, {"found ':'"}},
      {"0 < t < 1", 7, {"found '<'", "a < b && b < c"}},
      {"t == 1 != 0", 8, {"found '!='", "no second comparison"}},
      {"1e999*t", 1, {"found '1e999'", "expected a number that is 0 or between"}},
      {"t + 1e-999", 5, {"found '1e-999'"}},
      {"nan", 1, {"'nan'", "expected a variable"}},
      {"t + inf", 5, {"'inf'"}},
      {"0x10", 2, {"found 'x10'"}},
      {"1e", 2, {"found 'e'"}},
      {"1.2.3", 4, {"found '.3'"}},
      {".", 1, {"found '.'"}},
      {"t^", 3, {"found the end"}},
      {"t % 2", 3, {"found '%'"}},
      {"t, 1", 2, {"found ','"}},
      {"t + \xc3\xa4", 5, {"a character that is not ASCII"}},
      {std::string("t\0+1", 4), 2, {"found '?'"}},
      {repeated("(", 70) + "t" + repeated(")", 70), 65, {"deeper than the 64 levels"}},
      {repeated("t+(", 66) + "t" + repeated(")", 66), 193, {"64"}},
      {"t" + repeated("+t", 2100), 4097, {"4201 characters", "at most 4096"}}};
  EXPECT_GE(wrong.size(), 25u);
  for (const Wrong& w : wrong) try {
      const Expression accepted(w.text, {"t"});
      ADD_FAILURE() << w.text << " was accepted";
    } catch (const ExpressionError& error) {
      EXPECT_EQ(error.column(), w.column) << error.what();
      if (w.text.size() <= Expression::kLongestText)
        EXPECT_NE(std::string(error.what()).find("column " + std::to_string(w.column) + ":"),
                  std::string::npos)
            << error.what();
      for (const char* part : w.parts)
        EXPECT_NE(std::string(error.what()).find(part), std::string::npos)
            << error.what() << "\nlacks " << part;
    }
}

TEST(Expression, RefusesVariablesThatCannotBeMeant) {
  for (const auto& names :
       std::vector<std::vector<std::string>>{{"sin"}, {"pi"}, {"2x"}, {""}, {"a b"}, {"t", "t"}})
    EXPECT_THROW(Expression("1", names), InputError) << names[0];
}

TEST(Expression, WithoutATextIsMisuse) {
  EXPECT_THROW(static_cast<void>(Expression().value({})), MisuseError);
  EXPECT_THROW(static_cast<void>(Expression("t", {"t"}).value({})), MisuseError);
}

TEST(Expression, NestingUpToTheLimitIsAccepted) {
  for (int depth = 1; depth <= 63; ++depth)
    EXPECT_EQ(Expression(repeated("(", depth) + "7" + repeated(")", depth), {}).value({}), 7.0);
  EXPECT_EQ(Expression("1" + repeated("+1", 2047), {}).value({}), 2048.0);
}

TEST(Expression, RandomBytesGiveAValueOrAnError) {
  constexpr std::uint64_t kSeed = 99;
  RecordProperty("seed", std::to_string(kSeed));
  static constexpr const char* kPieces[] = {"t",    "x",  "1", "2.5", "(",  ")", "+", "-",  "*",
                                            "/",    "^",  "<", "==",  "&&", "?", ":", ",",  "sin(",
                                            "min(", "pi", " ", "1e",  ".",  "=", "|", "max"};
  Random random(kSeed);
  int accepted = 0;
  for (int i = 0; i < 100000; ++i) {
    std::string text;
    for (int length = random.below(24); length > 0; --length)
      text += i % 2 == 0 ? std::string(1, static_cast<char>(random.below(256)))
                         : kPieces[random.below(static_cast<int>(std::size(kPieces)))];
    try {
      const Expression f(text, kNames);
      const Point x = {0.5, 0.25, 1.0};
      static_cast<void>(f.along(x, x));
      ++accepted;
    } catch (const ExpressionError& error) {
      EXPECT_GE(error.column(), 1);
      EXPECT_LE(error.column(), static_cast<int>(text.size()) + 1);
    }
  }
  EXPECT_GT(accepted, 500);
  EXPECT_LT(accepted, 50000);
}

}  // namespace
}  // namespace feder
