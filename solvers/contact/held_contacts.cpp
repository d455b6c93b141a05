// Newton on the augmented Lagrangian, see the header. With B the block and u_0 the velocity it was taken at,
//   impulse(u) = impulse(u_0) - B (u - u_0),   so   (A + J^T B J) v = p + J^T (impulse(u_0) + B u_0)
#include "solvers/contact/held_contacts.h"

#include <algorithm>
#include <cmath>

namespace feder {
namespace {

using Vector2d = Eigen::Vector2d;

// P over the node's diagonal: what is left open by one pass is a 1/kPenalty of what the impulse changed.
constexpr double kPenalty = 1e4;
// A remembered impulse this close to the cone, relative, was sliding.
constexpr double kOnCone = 1e-6;

}  // namespace

void HeldContacts::take(const System& s, const ContactRows& rows, std::vector<int>& others) {
  index_.clear();
  others.clear();
  held_.clear();
  for (int i = 0; i < rows.count(); ++i) {
    const Contact& c = rows.contacts[i];
    const bool a = s.contact_stencil[c.a] >= 0 && s.colliders[c.b].fixed,
               b = s.contact_stencil[c.b] >= 0 && s.colliders[c.a].fixed;
    if (!a && !b) {
      others.push_back(i);
      continue;
    }
    index_.push_back(i);
    held_.push_back({s.contact_stencil[a ? c.a : c.b]});
    held_.back().friction = c.surface.friction;
  }
}

void HeldContacts::start(double dt, const Kkt& kkt, const ContactRows& rows, const VectorXd& target,
                         const VectorXd& remembered, const VectorXd& v) {
  // diagonal of Mt + J^T gamma^-1 J, a third of each block's trace and more
  const System& s = *kkt.system;
  diagonal_.setZero(s.nodes);
  for (int i = 0; i < s.nodes; ++i) diagonal_[i] = kkt.mass.segment<3>(3 * i).maxCoeff();
  for (int k = 0; k < s.distance.size(); ++k)
    for (int node : {s.distance.a[k], s.distance.b[k]}) diagonal_[node] += kkt.inverse_gamma[k];
  for (const Stencil& stencil : s.stencils)
    for (int row = 0; row < stencil.rows; ++row)
      for (int i = 0; i < stencil.nodes; ++i)
        diagonal_[s.stencil_nodes[stencil.first_node + i]] +=
            kkt.inverse_gamma[stencil.first_row + row] *
            kkt.jacobian.segment<3>(stencil.jacobian + 3 * (stencil.nodes * row + i)).squaredNorm();

  VectorXd u;
  rows.velocities(v, u);
  for (int k = 0; k < count(); ++k) {
    Held& held = held_[k];
    const int i = index_[k], node = s.stencil_nodes[s.stencils[held.stencil].first_node];
    held.penalty = kPenalty * diagonal_[node];
    held.target = target[i];
    held.multiplier = remembered.segment<3>(3 * i);  // into the cone: the frame has turned
    const double most = held.friction * std::max(0.0, held.multiplier[0]),
                 turned = held.multiplier.tail<2>().norm();
    if (turned > most) held.multiplier.tail<2>() *= most / turned;
    held.velocity = u.segment<3>(3 * i);
    const double fall =
        dt * (rows.contacts[i].frame.row(0) * kkt.system->forces.constant.segment<3>(3 * node)).value() /
        s.mass[node];
    const double side = s.colliders[rows.contacts[i].a].place.node == node ? -1.0 : 1.0;
    const bool closing = held.velocity[0] + side * fall < held.target;
    held.velocity[0] = 0.0;
    const double normal = held.multiplier[0], tangent = held.multiplier.tail<2>().norm();
    if (normal > 0.0)
      held.branch = tangent < (1.0 - kOnCone) * held.friction * normal ? Branch::kStick : Branch::kSlide;
    else
      held.branch = closing ? Branch::kSlide : Branch::kOpen;
    held.impulse = held.multiplier;
  }
}

void HeldContacts::linearise(Held& held) const {
  held.block.setZero();
  if (held.branch == Branch::kOpen) return;
  held.block(0, 0) = held.penalty;
  if (held.branch == Branch::kStick) {
    held.block(1, 1) = held.block(2, 2) = held.penalty;
    return;
  }
  const double length = held.friction * std::max(0.0, held.impulse[0]);
  const Vector2d z = held.multiplier.tail<2>() - held.penalty * held.velocity.tail<2>();
  const double size = z.norm();
  if (!(length > 0.0) || !(size > 0.0)) return;
  const Vector2d d = z / size;
  held.block.bottomRightCorner<2, 2>() =
      std::min(1.0, length / size) * held.penalty * (Eigen::Matrix2d::Identity() - d * d.transpose());
}

int HeldContacts::put_into(Kkt& kkt, const ContactRows& rows) {
  for (int stencil : blocks_used_) kkt.node_block(stencil).setZero();
  blocks_used_.clear();
  int changed = 0;
  for (int k = 0; k < count(); ++k) {
    Held& held = held_[k];
    changed += held.branch != held.in_matrix;
    held.in_matrix = held.branch;
    linearise(held);
    if (held.branch == Branch::kOpen) continue;
    const Contact& c = rows.contacts[index_[k]];
    const Matrix3d& J = rows.blocks[c.first_block].J;
    kkt.node_block(held.stencil) += J.transpose() * held.block * J;
    blocks_used_.push_back(held.stencil);
  }
  return changed;
}

// impulse(u_0) + B u_0, less what driven obstacles and targets already are; stick and normal rows in absolute
// terms, y + P target, since y - P u is what they are.
void HeldContacts::add_right_hand_side(const ContactRows& rows, VectorXd& p) const {
  for (int k = 0; k < count(); ++k) {
    const Held& held = held_[k];
    if (held.in_matrix == Branch::kOpen) continue;
    const int i = index_[k];
    const Vector3d driven = rows.driven.segment<3>(3 * i);
    Vector3d rhs = held.multiplier - held.block * driven;
    rhs[0] += held.penalty * held.target;
    if (held.in_matrix == Branch::kSlide)
      rhs.tail<2>() = held.impulse.tail<2>() +
                      held.block.bottomRightCorner<2, 2>() * (held.velocity.tail<2>() - driven.tail<2>());
    const ContactRows::Block& block = rows.blocks[rows.contacts[i].first_block];
    p.segment<3>(3 * block.node) += block.J.transpose() * rhs;
  }
}

int HeldContacts::update(const ContactRows& rows, const VectorXd& v) {
  int left = 0;
  violation_ = 0.0;
  for (int k = 0; k < count(); ++k) {
    Held& held = held_[k];
    const int i = index_[k];
    const ContactRows::Block& block = rows.blocks[rows.contacts[i].first_block];
    const Vector3d u = block.J * v.segment<3>(3 * block.node) + rows.driven.segment<3>(3 * i);

    // what acted, and what the law makes of it
    Vector3d acted = Vector3d::Zero();
    if (held.in_matrix != Branch::kOpen) {
      acted[0] = held.multiplier[0] - held.penalty * (u[0] - held.target);
      if (held.in_matrix == Branch::kStick)
        acted.tail<2>() = held.multiplier.tail<2>() - held.penalty * u.tail<2>();
      else
        acted.tail<2>() = held.impulse.tail<2>() -
                          held.block.bottomRightCorner<2, 2>() * (u.tail<2>() - held.velocity.tail<2>());
    }
    // what acted tells the normal force; where nothing acted the penalty would tell a far too large one
    Branch branch = Branch::kOpen;
    Vector3d law = Vector3d::Zero();
    if (held.in_matrix == Branch::kOpen) {
      if (u[0] < held.target) branch = Branch::kSlide;  // first without friction: sticking might pull
    } else if (!(acted[0] > 0.0)) {
      // sticking may pull where sliding pushes
      if (held.in_matrix == Branch::kStick) branch = Branch::kSlide;
    } else if (held.friction == 0.0) {
      law[0] = acted[0];
      branch = Branch::kSlide;
    } else {
      law = acted;
      branch = Branch::kStick;
      // a slip that friction has turned round can be held
      const bool turned = held.in_matrix == Branch::kSlide && u.tail<2>().dot(acted.tail<2>()) > 0.0;
      const Vector2d z = held.in_matrix == Branch::kSlide
                             ? Vector2d(held.multiplier.tail<2>() - held.penalty * u.tail<2>())
                             : Vector2d(acted.tail<2>());
      const double length = held.friction * acted[0], size = z.norm();
      if (!turned && size > length) {
        branch = Branch::kSlide;
        law.tail<2>() = z * (length / size);
      }
    }
    // natural map of (acted, u) with a step of 1 / diagonal
    const double step = held.penalty / kPenalty;
    const double normal = acted[0] - std::max(0.0, acted[0] - step * (u[0] - held.target));
    Vector2d tangent = acted.tail<2>() - step * u.tail<2>();
    const double reach = held.friction * std::max(0.0, acted[0]), long_by = tangent.norm();
    if (long_by > reach) tangent *= reach / long_by;
    violation_ = std::max({violation_, std::abs(normal) / step, (acted.tail<2>() - tangent).norm() / step});

    left += branch != held.in_matrix;
    held.branch = branch;
    held.impulse = law;
    held.velocity = u;
    held.multiplier = law;
    held.acted = acted;
  }
  return left;
}

double HeldContacts::block_work(const ContactRows& rows, const VectorXd& v) const {
  double sum = 0.0;
  for (int k = 0; k < count(); ++k) {
    const ContactRows::Block& block = rows.blocks[rows.contacts[index_[k]].first_block];
    const Vector3d u = block.J * v.segment<3>(3 * block.node);
    sum += u.dot(held_[k].block * u);
  }
  return sum;
}

void HeldContacts::impulses(VectorXd& all) const {
  for (int k = 0; k < count(); ++k) all.segment<3>(3 * index_[k]) = held_[k].acted;
}

}  // namespace feder
