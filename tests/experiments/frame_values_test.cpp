// What the files of numbers say, read back with nothing of the writers.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <bit>
#include <cstdlib>
#include <cstring>

#include "engine/energy.h"
#include "engine/kkt.h"
#include "experiments/support/table.h"
#include "tests/experiments/frame_sample.h"
#include "tests/experiments/temporary_folder.h"

namespace feder::experiments {
namespace {

constexpr std::int64_t kFrames = 4;

/// The files of the first frames of the sample.
struct Written {
  Scene scene = sample_scene();
  TemporaryFolder folder;
  Written() { write_sample(scene, kFrames, folder.path()); }
  Table table(const char* name) const { return from_csv(read_file(folder.path() / name), name); }
};

double value(const Table& table, std::size_t row, std::string_view column) {
  const std::string text = table.at(row, column).text();
  EXPECT_FALSE(text.empty()) << column;
  return std::strtod(text.c_str(), nullptr);
}

/// Equal bits, the sign of 0 included.
void expect_same(double read, double expected, const std::string& what) {
  EXPECT_EQ(std::bit_cast<std::uint64_t>(read), std::bit_cast<std::uint64_t>(expected))
      << what << ": " << read << " is not " << expected;
}

TEST(StatesCsv, HoldsPlacesAndVelocitiesBitwise) {
  const Written written;
  const Table table = written.table("states.csv");
  std::size_t row = 0;
  for (std::int64_t i = 0; i < kFrames; ++i) {
    const State state = sample_state(written.scene, i);
    for (const SceneNode& node : written.scene.nodes) {
      EXPECT_EQ(table.at(row, "name").text(), node.name);
      expect_same(value(table, row, "t"), state.t, "t");
      for (int c = 0; c < 3; ++c) {
        const std::string axis(1, "xyz"[c]);
        expect_same(value(table, row, axis), state.q[3 * node.node + c], node.name + "." + axis);
        expect_same(value(table, row, "v" + axis), state.v[3 * node.node + c], node.name + ".v" + axis);
      }
      ++row;
    }
  }
  EXPECT_EQ(table.rows(), row);
}

TEST(StatesCsv, TurnsTheAxesABodyWasGivenIn) {
  const Written written;
  const Table table = written.table("states.csv");
  double largest_tilt = 0.0;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const std::size_t nodes = written.scene.nodes.size();
    const SceneNode& node = written.scene.nodes[row % nodes];
    if (node.body < 0) {
      for (const char* column : {"qw", "qx", "qy", "qz", "wx", "wy", "wz"})
        EXPECT_TRUE(table.at(row, column).empty()) << node.name << " " << column;
      continue;
    }
    const State state = sample_state(written.scene, static_cast<std::int64_t>(row / nodes));
    const Body& body = written.scene.model.system.bodies[node.body];
    const Eigen::Quaterniond q(value(table, row, "qw"), value(table, row, "qx"), value(table, row, "qy"),
                               value(table, row, "qz"));
    EXPECT_NEAR(q.norm(), 1.0, 4e-16);  // measured 0
    // measured 3.4e-16
    EXPECT_LT((q.toRotationMatrix() - orientation(body, state.q)).cwiseAbs().maxCoeff(), 2e-15) << node.name;
    for (int c = 0; c < 3; ++c)
      expect_same(value(table, row, std::string("w") + "xyz"[c]), angular_velocity(body, state)[c],
                  node.name);
    largest_tilt = std::max(largest_tilt, (body.axes - Matrix3d::Identity()).norm());
  }
  EXPECT_GT(largest_tilt, 0.5);  // measured 1.6: the given axes are not the principal ones
}

TEST(StatesCsv, QuotesNames) {
  const Written written;
  const std::string text = read_file(written.folder.path() / "states.csv");
  EXPECT_NE(text.find(",\"with,comma\","), std::string::npos);
  EXPECT_NE(text.find(",\"say \"\"hi\"\"\","), std::string::npos);
  EXPECT_NE(text.find(",<box> & more,"), std::string::npos);
}

TEST(TrajectoryCsv, HoldsTheWholeStateBitwise) {
  const Written written;
  const Table table = written.table("trajectory.csv");
  ASSERT_EQ(table.rows(), static_cast<std::size_t>(kFrames));
  for (std::int64_t i = 0; i < kFrames; ++i) {
    const State state = sample_state(written.scene, i);
    VectorXd all(1 + state.q.size() + state.v.size());
    all << state.t, state.q, state.v;
    ASSERT_EQ(table.columns().size(), static_cast<std::size_t>(all.size()));
    for (Eigen::Index k = 0; k < all.size(); ++k)
      expect_same(value(table, static_cast<std::size_t>(i), table.columns()[k]), all[k], table.columns()[k]);
  }
}

TEST(TrajectoryCsv, NamesEachNumberByItsNode) {
  const Written written;
  const Table table = written.table("trajectory.csv");
  const System& s = written.scene.model.system;
  for (std::size_t i = 0; i < kFrames; ++i) {
    const State state = sample_state(written.scene, static_cast<std::int64_t>(i));
    for (const SceneNode& node : written.scene.nodes) {
      expect_same(value(table, i, node.name + ".y"), state.q[3 * node.node + 1], node.name);
      expect_same(value(table, i, node.name + ".vz"), state.v[3 * node.node + 2], node.name);
      if (node.body < 0) continue;
      expect_same(value(table, i, node.name + ".qx"), state.q[s.bodies[node.body].quaternion + 1], node.name);
      expect_same(value(table, i, node.name + ".wy"), state.v[3 * s.bodies[node.body].spin + 1], node.name);
    }
  }
}

TEST(TrajectoryNpy, HoldsTheWholeStateBitwise) {
  const Written written;
  const std::string text = read_file(written.folder.path() / "trajectory.npy");
  const State first = sample_state(written.scene, 0);
  const Eigen::Index columns = 1 + first.q.size() + first.v.size();
  ASSERT_EQ(text.size(), 128 + 8 * static_cast<std::size_t>(kFrames * columns));
  for (std::int64_t i = 0; i < kFrames; ++i) {
    const State state = sample_state(written.scene, i);
    VectorXd all(columns), read(columns);
    all << state.t, state.q, state.v;
    std::memcpy(read.data(), text.data() + 128 + 8 * i * columns, 8 * static_cast<std::size_t>(columns));
    for (Eigen::Index k = 0; k < columns; ++k) expect_same(read[k], all[k], std::to_string(k));
  }
}

TEST(TrajectoryNpy, HasTheHeaderOfNumPysFormat) {
  const Written written;
  const std::string text = read_file(written.folder.path() / "trajectory.npy").substr(0, 128);
  EXPECT_EQ(text.substr(0, 10), std::string("\x93NUMPY\x01\x00\x76\x00", 10));
  const State state = sample_state(written.scene, 0);
  EXPECT_EQ(text.substr(10, text.find('}') - 9),
            "{'descr': '<f8', 'fortran_order': False, 'shape': (                  4, " +
                std::to_string(1 + state.q.size() + state.v.size()) + "), }");
  EXPECT_EQ(text.back(), '\n');
}

TEST(RowsCsv, HoldsViolationsAndForcesOfEveryRowType) {
  const Written written;
  const Table table = written.table("rows.csv");
  EXPECT_EQ(table.distinct("type").size(), 8u);  // distance and the seven stencil types
  std::size_t line = 0;
  for (std::int64_t i = 0; i < kFrames; ++i) {
    const State state = sample_state(written.scene, i);
    const History history = sample_history(written.scene, i);
    VectorXd phi;
    evaluate_phi(written.scene.model.system, state.q, phi);
    for (const SceneRow& row : written.scene.rows)
      for (int c = 0; c < row.rows; ++c, ++line) {
        EXPECT_EQ(table.at(line, "name").text(), row.name);
        EXPECT_EQ(table.at(line, "component").text(), std::to_string(c));
        expect_same(value(table, line, "t"), state.t, "t");
        expect_same(value(table, line, "phi"), phi[row.first_row + c], row.name);
        if (i == 0)
          EXPECT_TRUE(table.at(line, "lambda").empty());
        else
          expect_same(value(table, line, "lambda"), history.lambda[row.first_row + c], row.name);
      }
  }
  EXPECT_EQ(table.rows(), line);
}

TEST(EnergyCsv, HoldsEnergiesAndMomentaBitwise) {
  const Written written;
  const Table table = written.table("energy.csv");
  const System& s = written.scene.model.system;
  ASSERT_EQ(table.rows(), static_cast<std::size_t>(kFrames));
  for (std::size_t i = 0; i < kFrames; ++i) {
    const State state = sample_state(written.scene, static_cast<std::int64_t>(i));
    expect_same(value(table, i, "kinetic"), kinetic_energy(s, state), "kinetic");
    expect_same(value(table, i, "rows"), row_energy(s, state), "rows");
    expect_same(value(table, i, "external"), external_energy(s, state), "external");
    expect_same(value(table, i, "total"), total_energy(s, state), "total");
    for (int c = 0; c < 3; ++c) {
      expect_same(value(table, i, std::string("p") + "xyz"[c]), linear_momentum(s, state)[c], "p");
      expect_same(value(table, i, std::string("l") + "xyz"[c]), angular_momentum(s, state)[c], "l");
    }
  }
}

}  // namespace
}  // namespace feder::experiments
