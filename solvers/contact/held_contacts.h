#pragma once

#include <vector>

#include "engine/contacts.h"
#include "engine/kkt.h"

namespace feder {

/// Contacts of particles with what does not move: thousands of them where a net lies on an obstacle. Each
/// acts on one node, so what it adds to the step matrix stays inside that node's diagonal block: the pattern
/// and its analysis are those of the free net, and one factorisation holds all contacts that are in it.
///
/// Augmented Lagrangian: with z = y - P u, P a multiple of the node's own diagonal, the impulse is z
/// projected into the contact law (z_n >= 0, |z_t| <= mu z_n). A step of Newton puts -d(impulse)/d v into the
/// blocks:
///   open 0,   stick P E,   slide P n n^T + (mu y_n / |z_t|) P (E - d d^T) on the tangents, d = z_t/|z_t|
/// and y becomes the impulse found. Every pass over it gains a factor of order A_ii/P and of friction's
/// coupling; a new factorisation is due only where a contact opens, closes, sticks or slips.
class HeldContacts {
 public:
  /// Takes its contacts of `rows`; `others` <- the indices of those it leaves.
  void take(const System& system, const ContactRows& rows, std::vector<int>& others);
  const std::vector<int>& taken() const { return index_; }
  /// Starts from the impulses of the last step (3 per contact of `rows`, 0 where it is new) and velocity v.
  void start(double dt, const Kkt& kkt, const ContactRows& rows, const VectorXd& target,
             const VectorXd& remembered, const VectorXd& v);
  /// Blocks of the present branches into the matrix; to be factored again. The number of contacts that
  /// changed their branch since the last call.
  int put_into(Kkt& kkt, const ContactRows& rows);
  /// p += what the blocks need on the right-hand side.
  void add_right_hand_side(const ContactRows& rows, VectorXd& p) const;
  /// After a solve with velocity v: impulses as they acted in it, branches and multipliers for the next pass.
  /// Returns how many contacts left the branch their block is for.
  int update(const ContactRows& rows, const VectorXd& v);
  /// Largest violation of the contact law by the impulses that acted [m/s].
  double violation() const { return violation_; }
  double block_work(const ContactRows& rows, const VectorXd& v) const;  ///< v.B v [J]
  /// Writes the impulses that acted into those of all contacts.
  void impulses(VectorXd& all) const;

  int count() const { return static_cast<int>(index_.size()); }
  bool empty() const { return index_.empty(); }
  bool used() const { return !blocks_used_.empty(); }  ///< blocks in the matrix, maybe of the last step

 private:
  enum class Branch { kOpen, kStick, kSlide };
  struct Held {
    int stencil;
    double penalty = 0.0;  // P [kg]
    double friction = 0.0, target = 0.0;
    Branch branch = Branch::kOpen, in_matrix = Branch::kOpen;
    Vector3d multiplier = Vector3d::Zero();  // y
    Vector3d impulse = Vector3d::Zero();     // by the law, at `velocity`
    Vector3d velocity = Vector3d::Zero();    // where the next block is taken
    Vector3d acted = Vector3d::Zero();       // in the last solve
    Matrix3d block = Matrix3d::Zero();       // -d impulse/d u of the matrix, in the frame
  };
  void linearise(Held& held) const;

  std::vector<int> index_;  // into the rows
  std::vector<Held> held_;
  std::vector<int> blocks_used_;  // stencils whose block is not zero
  VectorXd diagonal_;             // of the step matrix per node, without contacts [kg]
  double violation_ = 0.0;
};

}  // namespace feder
