// The judge: SUNDIALS IDA on F(t, y, y') = 0 of ida_system.h, initial y' and lambda ours.
//
// Multipliers stay out of the error test (IDASetId, IDASetSuppressAlg), in compliance form the velocities,
// too. With stiff rows it behaves like index 3: Newton's rounding delta in q shows as delta/dt in v, so that
// testing v forces dt omega < 1. Measured on a pendulum (T = 2 s, relative tolerance 1e-10): 411 000 steps
// with v in the test at d = 1e10, 1099 without.
//
// A call-back that meets a non-finite value returns IDA's recoverable code, so that IDA tries a shorter step,
// and remembers the reason, because IDA itself would report "too much work".
#include "solvers/ida_reference.h"

#include <ida/ida.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sunlinsol/sunlinsol_klu.h>
#include <sunmatrix/sunmatrix_sparse.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <memory>

#include "engine/fluid/fluid.h"
#include "solvers/stability.h"

namespace feder {
namespace {

static_assert(sizeof(sunindextype) == sizeof(std::int64_t) && sizeof(realtype) == sizeof(double));

// A failed evaluation this many residual calls ago no longer explains why IDA gave up.
constexpr long kMemory = 200;
// So many failures, each within kMemory calls of the last, and we stop IDA: it would creep towards the
// obstacle until its budget is gone.
constexpr long kLargestFailureCount = 300;

using Clock = std::chrono::steady_clock;

struct CallbackData {
  IdaSystem* system = nullptr;
  Status last_failure, limit;
  long calls = 0, failure_call = -1, failures = 0;
  Clock::time_point deadline;

  // IDA's code: 0 good, 1 recoverable, -1 stop
  int report(Status status) {
    ++calls;
    if (Clock::now() > deadline) {
      limit = Status::failure(StatusCode::kLimitReached, "IDA: the wall-clock budget ran out");
      return -1;
    }
    if (status.ok()) return 0;
    if (!failed_recently()) failures = 0;
    last_failure = std::move(status);
    failure_call = calls;
    return ++failures > kLargestFailureCount ? -1 : 1;
  }
  bool failed_recently() const { return failure_call >= 0 && calls - failure_call <= kMemory; }
};

int residual(realtype t, N_Vector y, N_Vector y_prime, N_Vector r, void* user) {
  auto& data = *static_cast<CallbackData*>(user);
  return data.report(
      data.system->residual(t, N_VGetArrayPointer(y), N_VGetArrayPointer(y_prime), N_VGetArrayPointer(r)));
}

int jacobian(realtype t, realtype cj, N_Vector y, N_Vector, N_Vector, SUNMatrix J, void* user, N_Vector,
             N_Vector, N_Vector) {
  auto& data = *static_cast<CallbackData*>(user);
  // IDA zeroes the whole matrix, its pattern included
  const IdaSystem& system = *data.system;
  std::memcpy(SM_INDEXPTRS_S(J), system.column_starts().data(),
              system.column_starts().size() * sizeof(std::int64_t));
  std::memcpy(SM_INDEXVALS_S(J), system.row_indices().data(),
              system.row_indices().size() * sizeof(std::int64_t));
  return data.report(data.system->jacobian(t, N_VGetArrayPointer(y), cj, SM_DATA_S(J)));
}

void keep_silent(int, const char*, const char*, char*, void*) {}

template <auto kFree>
struct Release {
  template <class T>
  void operator()(T* object) const {
    kFree(object);
  }
};
using Vector = std::unique_ptr<_generic_N_Vector, Release<N_VDestroy>>;
using Matrix = std::unique_ptr<_generic_SUNMatrix, Release<SUNMatDestroy>>;
using LinearSolver = std::unique_ptr<_generic_SUNLinearSolver, Release<SUNLinSolFree>>;
struct ReleaseIda {
  void operator()(void* memory) const { IDAFree(&memory); }
};

// All of IDA's objects; freed in reverse order, the context last.
struct Session {
  std::unique_ptr<sundials::Context> context = std::make_unique<sundials::Context>();
  Vector y, y_prime, id, tolerance;
  Matrix matrix;
  LinearSolver solver;
  std::unique_ptr<void, ReleaseIda> ida;
  CallbackData data;

  bool create(IdaSystem& system, IdaForm form, const IdaOptions& options);
  bool start(const State& initial, double end_time, const IdaOptions& options);
};

bool Session::create(IdaSystem& system, IdaForm form, const IdaOptions& options) {
  const int size = system.unknowns(), q = system.positions(), v = q + system.coordinates();
  // at IDA's tiny first steps rounding of v shows as eps v/dt in the multipliers of hard rows: a tolerance
  // below it stops one random mechanism in twelve before its first step
  const double multiplier = options.multiplier_tolerance * (form == IdaForm::kGgl ? 100.0 : 1.0);
  // ode and ggl: velocities are tested; compliance form: see above
  const int tested = form == IdaForm::kCompliance ? q : v;
  data.system = &system;
  for (Vector* x : {&y, &y_prime, &id, &tolerance}) x->reset(N_VNew_Serial(size, *context));
  matrix.reset(SUNSparseMatrix(size, size, system.nonzeros(), CSC_MAT, *context));
  if (!y || !y_prime || !id || !tolerance || !matrix) return false;
  solver.reset(SUNLinSol_KLU(y.get(), matrix.get(), *context));
  ida.reset(IDACreate(*context));
  for (int i = 0; i < size; ++i) {
    NV_Ith_S(tolerance.get(), i) = i < q   ? options.position_tolerance
                                   : i < v ? options.velocity_tolerance
                                           : multiplier;
    NV_Ith_S(id.get(), i) = i < tested ? 1.0 : 0.0;  // 0: not in the error test
  }
  return solver && ida;
}

bool Session::start(const State& initial, double end_time, const IdaOptions& options) {
  void* m = ida.get();
  return IDAInit(m, residual, initial.t, y.get(), y_prime.get()) == IDA_SUCCESS &&
         IDASetErrHandlerFn(m, keep_silent, nullptr) == IDA_SUCCESS &&
         IDASVtolerances(m, options.relative_tolerance, tolerance.get()) == IDA_SUCCESS &&
         IDASetUserData(m, &data) == IDA_SUCCESS &&
         IDASetLinearSolver(m, solver.get(), matrix.get()) == IDA_SUCCESS &&
         IDASetJacFn(m, jacobian) == IDA_SUCCESS && IDASetId(m, id.get()) == IDA_SUCCESS &&
         IDASetSuppressAlg(m, SUNTRUE) == IDA_SUCCESS &&
         IDASetMaxNumSteps(m, options.max_steps) == IDA_SUCCESS && IDASetStopTime(m, end_time) == IDA_SUCCESS;
}

// IDA's return code in our words
Status verdict(int flag, double t, const CallbackData& data) {
  if (flag == IDA_TSTOP_RETURN || flag == IDA_SUCCESS) return {};
  if (!data.limit.ok()) return data.limit;
  if (data.failed_recently()) return data.last_failure;
  const std::string at = " at t = " + std::to_string(t) + " s";
  switch (flag) {
    case IDA_TOO_MUCH_WORK:
      return Status::failure(StatusCode::kLimitReached, "IDA: the step budget ran out" + at);
    case IDA_TOO_MUCH_ACC:
      return Status::failure(StatusCode::kNotConverged, "IDA: the tolerances are below rounding" + at);
    case IDA_ERR_FAIL:
      return Status::failure(StatusCode::kStepTooSmall, "IDA: the error test keeps failing" + at);
    case IDA_CONV_FAIL:
      return Status::failure(StatusCode::kNotConverged, "IDA: Newton keeps failing" + at);
    case IDA_LSETUP_FAIL:
    case IDA_LSOLVE_FAIL:
      return Status::failure(StatusCode::kSingular, "IDA: KLU cannot factor the Jacobian" + at);
    case IDA_MEM_FAIL:
      return Status::failure(StatusCode::kOutOfMemory, "IDA: out of memory");
    default:
      return Status::failure(StatusCode::kNotConverged, "IDA: code " + std::to_string(flag) + at);
  }
}

Status refuse(const System& s, const State& initial, double end_time, const IdaOptions& o) {
  auto refused = [](const std::string& reason) { return Status::failure(StatusCode::kRefused, reason); };
  for (int k = 0; k < s.rows; ++k)
    if (std::isinf(s.stiffness[k]) && o.form != IdaForm::kAutomatic && o.form != IdaForm::kGgl)
      return refused("IDA: " + s.row_name(k) + " is hard: the ggl form is for such rows");
  if (!s.colliders.empty())
    return refused("IDA: colliders make velocities jump: it takes smooth scenes only");
  if (s.fluid && s.fluid->incompressible())
    return refused("IDA: the density rows of an incompressible fluid only push: it takes smooth scenes only");
  if (!s.has_hard_rows && o.form == IdaForm::kGgl) return refused("IDA: the ggl form needs a hard row");
  if (initial.q.size() != s.position_size() || initial.v.size() != 3 * s.nodes)
    return refused("IDA: the state does not fit the system");
  if (!std::isfinite(initial.t) || !initial.q.allFinite() || !initial.v.allFinite())
    return refused("IDA: the initial state is not finite");
  if (!std::isfinite(end_time) || end_time < initial.t)
    return refused("IDA: end time = " + std::to_string(end_time) +
                   " s, expected a finite time not before the initial one");
  for (double tolerance :
       {o.relative_tolerance, o.position_tolerance, o.velocity_tolerance, o.multiplier_tolerance})
    if (!(tolerance > 0.0 && std::isfinite(tolerance)))
      return refused("IDA: a tolerance is not positive and finite");
  if (!(o.max_seconds > 0.0) || o.max_steps < 1) return refused("IDA: a budget is not positive");
  return {};
}

}  // namespace

IdaOptions IdaOptions::loosened(double factor) const {
  IdaOptions result = *this;
  for (double* x : {&result.relative_tolerance, &result.position_tolerance, &result.velocity_tolerance,
                    &result.multiplier_tolerance})
    *x *= factor;
  return result;
}

IdaForm choose_ida_form(const System& s, const State& initial, double end_time) {
  if (s.has_hard_rows) return IdaForm::kGgl;
  const double phase = largest_frequency(s, initial) * (end_time - initial.t);
  return phase > kLargestOdePhase ? IdaForm::kCompliance : IdaForm::kOde;
}

IdaResult ida_solve(const System& s, const State& initial, double end_time, const IdaOptions& options) {
  IdaResult result;
  result.state = initial;
  if (result.status = refuse(s, initial, end_time, options); !result.status.ok()) return result;
  const Clock::time_point begin = Clock::now();
  const IdaForm form =
      options.form == IdaForm::kAutomatic ? choose_ida_form(s, initial, end_time) : options.form;
  result.form = form == IdaForm::kOde ? "ode" : form == IdaForm::kGgl ? "ggl" : "compliance";
  if (s.free_count == 0 || end_time == initial.t) {
    result.state.t = end_time;
    return result;
  }

  IdaSystem system(s, initial, form);
  Session session;
  session.data.deadline = begin + std::chrono::duration_cast<Clock::duration>(
                                      std::chrono::duration<double>(std::min(options.max_seconds, 1e8)));
  if (!session.create(system, form, options)) {
    result.status = Status::failure(StatusCode::kOutOfMemory, "IDA: out of memory");
    return result;
  }
  double t = initial.t;
  double* y = N_VGetArrayPointer(session.y.get());
  result.status = system.initial(initial, y, N_VGetArrayPointer(session.y_prime.get()));
  if (result.status.ok()) {
    const int flag =
        session.start(initial, end_time, options)
            ? IDASolve(session.ida.get(), end_time, &t, session.y.get(), session.y_prime.get(), IDA_NORMAL)
            : IDA_ILL_INPUT;
    (void)IDAGetNumSteps(session.ida.get(), &result.steps);
    result.status = verdict(flag, t, session.data);
    system.read(result.status.ok() ? end_time : t, y, result.state);
  }
  result.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  return result;
}

}  // namespace feder
