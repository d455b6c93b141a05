#include "models/scene_file/laws.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

namespace feder {
namespace {

Jet in_time(const Expression& expression, double t) {
  constexpr double kForward = 1.0;
  return expression.along({&t, 1}, {&kForward, 1});
}

/// Gauss-Lobatto, 10 points: integral of f and of |f| over [a, b]. It has the ends among its points: a kink
/// between an end and the first point inside would show in no sum.
template <class Function>
std::array<double, 2> gauss(const Function& f, double a, double b) {
  static constexpr double kNode[] = {0.16527895766638703, 0.4779249498104445, 0.738773865105505,
                                     0.9195339081664589, 1.0},
                          kWeight[] = {0.32753976118389744, 0.2920426836796838, 0.22488934206312644,
                                       0.13330599085107012, 0.022222222222222223};
  const double middle = 0.5 * (a + b), half = 0.5 * (b - a);
  std::array<double, 2> sum{};
  for (int i = 0; i < 5; ++i) {
    const double right = f(middle + half * kNode[i]), left = f(middle - half * kNode[i]);
    sum[0] += half * kWeight[i] * (right + left);
    sum[1] += std::abs(half) * kWeight[i] * (std::abs(right) + std::abs(left));
  }
  return sum;
}

/// Integral over [from, to]: a piece is halved until its halves agree with it. NaN beyond the budget.
template <class Function>
double integral(const Function& f, double from, double to) {
  constexpr double kTolerance = 1e-15, kNaN = std::numeric_limits<double>::quiet_NaN();
  constexpr int kBudget = 4000, kDeepest = 48;
  struct Piece {
    double a, b;
    int depth;
    std::array<double, 2> sums;
  };
  std::array<Piece, kDeepest + 2> open;  // at most one waiting piece per depth
  std::size_t count = 0;
  open[count++] = {from, to, 0, gauss(f, from, to)};
  double sum = 0.0, size = open[0].sums[1];
  for (int used = 0; count > 0; ++used) {
    const Piece piece = open[--count];
    if (used == kBudget || !std::isfinite(piece.sums[1])) return kNaN;
    const double middle = 0.5 * (piece.a + piece.b);
    const std::array<double, 2> left = gauss(f, piece.a, middle), right = gauss(f, middle, piece.b);
    const double better = left[0] + right[0];
    size = std::max(size, left[1] + right[1]);
    if (std::abs(better - piece.sums[0]) <= kTolerance * size || piece.depth == kDeepest) {
      sum += better;
    } else {
      open[count++] = {middle, piece.b, piece.depth + 1, right};
      open[count++] = {piece.a, middle, piece.depth + 1, left};
    }
  }
  return sum;
}

void require_variables(const Expression& expression, const std::vector<std::string>& variables) {
  FEDER_CHECK(expression.variables() == variables, "an expression in other variables");
}

constexpr std::size_t kForceInputs = 7;  // of kForceVariables

/// t, x and v of a node, as the expressions take them.
std::array<double, kForceInputs> inputs(double t, const VectorXd& q, const VectorXd& v, int node) {
  return {t, q[3 * node], q[3 * node + 1], q[3 * node + 2], v[3 * node], v[3 * node + 1], v[3 * node + 2]};
}

/// out (3 x 3) = symmetric part of -dF/dx.
void write_stiffness(const ForceField& field, const std::array<double, kForceInputs>& at, double* out) {
  Eigen::Map<Matrix3d> K(out);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::array<double, kForceInputs> direction{};
    direction[1 + axis] = 1.0;
    for (int i = 0; i < 3; ++i)
      K(i, static_cast<int>(axis)) = -field.force[static_cast<std::size_t>(i)].along(at, direction).first;
  }
  K = (0.5 * (K + K.transpose())).eval();
}

void check_field(const ForceField& field) {
  for (const Expression& component : field.force) require_variables(component, kForceVariables);
  std::vector<int> nodes = field.nodes;
  std::sort(nodes.begin(), nodes.end());
  if (!nodes.empty() && nodes.front() < 0) fail_input("force", "node", nodes.front(), "", "one of the scene");
  if (const auto twice = std::adjacent_find(nodes.begin(), nodes.end()); twice != nodes.end())
    fail_input("force", "node", *twice, "", "each node once");
}

bool depends_on_place(const ForceField& field) {
  return std::any_of(field.force.begin(), field.force.end(), [](const Expression& component) {
    return component.uses("x") || component.uses("y") || component.uses("z");
  });
}

}  // namespace

Target target_from(const Expression& e) {
  require_variables(e, {"t"});
  return {[e](double t) {
            return e.value({&t, 1});
          },
          [e](double t) { return in_time(e, t).first; }, [e](double t) { return in_time(e, t).second; }};
}

Target target_from(const Curve& curve) {
  const auto shared = std::make_shared<const Curve>(curve);
  return {[shared](double t) { return shared->at(t).value; },
          [shared](double t) { return shared->at(t).first; },
          [shared](double t) { return shared->at(t).second; }};
}

Motion motion_from(const std::array<Target, 3>& c) {
  const auto vector = [](const auto& x, const auto& y, const auto& z) {
    return [=](double t) { return Vector3d(x(t), y(t), z(t)); };
  };
  return {vector(c[0].value, c[1].value, c[2].value), vector(c[0].rate, c[1].rate, c[2].rate),
          vector(c[0].acceleration, c[1].acceleration, c[2].acceleration)};
}

Motion motion_from(const std::array<Expression, 3>& e) {
  return motion_from(std::array<Target, 3>{target_from(e[0]), target_from(e[1]), target_from(e[2])});
}

SpringLaw law_from(const Expression& e, double rest) {
  require_variables(e, {"length", "rate"});
  require_finite("spring law", "rest", rest, "m");
  SpringLaw out;
  out.law = [e](double length, double rate) {
    static constexpr double kByLength[] = {1.0, 0.0}, kByRate[] = {0.0, 1.0};
    const double x[] = {length, rate};
    const Jet by_length = e.along(x, kByLength);
    return Tension{by_length.value, by_length.first, e.along(x, kByRate).first};
  };
  if (e.uses("rate")) return out;
  out.energy = [e, rest](double length) {
    return integral([&e](double l) { return e.value(std::array<double, 2>{l, 0.0}); }, rest, length);
  };
  return out;
}

SpringLaw law_from(const Curve& curve, double rest) {
  require_finite("spring law", "rest", rest, "m");
  const auto shared = std::make_shared<const Curve>(curve);
  const double start = curve.integral(rest);
  return {[shared](double length, double) {
            const Jet tension = shared->at(length);
            return Tension{tension.value, tension.first, 0.0};
          },
          [shared, start](double length) { return shared->integral(length) - start; }};
}

double force_component(const ForceField& field, std::size_t c, double t, const VectorXd& q, const VectorXd& v,
                       int node) {
  return field.force[c].value(inputs(t, q, v, node));
}

UserForce force_from(const std::vector<ForceField>& fields) {
  std::vector<ForceField> stiff;
  for (const ForceField& field : fields) {
    check_field(field);
    if (depends_on_place(field)) stiff.push_back(field);
  }
  UserForce out;
  out.force = [fields](double t, const VectorXd& q, const VectorXd& v, VectorXd& force) {
    for (const ForceField& field : fields)
      for (const int node : field.nodes) {
        const auto at = inputs(t, q, v, node);
        for (int i = 0; i < 3; ++i) force[3 * node + i] += field.force[static_cast<std::size_t>(i)].value(at);
      }
  };
  for (const ForceField& field : stiff)
    for (const int node : field.nodes) out.stencils.push_back({node});
  if (stiff.empty()) return out;
  out.stiffness = [stiff](double t, const VectorXd& q, const VectorXd& v, double* stiffness) {
    for (const ForceField& field : stiff)
      for (const int node : field.nodes) {
        write_stiffness(field, inputs(t, q, v, node), stiffness);
        stiffness += 9;
      }
  };
  return out;
}

}  // namespace feder
