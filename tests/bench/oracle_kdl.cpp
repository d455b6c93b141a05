// Inverse kinematics beside Orocos KDL: the same arms, targets and tolerance, one thread, alternating in one
// run; medians and quartiles of processor time. Targets are poses of random joints within the limits. A solve
// counts if the joints are within their limits and the pose is met, by our own table, to 1e-5 m and rad; a
// second column counts 1e-10. KDL sees no rotation below 1e-6 rad (its `epsilon`), hence the tolerance of
// 1e-6; ours also with 1e-11.
// Of KDL: "newton" is Newton-Raphson with joint limits (ChainIkSolverPos_NR_JL) from the middle of the
// limits; "newton, restarts" the same from up to 200 starts, at random after the first; "lma"
// Levenberg-Marquardt (ChainIkSolverPos_LMA), which knows no limits.
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainiksolverpos_lma.hpp>
#include <kdl/chainiksolverpos_nr_jl.hpp>
#include <kdl/chainiksolvervel_pinv.hpp>
#include <random>
#include <string>
#include <vector>

#include "models/robot/arms.h"
#include "solvers/inverse_kinematics.h"

namespace feder {
namespace {

constexpr double kTolerance = 1e-6, kMet = 1e-5, kMetWell = 1e-10;  // of place [m] and angle [rad]
constexpr int kStarts = 200, kIterations = 100;

// Of this thread: less disturbed by what else runs than time on the wall.
double processor_us() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e6 * static_cast<double>(t.tv_sec) + 1e-3 * static_cast<double>(t.tv_nsec);
}

KDL::Frame to_kdl(const Pose& p) {
  const Matrix3d& R = p.rotation;
  return {KDL::Rotation(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)),
          KDL::Vector(p.position.x(), p.position.y(), p.position.z())};
}

KDL::Chain chain_of(const Arm& arm) {
  KDL::Chain chain;
  for (const DhRow& row : arm.rows) {
    const KDL::Joint joint(row.prismatic ? KDL::Joint::TransZ : KDL::Joint::RotZ);
    if (arm.convention == DhConvention::kStandard) {
      chain.addSegment(KDL::Segment(joint, KDL::Frame::DH(row.a, row.alpha, row.d, row.theta)));
    } else {
      chain.addSegment(
          KDL::Segment(KDL::Joint(KDL::Joint::Fixed), KDL::Frame::DH_Craig1989(row.a, row.alpha, 0.0, 0.0)));
      chain.addSegment(KDL::Segment(joint, KDL::Frame::DH(0.0, 0.0, row.d, row.theta)));
    }
  }
  chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::Fixed), to_kdl(arm.tool)));
  return chain;
}

VectorXd draw(std::mt19937_64& random, const KinematicMap& map) {
  VectorXd q(map.joints());
  for (int i = 0; i < q.size(); ++i)
    q[i] = map.least[i] + (map.greatest[i] - map.least[i]) * (static_cast<double>(random() >> 11) * 0x1p-53);
  return q;
}

struct Rival {
  std::string name;
  std::function<VectorXd(const Pose& target)> solve;
  std::vector<double> us = {};
  int reached = 0, well = 0, outside = 0;  ///< `outside`: pose met, limits not kept

  double at(double fraction) {
    std::sort(us.begin(), us.end());
    return us[static_cast<std::size_t>(fraction * static_cast<double>(us.size() - 1) + 0.5)];
  }
};

// What is left of place and angle, the larger.
double miss(const Arm& arm, const VectorXd& q, const Pose& target) {
  const Pose tool = tool_pose(arm, q);
  return std::max((tool.position - target.position).norm(),
                  rotation_vector(target.rotation * tool.rotation.transpose()).norm());
}

void compare(const ArmInfo& info, int targets) {
  const Arm arm = info.make();
  const KinematicMap map = kinematic_map(arm);
  const VectorXd middle = 0.5 * (map.least + map.greatest);
  const int n = map.joints();
  InverseKinematics one(map, {.tolerance = kTolerance, .most_starts = 1, .most_iterations = kIterations});
  InverseKinematics many(map,
                         {.tolerance = kTolerance, .most_starts = kStarts, .most_iterations = kIterations});

  InverseKinematics sharp(map, {.tolerance = 1e-11, .most_starts = kStarts, .most_iterations = kIterations});

  const KDL::Chain chain = chain_of(arm);
  KDL::ChainFkSolverPos_recursive forward(chain);
  KDL::ChainIkSolverVel_pinv velocity(chain);
  KDL::JntArray least(n), greatest(n);
  least.data = map.least, greatest.data = map.greatest;
  KDL::ChainIkSolverPos_NR_JL newton(chain, least, greatest, forward, velocity, kIterations, kTolerance);
  KDL::ChainIkSolverPos_LMA lma(chain, Eigen::Matrix<double, 6, 1>::Ones(), kTolerance, 500, 1e-15);
  KDL::JntArray from(n), to(n);
  auto newton_from = [&](const VectorXd& start, const KDL::Frame& target) {
    from.data = start;
    return newton.CartToJnt(from, target, to) >= 0;
  };

  std::vector<Rival> rivals = {
      {"ours, one start", [&](const Pose& target) { return one.solve(target, middle).q; }},
      {"KDL newton",
       [&](const Pose& target) -> VectorXd {
         newton_from(middle, to_kdl(target));
         return to.data;
       }},
      {"KDL lma",
       [&](const Pose& target) -> VectorXd {
         from.data = middle;
         lma.CartToJnt(from, to_kdl(target), to);
         return to.data;
       }},
      {"ours", [&](const Pose& target) { return many.solve(target, middle).q; }},
      {"ours, to 1e-11", [&](const Pose& target) { return sharp.solve(target, middle).q; }},
      {"KDL newton, restarts", [&](const Pose& target) -> VectorXd {
         const KDL::Frame frame = to_kdl(target);
         std::mt19937_64 random(1);
         for (int start = 0; start < kStarts; ++start)
           if (newton_from(start == 0 ? middle : draw(random, map), frame)) break;
         return to.data;
       }}};

  std::mt19937_64 random(2026);
  double apart = 0.0;
  for (int i = 0; i < targets; ++i) {
    const VectorXd q = draw(random, map);
    const Pose target = tool_pose(arm, q);
    // both see the same arm
    KDL::Frame seen;
    from.data = q;
    forward.JntToCart(from, seen);
    apart = std::max(apart, (seen.p - to_kdl(target).p).Norm());
    for (Rival& rival : rivals) {
      const double start = processor_us();
      const VectorXd found = rival.solve(target);
      rival.us.push_back(processor_us() - start);
      const double left = found.allFinite() ? miss(arm, found, target) : 1.0;
      if (!(left < kMet)) continue;
      const bool within =
          (found.array() >= map.least.array()).all() && (found.array() <= map.greatest.array()).all();
      ++(within ? rival.reached : rival.outside);
      rival.well += within && left < kMetWell;
    }
  }
  std::printf("\n%s: %d targets; tool places of both differ by at most %.1e m\n", arm.name.c_str(), targets,
              apart);
  std::printf("  %-22s %10s %10s %15s %10s %10s %10s\n", "", "reached", "to 1e-10", "outside limits",
              "median us", "quartile 1", "quartile 3");
  for (Rival& rival : rivals)
    std::printf("  %-22s %9.2f%% %9.2f%% %14.2f%% %10.1f %10.1f %10.1f\n", rival.name.c_str(),
                100.0 * rival.reached / targets, 100.0 * rival.well / targets,
                100.0 * rival.outside / targets, rival.at(0.5), rival.at(0.25), rival.at(0.75));
}

}  // namespace
}  // namespace feder

int main(int argc, char** argv) {
  const int targets = argc > 1 ? std::max(1, std::atoi(argv[1])) : 2000;
  for (const feder::ArmInfo& info : feder::arm_list())
    if (info.make().task.size() == 6) feder::compare(info, targets);
}
