// Rows between two bodies against automatic differentiation of formulas written here a second time: J and the
// second derivative along R exp([xi]x), at random states. R exp([xi]x) = R (E + [xi]x + [xi]x^2 / 2) is exact
// to second order at xi = 0.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "engine/kkt.h"
#include "tests/support/random.h"
#include "tests/support/row_formulas.h"

namespace feder {
namespace {

constexpr int kCoordinates = 12;  // centre and turn of a, then of b

struct Scene {
  SystemBuilder::Built built;
  Anchor a, b;
  Vector3d n, m;  // directions in the bodies' axes
  Vector3d n_across;
};

/// Two lumps at random poses; `add` puts one row between anchors of theirs.
template <class Add>
Scene scene_with(std::uint64_t seed, Add&& add) {
  Random random(seed);
  SystemBuilder builder;
  std::array<Anchor, 2> ends;
  for (Anchor& end : ends) {
    std::vector<PointMass> points;
    for (int i = 0; i < 6; ++i) points.push_back({random.uniform(0.2, 1.0), random.vector(0.5)});
    const Vector3d theta = random.vector(2.0);
    end = builder.add_body(
        point_masses("lump", points),
        {.position = random.vector(),
         .orientation = Eigen::AngleAxisd(theta.norm(), theta.normalized()).toRotationMatrix()});
    end.point = random.vector(0.4);
  }
  const Vector3d n = random.vector().normalized(), m = random.vector().normalized();
  const Vector3d across = n.cross(random.vector()).normalized();
  Scene scene{{}, ends[0], ends[1], n, m, across};
  add(builder, scene);
  scene.built = builder.build();
  return scene;
}

/// The bodies' points and directions as functions of the 12 coordinates.
template <class T>
struct Moved {
  const Scene& scene;
  const T* x;

  Triplet<T> turned(int body, const Vector3d& in_body_axes) const {
    const Body& b = scene.built.system.bodies[body];
    const Matrix3d R = rotation_matrix(scene.built.state.q.data() + b.quaternion);
    const Vector3d s = b.axes.transpose() * in_body_axes;
    const Triplet<T> xi{x[6 * body + 3], x[6 * body + 4], x[6 * body + 5]};
    const Triplet<T> base{T(s[0]), T(s[1]), T(s[2])};
    const Triplet<T> once = cross3(xi, base), twice = cross3(xi, once);
    Triplet<T> out;
    for (int i = 0; i < 3; ++i) {
      out[i] = T(0.0);
      for (int j = 0; j < 3; ++j) {
        T sum = base[j];
        sum += once[j];
        sum += T(0.5) * twice[j];
        out[i] += T(R(i, j)) * sum;
      }
    }
    return out;
  }
  Triplet<T> point(int body, const Anchor& anchor) const {
    const Body& b = scene.built.system.bodies[body];
    Triplet<T> out = turned(body, anchor.point - b.centre_point);
    for (int c = 0; c < 3; ++c) {
      out[c] += T(scene.built.state.q[3 * b.centre + c]);
      out[c] += x[6 * body + c];
    }
    return out;
  }
  Triplet<T> gap() const {
    const Triplet<T> pa = point(0, scene.a), pb = point(1, scene.b);
    return difference3(pa.data(), pb.data());
  }
};

struct Ball {
  static constexpr int kComponents = 3;
  static void add(SystemBuilder& builder, const Scene& s) { builder.add(BallRow{{s.a, s.b, 2.0}}); }
  template <class T>
  static T phi(const Moved<T>& at, int i) {
    return at.gap()[i];
  }
};

struct Distance {
  static constexpr int kComponents = 1;
  static void add(SystemBuilder& builder, const Scene& s) {
    builder.add(AnchorDistanceRow{{s.a, s.b, 2.0}, 0.3});
  }
  template <class T>
  static T phi(const Moved<T>& at, int) {
    T out = norm3(at.gap());
    out -= T(0.3);
    return out;
  }
};

struct Perpendicular {
  static constexpr int kComponents = 1;
  static void add(SystemBuilder& builder, const Scene& s) {
    builder.add(PerpendicularRow{{s.a, s.b, 2.0}, s.n, s.m});
  }
  template <class T>
  static T phi(const Moved<T>& at, int) {
    return dot3(at.turned(0, at.scene.n), at.turned(1, at.scene.m));
  }
};

struct Along {
  static constexpr int kComponents = 1;
  static void add(SystemBuilder& builder, const Scene& s) {
    builder.add(AlongRow{{{s.a, s.b, 2.0}, 0.2}, s.n});
  }
  template <class T>
  static T phi(const Moved<T>& at, int) {
    T out = dot3(at.turned(0, at.scene.n), at.gap());
    out -= T(0.2);
    return out;
  }
};

struct Turn {
  static constexpr int kComponents = 1;
  static void add(SystemBuilder& builder, const Scene& s) {
    builder.add(TurnRow{{{s.a, s.b, 2.0}, 0.2}, s.n, s.n_across, s.m});
  }
  template <class T>
  static T phi(const Moved<T>& at, int) {
    using std::atan2;
    const Triplet<T> m = at.turned(1, at.scene.m), across = at.turned(0, at.scene.n_across);
    const T sine = dot3(cross3(at.turned(0, at.scene.n), across), m), cosine = dot3(across, m);
    T out = atan2(sine, cosine);
    out -= T(0.2);
    return out;
  }
};

template <class Row>
class AnchorRowDerivatives : public testing::Test {};
using RowTypes = testing::Types<Ball, Distance, Perpendicular, Along, Turn>;
TYPED_TEST_SUITE(AnchorRowDerivatives, RowTypes);

constexpr int kStates = 300;

TYPED_TEST(AnchorRowDerivatives, AgreeWithAutomaticDifferentiation) {
  double worst_phi = 0.0, worst_jacobian = 0.0, worst_hessian = 0.0;
  for (std::uint64_t seed = 1; seed <= kStates; ++seed) {
    const Scene scene = scene_with(seed, TypeParam::add);
    const System& s = scene.built.system;
    const VectorXd& q = scene.built.state.q;
    Kkt kkt;
    kkt.prepare(s);
    ASSERT_TRUE(kkt.evaluate(q).ok());
    const Stencil& stencil = s.stencils[0];
    const int columns = 3 * stencil.nodes;
    const double zero[kCoordinates] = {};
    for (int i = 0; i < TypeParam::kComponents; ++i) {
      const auto expected = differentiate<kCoordinates>(
          [&]<class T>(const T* x) {
            return TypeParam::phi(Moved<T>{scene, x}, i);
          },
          zero);
      VectorXd unit = VectorXd::Unit(s.rows, i);
      kkt.set_geometric_stiffness(GeometricStiffness::kFull, -1.0, scene.built.state, unit);
      const Eigen::Map<const Eigen::MatrixXd> H(kkt.geometric_stencil.data() + stencil.matrix, columns,
                                                columns);
      const Eigen::Map<const VectorXd> J(kkt.jacobian.data() + stencil.jacobian + columns * i, columns);
      worst_phi = std::max(worst_phi, std::abs(kkt.phi[i] - expected.value));
      worst_jacobian = std::max(
          worst_jacobian, (J.head<kCoordinates>() - expected.gradient).norm() / expected.gradient.norm());
      worst_hessian =
          std::max(worst_hessian, (H.topLeftCorner<kCoordinates, kCoordinates>() - expected.hessian).norm() /
                                      (1.0 + expected.hessian.norm()));
    }
  }
  EXPECT_LT(worst_phi, 1e-14);
  EXPECT_LT(worst_jacobian, 1e-12);
  EXPECT_LT(worst_hessian, 1e-12);
}

}  // namespace
}  // namespace feder
