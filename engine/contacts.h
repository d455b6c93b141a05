#pragma once

#include <cstdint>
#include <tuple>
#include <utility>
#include <vector>

#include "engine/collider.h"
#include "engine/geometry/broad_phase.h"
#include "engine/geometry/manifold.h"

namespace feder {

struct System;

/// A point where two colliders touch or may touch within the step. Its three rows are the velocity of b
/// against a along the axes of `frame`: the normal from a to b, then two tangents. The normal row is
/// unilateral: u_n >= 0 where the gap is closed; the tangents carry friction.
struct Contact {
  int a = -1, b = -1;  ///< colliders
  ContactPoint at;
  Matrix3d frame;  ///< rows: normal, tangents [1]
  Surface surface;
  int first_block = 0, blocks = 0;

  /// Persistent identity: what warm starts and ordering go by.
  auto key() const { return std::tuple(a, b, at.feature); }
};

/// Rows generated from a state and valid for one step, sorted by key.
struct ContactRows {
  struct Block {
    int node;
    Matrix3d J;  ///< d u / d v of the node's three coordinates, 0 where masked
  };
  std::vector<Contact> contacts;
  std::vector<Block> blocks;
  VectorXd driven;  ///< u that prescribed motion alone gives, 3 per contact [m/s]

  int count() const { return static_cast<int>(contacts.size()); }
  /// Only the contacts at these places.
  ContactRows subset(const std::vector<int>& some) const;
  /// Drops the contacts whose gap is larger [m].
  void keep_within(double gap);
  /// u = J v + driven, 3 per contact [m/s].
  void velocities(const VectorXd& v, VectorXd& u) const;
  /// u = J v.
  void multiply(const VectorXd& v, VectorXd& u) const;
  /// out += J^T y, y 3 impulses per contact in its frame [N s].
  void add_impulses(const VectorXd& y, VectorXd& out) const;
};

/// The two tangents that make a right-handed frame with n, continuous but at n = -z.
Matrix3d contact_frame(const Vector3d& normal);

/// Finds contacts of one system again and again; keeps its broad phase between calls.
class ContactFinder {
 public:
  explicit ContactFinder(const System& system);
  /// All contacts whose gap is within what the colliders may close in dt [s] at their velocities and under
  /// constant forces, twice over.
  void find(const State& state, double dt, ContactRows& out);
  /// Smallest gap over all pairs that are nearer than `margin` [m]; `margin` if none is.
  double smallest_gap(const State& state, double margin);

 private:
  bool may_touch(int a, int b) const;
  void candidates(const State& state, double dt, double margin);

  const System& system_;
  std::vector<std::pair<int, int>> joined_;  // bodies that a row joins: they pass through each other
  BroadPhase broad_phase_;
  std::vector<Aabb> boxes_;
  std::vector<Pose> poses_;
  std::vector<double> margins_;
  std::vector<std::pair<int, int>> pairs_;
  std::vector<ContactPoint> points_;
};

}  // namespace feder
