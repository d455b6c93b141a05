// Gauss-Seidel over rows. Hard rows have gamma = 0; rows that cannot push are not visited. Spins: q' =
// q_start exp(dt w), J by w (J_r of the turn), as in the converged implicit step.
#include "solvers/row_sweep.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace feder {
namespace {
// Elements of a colour from which on threads are worth it: two take 0.70 of the time of one at 250 rows.
constexpr int kWorthThreads = 250;

// Colours taken by the elements at each moving node; the first free one.
class Colouring {
 public:
  explicit Colouring(int nodes) : taken_(nodes) {}
  template <class Nodes>
  int first_free(const Nodes& nodes, const std::vector<char>& moves) {
    for (int colour = 0;; ++colour) {
      const bool taken = std::any_of(nodes.begin(), nodes.end(), [&](int node) {
        return moves[node] && colour < static_cast<int>(taken_[node].size()) && taken_[node][colour];
      });
      if (taken) continue;
      for (int node : nodes) {
        if (!moves[node]) continue;
        if (colour >= static_cast<int>(taken_[node].size())) taken_[node].resize(colour + 1);
        taken_[node][colour] = 1;
      }
      return colour;
    }
  }

 private:
  std::vector<std::vector<char>> taken_;
};

// The larger one; NaN if either is.
double larger(double a, double b) {
  return a >= b || std::isnan(a) ? a : b;
}

// The largest of project(0 ... count - 1), NaN if one is. Their order does not matter: they share nothing.
template <class Project>
double largest_of(int count, Project&& project) {
  double largest = 0.0;
  if (count <= kWorthThreads) {
    for (int i = 0; i < count; ++i) largest = larger(largest, project(i));
    return largest;
  }
  bool failed = false;
#pragma omp parallel for schedule(static) reduction(max : largest) reduction(|| : failed)
  for (int i = 0; i < count; ++i) {
    const double value = project(i);
    failed = failed || std::isnan(value);
    largest = std::max(largest, value);
  }
  return failed ? std::numeric_limits<double>::quiet_NaN() : largest;
}

bool isotropic(FreeMask free) {
  return free == kFree || free == kPinned;
}

// A turn theta = dt w. Half of it, h = |theta|/2, gives all: a = (1 - cos h)/h^2, b = (h - sin h)/h^3 by
// their series, exact to rounding where the turn is `small`, h <= 1/4 (the terms left out: 1e-17).
struct Turn {
  static constexpr double kSeries = 1.0 / 16.0;
  static constexpr int kTerms = 6;
  static constexpr std::array<double, 2 * kTerms> kInverse = [] {  // 1/2!, 1/3!, ...
    std::array<double, 2 * kTerms> value{};
    double factorial = 1.0;
    for (int i = 0; i < 2 * kTerms; ++i) value[i] = 1.0 / (factorial *= i + 2.0);
    return value;
  }();

  double theta[3], half_squared, a = 0.0, b = 0.0;
  Turn(double dt, const double* w) {
    for (int c = 0; c < 3; ++c) theta[c] = dt * w[c];
    half_squared = 0.25 * (theta[0] * theta[0] + theta[1] * theta[1] + theta[2] * theta[2]);
    const double u = half_squared;  // two terms at a time: they do not wait for each other
    for (int i = 2 * kTerms - 4; i >= 0; i -= 4) {
      a = (kInverse[i] - u * kInverse[i + 2]) + u * u * a;
      b = (kInverse[i + 1] - u * kInverse[i + 3]) + u * u * b;
    }
  }
  bool small() const { return half_squared <= kSeries; }
  Vector3d vector() const { return {theta[0], theta[1], theta[2]}; }

  // Rows of J (kStride apart) times J_r: j J_r = j - f j x theta + g (j x theta) x theta with
  // f = (1 - cos)/theta^2 = (sin h/h)^2/2, g = (|theta| - sin)/|theta|^3 = (1 - cos h sin h/h)/(4 h^2).
  template <int kRows, int kStride>
  void take_rows_over(double* J) const {
    const double sine = 1.0 - half_squared * b, f = 0.5 * sine * sine,
                 g = 0.25 * (a + b - half_squared * a * b);
    const double x = theta[0], y = theta[1], z = theta[2];
    for (int i = 0; i < kRows; ++i, J += kStride) {
      const double once[3] = {J[1] * z - J[2] * y, J[2] * x - J[0] * z, J[0] * y - J[1] * x};
      J[0] += g * (once[1] * z - once[2] * y) - f * once[0];
      J[1] += g * (once[2] * x - once[0] * z) - f * once[1];
      J[2] += g * (once[0] * y - once[1] * x) - f * once[2];
    }
  }
  // out = start exp(theta), of unit length to rounding.
  void turn_from(const double* start, double* out) const {
    const double w = 1.0 - half_squared * a, sine = 0.5 - 0.5 * half_squared * b;
    const double x = sine * theta[0], y = sine * theta[1], z = sine * theta[2];
    const double* p = start;
    out[0] = p[0] * w - p[1] * x - p[2] * y - p[3] * z;
    out[1] = p[0] * x + p[1] * w + p[2] * z - p[3] * y;
    out[2] = p[0] * y - p[1] * z + p[2] * w + p[3] * x;
    out[3] = p[0] * z + p[1] * y - p[2] * x + p[3] * w;
  }
};

// Rows of `columns` entries become rows of kMost, zeros at their ends.
template <int kRows, int kMost>
void widen(int columns, double* J) {
  for (int i = kRows - 1; i >= 0; --i) {
    std::copy_backward(J + i * columns, J + (i + 1) * columns, J + i * kMost + columns);
    std::fill(J + i * kMost + columns, J + (i + 1) * kMost, 0.0);
  }
}
}  // namespace

void RowSweep::prepare(const System& s) {
  system_ = &s;
  colours_.clear();
  std::vector<char> moves(s.nodes);
  for (int i = 0; i < s.nodes; ++i) moves[i] = s.free[i] != kPinned;
  Colouring colouring(s.nodes);
  auto of = [&](const auto& nodes) -> Colour& {
    const int colour = colouring.first_free(nodes, moves);
    if (colour >= static_cast<int>(colours_.size())) colours_.resize(colour + 1);
    return colours_[colour];
  };
  for (int k = 0; k < s.distance.size(); ++k) {
    const int a = s.distance.a[k], b = s.distance.b[k];
    if (!s.distance.active(k)) continue;
    const bool same = (moves[a] || moves[b]) && isotropic(s.free[a]) && isotropic(s.free[b]);
    of(std::array{a, b}).distance.push_back({a, b, k, moves[a] != 0, moves[b] != 0, same});
  }
  std::size_t type = 0;
  int at = 0;
  for_each_stencil_row_type(s.stencil_rows, [&](const auto& list) {
    first_stencil_[type] = at;
    for (std::size_t i = 0; i < list.size(); ++i, ++at) {
      const Stencil& stencil = s.stencils[at];
      const std::vector<int> nodes(s.stencil_nodes.begin() + stencil.first_node,
                                   s.stencil_nodes.begin() + stencil.first_node + stencil.nodes);
      if (s.active(stencil.first_row)) of(nodes).stencil[type].push_back(static_cast<int>(i));
    }
    ++type;
  });
}

std::vector<int> RowSweep::order() const {
  std::vector<int> rows;
  for (const Colour& colour : colours_) {
    for (const Distance& row : colour.distance) rows.push_back(row.row);
    for (std::size_t type = 0; type < kTypes; ++type)
      for (int i : colour.stencil[type]) {
        const Stencil& stencil = system_->stencils[first_stencil_[type] + i];
        for (int j = 0; j < stencil.rows; ++j) rows.push_back(stencil.first_row + j);
      }
  }
  return rows;
}

void step_rows_of(const Kkt& kkt, const std::vector<int>& order, StepRows& out) {
  const System& s = *kkt.system;
  std::vector<int> stencil_of(s.rows, -1);
  for (std::size_t i = 0; i < s.stencils.size(); ++i)
    for (int j = 0; j < s.stencils[i].rows; ++j)
      stencil_of[s.stencils[i].first_row + j] = static_cast<int>(i);
  const int count = static_cast<int>(order.size());
  out.clear();
  out.gamma.resize(count);
  out.r.resize(count);
  auto add_node = [&](int node, double sign, const double* entries) {
    for (int c = 0; c < 3; ++c)
      if (s.free[node] >> c & 1) out.add(3 * node + c, sign * entries[c]);
  };
  for (int i = 0; i < count; ++i) {
    const int k = order[i];
    if (k < s.distance.size()) {
      add_node(s.distance.a[k], -1.0, kkt.u.data() + 3 * k);
      add_node(s.distance.b[k], 1.0, kkt.u.data() + 3 * k);
    } else {
      const Stencil& stencil = s.stencils[stencil_of[k]];
      const double* J = kkt.jacobian.data() + stencil.jacobian + 3 * stencil.nodes * (k - stencil.first_row);
      for (int n = 0; n < stencil.nodes; ++n)
        add_node(s.stencil_nodes[stencil.first_node + n], 1.0, J + 3 * n);
    }
    out.close_row();
    out.gamma[i] = kkt.gamma[k];
    out.r[i] = kkt.r[k];
  }
}

void RowSweep::begin(double dt, const Kkt& kkt, const VectorXd& remembered, const VectorXd& q_start) {
  dt_ = dt;
  rate_ = 1.0 / dt;
  kkt_ = &kkt;
  remembered_ = &remembered;
  q_start_ = &q_start;
  const VectorXd& W = kkt.inverse_mass;
  for (Colour& colour : colours_)
    for (Distance& row : colour.distance) {
      row.target = system_->distance.rest[row.row] + remembered[row.row];
      row.mobility = W[3 * row.a] + W[3 * row.b];
      row.gamma = kkt.gamma[row.row];
      row.inverse = 1.0 / (row.mobility + row.gamma);
    }
}

template <bool kBooks>
double RowSweep::project_distance(const Distance& row, double share, double* q, double* v, double* y,
                                  double* impulse) const {
  const int a = 3 * row.a, b = 3 * row.b;
  const double* W = kkt_->inverse_mass.data();
  const double dt = dt_, y_before = y[row.row];
  const double d[3] = {q[b] - q[a], q[b + 1] - q[a + 1], q[b + 2] - q[a + 2]};
  const double length = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
  if (length == 0.0)  // without a direction there is no push
    return system_->distance.rest[row.row] > 0.0 ? std::numeric_limits<double>::quiet_NaN() : 0.0;
  const double to_unit = 1.0 / length;

  // J W J^T, then the projection
  double mobility = row.mobility, inverse = row.inverse;
  if (!row.isotropic) {
    mobility = 0.0;
    for (int c = 0; c < 3; ++c) mobility += d[c] * d[c] * (W[a + c] + W[b + c]) * to_unit * to_unit;
    if (mobility + row.gamma == 0.0) return 0.0;
    inverse = 1.0 / (mobility + row.gamma);
  }
  const double dy = -share * inverse * ((length - row.target) * rate_ + row.gamma * y_before);
  y[row.row] = y_before + dy;

  // nodes that do not move are shared among the rows of a colour: not written to
  const double pull = dy * to_unit;
  for (int c = 0; c < 3 && row.moves_a; ++c) {
    const double push = pull * d[c], dv = W[a + c] * push;
    v[a + c] -= dv;
    q[a + c] -= dt * dv;
    if constexpr (kBooks) impulse[a + c] -= push;
  }
  for (int c = 0; c < 3 && row.moves_b; ++c) {
    const double push = pull * d[c], dv = W[b + c] * push;
    v[b + c] += dv;
    q[b + c] += dt * dv;
    if constexpr (kBooks) impulse[b + c] += push;
  }
  return dy * dy * mobility;
}

template <class Row>
double RowSweep::project_stencil(const Row& row, const Stencil& stencil, double share, VectorXd& q,
                                 VectorXd& v, VectorXd& y, double* impulse) const {
  constexpr int kMost = 3 * Row::kNodes;
  const System& s = *system_;
  const int* node = s.stencil_nodes.data() + stencil.first_node;
  const int nodes = stencil.nodes, places = s.places();
  using Rows = Eigen::Matrix<double, Row::kRows, kMost, Eigen::RowMajor>;
  using Nodes = Eigen::Matrix<double, kMost, 1>;
  Eigen::Matrix<double, Row::kRows, 1> phi, dy;
  Rows J, JW;
  Nodes W;
  if (!row.evaluate(q.data(), phi.data(), J.data())) return std::numeric_limits<double>::quiet_NaN();
  if (nodes < Row::kNodes) widen<Row::kRows, kMost>(3 * nodes, J.data());
  for (int i = 0; i < nodes; ++i) {
    for (int c = 0; c < 3; ++c) W[3 * i + c] = kkt_->inverse_mass[3 * node[i] + c];
    if (node[i] < places) continue;
    const Turn turn(dt_, v.data() + 3 * node[i]);
    if (turn.small())
      turn.template take_rows_over<Row::kRows, kMost>(J.data() + 3 * i);
    else
      J.template middleCols<3>(3 * i) *= right_jacobian(turn.vector());
  }
  for (int c = 3 * nodes; c < kMost; ++c) W[c] = 0.0;

  // its scalar rows in turn, phi following the velocity linearly, by J W J^T dy
  JW = J * W.asDiagonal();
  const Eigen::Matrix<double, Row::kRows, Row::kRows> mobility = JW.lazyProduct(J.transpose());
  double change = 0.0, inverse[Row::kRows];
  for (int i = 0; i < Row::kRows; ++i) {
    const double diagonal = mobility(i, i) + kkt_->gamma[stencil.first_row + i];
    inverse[i] = diagonal == 0.0 ? 0.0 : share / diagonal;
  }
  for (int i = 0; i < Row::kRows; ++i) {
    const int k = stencil.first_row + i;
    double g = (phi[i] - (*remembered_)[k]) * rate_ + kkt_->gamma[k] * y[k];
    for (int j = 0; j < i; ++j) g += mobility(i, j) * dy[j];
    dy[i] = -inverse[i] * g;
    y[k] += dy[i];
    change = larger(change, dy[i] * dy[i] * mobility(i, i));
  }
  const Nodes dv = JW.transpose().lazyProduct(dy);

  // q where v leads
  for (int i = 0; i < nodes; ++i) {
    const int n = node[i];
    if (s.free[n] == kPinned) continue;
    if (impulse) Eigen::Map<Vector3d>(impulse + 3 * n) += J.template middleCols<3>(3 * i).transpose() * dy;
    for (int c = 0; c < 3; ++c) v[3 * n + c] += dv[3 * i + c];
    if (n < places) {
      for (int c = 0; c < 3; ++c) q[3 * n + c] += dt_ * dv[3 * i + c];
      continue;
    }
    const double* start = q_start_->data() + s.bodies[n - places].quaternion;
    double* out = q.data() + s.bodies[n - places].quaternion;
    const Turn by(dt_, v.data() + 3 * n);
    if (by.small()) {
      by.turn_from(start, out);
    } else {
      std::copy_n(start, 4, out);
      turn(by.vector(), RotationUpdate::kExponential, out);
    }
  }
  return change;
}

template <bool kBooks>
double RowSweep::sweep_colour(const Colour& colour, double share, VectorXd& q, VectorXd& v, VectorXd& y,
                              double* impulse) {
  double change = largest_of(static_cast<int>(colour.distance.size()), [&](int i) {
    return project_distance<kBooks>(colour.distance[i], share, q.data(), v.data(), y.data(), impulse);
  });
  std::size_t type = 0;
  for_each_stencil_row_type(system_->stencil_rows, [&](const auto& list) {
    const std::vector<int>& which = colour.stencil[type];
    const int first = first_stencil_[type++];
    change = larger(change, largest_of(static_cast<int>(which.size()), [&](int i) {
                      return project_stencil(list[which[i]], system_->stencils[first + which[i]], share, q, v,
                                             y, kBooks ? impulse : nullptr);
                    }));
  });
  return change;
}

Status RowSweep::name_failure(const VectorXd& q) const {
  Kkt kkt;
  kkt.prepare(*system_);
  if (Status status = kkt.evaluate(q); !status.ok()) return status;
  return Status::failure(StatusCode::kNonFinite, "a sweep over the rows is not finite");
}

Status RowSweep::sweep(RowWeights weights, VectorXd& q, VectorXd& v, VectorXd& y, VectorXd* impulse,
                       double& change) {
  const double share = weights == RowWeights::kHalved ? 0.5 : 1.0;
  change = 0.0;
  for (const Colour& colour : colours_) {
    const double moved = impulse ? sweep_colour<true>(colour, share, q, v, y, impulse->data())
                                 : sweep_colour<false>(colour, share, q, v, y, nullptr);
    if (!(moved >= 0.0)) return name_failure(q);
    change = std::max(change, moved);
  }
  change = std::sqrt(change);
  return {};
}

}  // namespace feder
