// What one projection of a row costs beside a direct solve, in turn in one run, one thread:
//   sweeps over the rows at the places one step of 1/60 s leads to, against factor + solve of that step
#include <algorithm>
#include <cstdio>
#include <vector>

#include "models/catalog.h"
#include "solvers/row_sweep.h"
#include "solvers/stopwatch.h"
#include "solvers/threads.h"

namespace feder {
namespace {

constexpr double kFrame = 1.0 / 60.0;  // [s]
constexpr int kPairs = 21;
constexpr double kRowsTimed = 2e6;  // in one timing of the sweeps

double quantile(std::vector<double> values, double fraction) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(fraction * static_cast<double>(values.size() - 1) + 0.5)];
}

Status factor_and_solve(LinearSolver& solver, Kkt& kkt, VectorXd& v, VectorXd& y) {
  if (Status status = solver.factor(kkt); !status.ok()) return status;
  return solver.solve(kkt, v, y).status;
}

Status measure(const char* spec) {
  const Model model = make_model(spec);
  const System& s = model.system;
  Kkt kkt;
  kkt.prepare(s);
  kkt.set_step(kFrame * kFrame, kFrame);
  LinearSolver solver("auto");
  if (Status status = kkt.evaluate(model.state.q, false); !status.ok()) return status;
  if (Status status = solver.analyze(s, false); !status.ok()) return status;
  kkt.p = kFrame * s.forces.constant;
  kkt.r = kkt.phi / kFrame;
  VectorXd v, y;
  // untimed once: the rank of redundant rows is looked at here
  if (Status status = factor_and_solve(solver, kkt, v, y); !status.ok()) return status;

  RowSweep sweep;
  sweep.prepare(s);
  const VectorXd remembered = VectorXd::Zero(s.rows);
  sweep.begin(kFrame, kkt, remembered, model.state.q);
  const double rows = static_cast<double>(sweep.order().size());
  const int sweeps = static_cast<int>(std::max(1.0, kRowsTimed / rows));
  std::vector<double> projection, direct, ratio;
  for (int i = 0; i < kPairs; ++i) {
    double seconds = 0.0;
    {
      const Stopwatch watch(seconds);
      if (Status status = factor_and_solve(solver, kkt, v, y); !status.ok()) return status;
    }
    direct.push_back(seconds / rows);
    VectorXd q, swept_v = kkt.inverse_mass.cwiseProduct(kkt.p), swept_y = VectorXd::Zero(s.rows);
    advance(s, kFrame, swept_v, model.state.q, q);
    double change = 0.0;
    seconds = 0.0;
    {
      const Stopwatch watch(seconds);
      for (int j = 0; j < sweeps; ++j)
        if (Status status = sweep.sweep(RowWeights::kMass, q, swept_v, swept_y, nullptr, change);
            !status.ok())
          return status;
    }
    projection.push_back(seconds / (rows * sweeps));
    ratio.push_back(direct.back() / projection.back());
  }
  std::printf(
      "%-12s %8.0f rows, %2d colours: %6.1f ns per projection; %-12s %8.1f ns per row; ratio %6.2f [%.2f "
      "%.2f]\n",
      spec, rows, sweep.colours(), 1e9 * quantile(projection, 0.5), solver.route_name().c_str(),
      1e9 * quantile(direct, 0.5), quantile(ratio, 0.5), quantile(ratio, 0.25), quantile(ratio, 0.75));
  return {};
}

}  // namespace
}  // namespace feder

int main(int, char** argv) {
  feder::restart_with_better_blas(argv);
  feder::set_threads(1);
  std::printf("factor + solve over one projection, per row: median [quartiles] of %d pairs\n", feder::kPairs);
  int code = 0;
  for (const char* spec : {"S1(1000)", "S1(100000)", "S2(50)", "S2(100)", "S3c(1000)", "S3b(30,10)"})
    if (const feder::Status status = feder::measure(spec); !status.ok()) {
      std::printf("%-12s %s\n", spec, status.reason.c_str());
      code = 3;
    }
  return code;
}
