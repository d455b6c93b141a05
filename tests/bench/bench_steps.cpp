// What a step costs around the factorisation: phases timed inside the same steps, one thread, medians, beside
// a bare CHOLMOD factor + solve of the same matrix in the same run, and beside the figures published for the
// peers (ms per step, dt = 1/60 s). Then whole leapfrog steps in spring evaluations per second, the project's
// scalar kernel against its widest.
#include <cholmod.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "models/catalog.h"
#include "solvers/simulate.h"
#include "solvers/stopwatch.h"
#include "solvers/threads.h"

namespace feder {
namespace {

double median(std::vector<double> x) {
  std::nth_element(x.begin(), x.begin() + static_cast<long>(x.size() / 2), x.end());
  return x[x.size() / 2];
}

// CHOLMOD alone, with the settings of CholmodFactor, on the matrix a route has just assembled.
class BareCholmod {
 public:
  BareCholmod() { cholmod_start(&common_); }
  ~BareCholmod() {
    cholmod_free_factor(&L_, &common_);
    cholmod_free_dense(&X_, &common_);
    cholmod_free_dense(&Y_, &common_);
    cholmod_free_dense(&E_, &common_);
    cholmod_finish(&common_);
  }
  BareCholmod(const BareCholmod&) = delete;
  BareCholmod& operator=(const BareCholmod&) = delete;

  double factor_and_solve(const SymmetricPattern& pattern, const std::vector<double>& values) {
    cholmod_sparse A{};
    A.nrow = A.ncol = static_cast<std::size_t>(pattern.size);
    A.nzmax = pattern.row.size();
    A.p = const_cast<int*>(pattern.column_start.data());
    A.i = const_cast<int*>(pattern.row.data());
    A.x = const_cast<double*>(values.data());
    A.stype = pattern.upper ? 1 : -1;
    A.itype = CHOLMOD_INT, A.xtype = CHOLMOD_REAL, A.dtype = CHOLMOD_DOUBLE;
    A.sorted = A.packed = 1;
    if (!L_) {
      common_.nmethods = 1, common_.method[0].ordering = CHOLMOD_NATURAL, common_.postorder = 0;
      common_.supernodal = pattern.upper ? CHOLMOD_SIMPLICIAL : CHOLMOD_AUTO, common_.final_ll = 1;
      L_ = cholmod_analyze(&A, &common_);
      rhs_.assign(A.nrow, 1.0);
    }
    cholmod_dense b{};
    b.nrow = b.d = b.nzmax = A.nrow, b.ncol = 1;
    b.x = rhs_.data(), b.xtype = CHOLMOD_REAL, b.dtype = CHOLMOD_DOUBLE;
    double seconds = 0.0;
    {
      const Stopwatch watch(seconds);
      cholmod_factorize(&A, L_, &common_);
      cholmod_solve2(CHOLMOD_A, L_, &b, nullptr, &X_, nullptr, &Y_, &E_, &common_);
    }
    return seconds;
  }

 private:
  cholmod_common common_{};
  cholmod_factor* L_ = nullptr;
  cholmod_dense *X_ = nullptr, *Y_ = nullptr, *E_ = nullptr;
  std::vector<double> rhs_;
};

struct Case {
  const char* scene;
  bool geometric;
  const char* route;
  double dt;
  int steps;
  double goal;  // for (step - factor - solve) / bare, 0: quoted only
  const char* peer;
};

template <class Step>
void measure_phases(const Case& c, Model model) {
  Step integrator(model.system, {.route = c.route});
  if (Status status = integrator.prepare(); !status.ok()) {
    std::printf("%-12s %s\n", c.scene, status.reason.c_str());
    return;
  }
  BareCholmod bare;
  DualSchur scalar;  // what CHOLMOD gets where the route keeps blocks of its own
  if (std::string(c.route) == DualBlocks::kName && !scalar.analyze(model.system, false).ok()) return;
  History history;
  std::vector<double> around, factor_solve, alone, refine, whole, ratio, shares[5];
  Status status;
  for (int k = 0; k < c.steps && status.ok(); ++k) {
    integrator.reset_times();
    status = integrator.step(c.dt, model.state, history, nullptr);
    const PhaseTimes& t = integrator.solver().times();
    const StepTimes& own = integrator.times();
    const double parts[5] = {own.evaluate, t.assemble, t.transfer, t.residual, own.update};
    const double b = std::visit(
        [&](const auto& route) {
          if constexpr (requires { route.values(); })
            return bare.factor_and_solve(route.pattern(), route.values());
          scalar.assemble(integrator.kkt());
          return bare.factor_and_solve(scalar.pattern(), scalar.values());
        },
        integrator.solver().route());
    double sum = 0.0;
    for (int i = 0; i < 5; ++i) shares[i].push_back(parts[i]), sum += parts[i];
    around.push_back(sum);
    factor_solve.push_back(t.factor + t.solve);
    refine.push_back(t.refine);
    alone.push_back(b);
    ratio.push_back(sum / b);
    whole.push_back(sum + t.factor + t.solve + t.refine);
  }
  std::sort(ratio.begin(), ratio.end());
  const double r = median(around) / median(alone);
  std::printf(
      "%-14s %-24s %-11s %8.3f %8.3f %6.3f [%5.3f %5.3f] %s%-5s %6.3f %8.3f |%6.1f%6.1f%6.1f%6.1f%6.1f | %ld "
      "refined | %s\n",
      c.scene, Step::kInfo.name, integrator.solver().route_name().c_str(), 1e3 * median(whole),
      1e3 * median(alone), r, ratio[ratio.size() / 4], ratio[3 * ratio.size() / 4],
      c.goal > 0.0 ? "<=" : "  ", c.goal > 0.0 ? std::to_string(c.goal).substr(0, 4).c_str() : "-",
      median(factor_solve) / median(alone), 1e3 * median(refine), 100 * median(shares[0]) / median(alone),
      100 * median(shares[1]) / median(alone), 100 * median(shares[2]) / median(alone),
      100 * median(shares[3]) / median(alone), 100 * median(shares[4]) / median(alone),
      integrator.solver().times().refinements, status.ok() ? c.peer : status.reason.c_str());
}

// Whole leapfrog steps with the kernels of that name: springs per second, best of several.
double springs_per_second(const Model& model, const char* kernel_name, double dt) {
  if (!select_kernels(kernel_name)) return 0.0;
  Leapfrog integrator(model.system, {});
  if (!integrator.prepare().ok()) return 0.0;
  State state = model.state;
  History history;
  double best = 1e300;
  for (int repeat = 0; repeat < 30; ++repeat) {
    double seconds = 0.0;
    {
      const Stopwatch watch(seconds);
      for (int k = 0; k < 100; ++k)
        if (!integrator.step(dt, state, history, nullptr).ok()) return 0.0;
    }
    best = std::min(best, seconds / 100.0);
  }
  return model.system.active_rows / best;
}

void run() {
  set_threads(1);
  std::printf("BLAS: %s\n\nImplicit Euler, ms per step and shares in %% of bare CHOLMOD (factor + solve)\n",
              blas_name().c_str());
  std::printf("%-14s %-24s %-11s %8s %8s %6s %-13s %-7s %6s %8s |%6s%6s%6s%6s%6s |\n", "scene", "integrator",
              "route", "step ms", "bare ms", "around", "[quartiles]", "goal", "fs/b", "refine", "eval",
              "asmbl", "trans", "resid", "updt");
  const double frame = 1.0 / 60.0;
  for (const Case& c :
       {Case{"S1(10000)", false, "dual", 1e-4, 200, 0.7, "below the notes' step limit"},
        Case{"S1(100)", true, "primal", frame, 200, 0.0, "peers: textbook LDLT 0.021 ms"},
        Case{"S1(1000)", true, "primal", frame, 100, 0.0, "peers: textbook LDLT 0.21 ms"},
        Case{"S1(10000)", true, "primal", frame, 60, 0.0, "peers: textbook LDLT 2.2 ms"},
        Case{"S2(30)", false, "primal", frame, 60, 0.10, ""},
        Case{"S2(50)", true, "primal", frame, 30, 0.0, "peers: textbook CHOLMOD 42 ms"},
        Case{"S2(100)", false, "primal", frame, 20, 0.05, "peers: textbook CHOLMOD 224 ms"},
        Case{"S2(100)", true, "primal", frame, 15, 0.05, "peers: textbook CHOLMOD 224 ms"},
        Case{"S4(10)", true, "primal", frame, 40, 0.0, "peers: CHOLMOD 22 ms, CG 6 ms"},
        Case{"S3c(100)", false, "dual", frame, 200, 0.0, "peers: ODE QuickStep 0.10 ms, joints gape"},
        Case{"S3c(1000)", false, "dual", frame, 100, 0.0, "peers: ODE QuickStep 1.2 ms, joints gape"},
        Case{"S3c(10000)", false, "dual", frame, 40, 0.0, ""},
        Case{"S3c(100000)", false, "dual", frame, 8, 0.0, ""},
        Case{"S3c(100)", false, "dual_blocks", frame, 200, 0.0, "peers: ODE QuickStep 0.10 ms, joints gape"},
        Case{"S3c(1000)", false, "dual_blocks", frame, 100, 0.0, "peers: ODE QuickStep 1.2 ms, joints gape"},
        Case{"S3c(10000)", false, "dual_blocks", frame, 40, 0.0, ""},
        Case{"S3c(100000)", false, "dual_blocks", frame, 8, 0.0, ""},
        Case{"plate_net:n=32", false, "dual", frame, 40, 0.15, ""},
        Case{"plate_net:n=32", false, "dual_blocks", frame, 40, 0.15, ""},
        Case{"S4(20)", false, "primal", frame, 8, 0.03, "peers: CHOLMOD 510 ms, CG 112 ms"}}) {
    Model model = make_model(c.scene);
    if (c.geometric)
      measure_phases<ImplicitEulerGeometric>(c, std::move(model));
    else
      measure_phases<ImplicitEulerNotes>(c, std::move(model));
  }
  std::printf("\nLeapfrog, whole steps, million spring evaluations per second\n%-10s %10s %10s %10s %8s\n",
              "scene", "scalar", "avx2", "avx512", "best/scalar");
  for (const auto& [scene, dt] : {std::pair{"S2(50)", 1e-5}, std::pair{"S4(10)", 1e-4}}) {
    const Model model = make_model(scene);
    double rate[3] = {};
    const char* names[3] = {"scalar", "avx2", "avx512"};
    for (int i = 0; i < 3; ++i) rate[i] = 1e-6 * springs_per_second(model, names[i], dt);
    std::printf("%-10s %10.1f %10.1f %10.1f %8.2f\n", scene, rate[0], rate[1], rate[2],
                std::max(rate[1], rate[2]) / rate[0]);
  }
}

}  // namespace
}  // namespace feder

int main(int, char** argv) {
  feder::restart_with_better_blas(argv);
  feder::run();
}
