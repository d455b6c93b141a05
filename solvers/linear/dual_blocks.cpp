#include "solvers/linear/dual_blocks.h"

#include <algorithm>
#include <numeric>

#include "solvers/linear/cholmod_factor.h"

namespace feder {
namespace {

/// Balls are one row type of many: where their stencils lie.
struct Balls {
  int first = 0, count = 0;
};

Balls ball_stencils(const System& s) {
  Balls balls;
  int at = 0;
  for_each_stencil_row_type(s.stencil_rows, [&](const auto& list) {
    const int size = static_cast<int>(list.size());
    if constexpr (std::is_same_v<typename std::decay_t<decltype(list)>::value_type, BallRow>)
      balls = {at, size};
    at += size;
  });
  return balls;
}

}  // namespace

std::string DualBlocks::refusal(const System& s, bool geometric) {
  if (geometric) return "block route needs a block diagonal Mt: geometric stiffness couples nodes";
  const Balls balls = ball_stencils(s);
  for (int k = 0; k < s.rows; ++k) {
    const bool ball = balls.count > 0 && k >= s.stencils[balls.first].first_row &&
                      k < s.stencils[balls.first].first_row + 3 * balls.count;
    if (s.active(k) && !ball) return "block route takes ball joints only: " + s.row_name(k);
    if (!s.active(k) && ball) return "block route takes active rows only: " + s.row_name(k);
  }
  return balls.count > 0 ? "" : "block route takes ball joints only: there are none";
}

// A chain goes from both ends to its middle: two columns at a time (BlockCholesky).
std::vector<int> DualBlocks::order_joints(const std::vector<std::pair<int, int>>& edges, int joints) {
  const Ordering ordering = fill_reducing_order(joints, edges, BlockCholesky::kBlock);
  ordering_ = ordering.name;
  const bool chain = std::all_of(edges.begin(), edges.end(),
                                 [](const auto& edge) { return std::abs(edge.first - edge.second) == 1; });
  if (!chain || ordering.name != "natural") return ordering.order;
  ordering_ = "two-ended";
  std::vector<int> order(joints / 2);
  std::iota(order.begin(), order.end(), 0);
  for (int i = joints - 1; i >= joints / 2; --i) order.push_back(i);
  return order;
}

Status DualBlocks::analyze(const System& s, bool) {
  system_ = &s;
  first_row_.clear(), diagonal_.clear(), products_.clear();
  const Balls balls = ball_stencils(s);
  struct Incident {
    int joint, offset, stride;
  };
  std::vector<std::vector<Incident>> at_node(s.nodes);
  for (int i = 0; i < balls.count; ++i) {
    const Stencil& stencil = s.stencils[balls.first + i];
    for (int k = 0; k < stencil.nodes; ++k)
      if (const int node = s.stencil_nodes[stencil.first_node + k]; s.free[node])
        at_node[node].push_back({i, stencil.jacobian + 3 * k, 3 * stencil.nodes});
  }
  std::vector<std::pair<int, int>> edges;
  for (const auto& here : at_node)
    for (std::size_t i = 0; i < here.size(); ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (here[i].joint != here[j].joint) edges.emplace_back(here[i].joint, here[j].joint);

  const std::vector<int> order = order_joints(edges, balls.count);
  std::vector<int> block(balls.count);
  for (int i = 0; i < balls.count; ++i) {
    block[order[i]] = i;
    first_row_.push_back(s.stencils[balls.first + order[i]].first_row);
  }
  for (auto& [i, j] : edges) i = block[i], j = block[j];
  factor_.analyze(balls.count, std::move(edges));
  for (int i = 0; i < balls.count; ++i) diagonal_.push_back(factor_.slot(i, i));
  for (int node = 0; node < s.nodes; ++node)
    for (const Incident& x : at_node[node])
      for (const Incident& y : at_node[node]) {
        const int i = block[x.joint], j = block[y.joint];
        if (i > j || &x == &y)
          products_.push_back({factor_.slot(i, j), x.offset, x.stride, y.offset, y.stride, 3 * node});
      }
  std::sort(products_.begin(), products_.end(), [](const Product& x, const Product& y) {
    return x.place != y.place ? x.place < y.place : x.left < y.left;
  });
  rhs_.assign(3 * static_cast<std::size_t>(balls.count), 0.0);
  scratch_y_ = VectorXd::Zero(s.rows);
  return {};
}

void DualBlocks::assemble(const Kkt& kkt) {
  double* values = factor_.values();
  std::fill_n(values, factor_.value_count(), 0.0);
  for (std::size_t i = 0; i < diagonal_.size(); ++i)
    for (int c = 0; c < 3; ++c) values[diagonal_[i] + 4 * c] = kkt.gamma[first_row_[i] + c];
  const double *J = kkt.jacobian.data(), *W = kkt.inverse_mass.data();
  for (const Product& p : products_) {
    double* out = values + p.place;
    const double *left = J + p.left, *w = W + p.coordinate;
    for (int c = 0; c < 3; ++c) {
      const double* right = J + p.right + c * p.right_stride;
      const double x = w[0] * right[0], y = w[1] * right[1], z = w[2] * right[2];
      for (int r = 0; r < 3; ++r) {
        const double* row = left + r * p.left_stride;
        out[3 * c + r] += row[0] * x + row[1] * y + row[2] * z;
      }
    }
  }
}

Status DualBlocks::factor(const Kkt&) {
  if (factor_.factor()) return {};
  const int column = factor_.failed_column();
  return Status::failure(StatusCode::kSingular, "dual Schur complement is not positive definite at " +
                                                    system_->row_name(first_row_[column / 3] + column % 3));
}

void DualBlocks::reduce(const Kkt& kkt, const VectorXd& b1, const VectorXd& b2) {
  // S y = -(b2 + J Mt^-1 b1)
  kkt.multiply_jacobian_inverse_mass(b1, scratch_y_);
  for (std::size_t i = 0; i < first_row_.size(); ++i)
    for (int c = 0; c < 3; ++c) rhs_[3 * i + c] = -(scratch_y_[first_row_[i] + c] + b2[first_row_[i] + c]);
}

void DualBlocks::substitute() {
  factor_.solve(rhs_.data());
}

void DualBlocks::expand(const Kkt& kkt, const VectorXd& b1, const VectorXd&, VectorXd& v, VectorXd& y) {
  y.setZero(system_->rows);
  for (std::size_t i = 0; i < first_row_.size(); ++i)
    for (int c = 0; c < 3; ++c) y[first_row_[i] + c] = rhs_[3 * i + c];
  // v = Mt^-1 (b1 + J^T y)
  v = b1;
  kkt.add_jacobian_transpose(y, v);
  kernels().product(v.size(), v.data(), kkt.inverse_mass.data(), v.data());
}

}  // namespace feder
