// References with their own error bar. Cache file: magic, version, hash, payload (t, error, method, q, v),
// FNV-1a checksum of all before; written to a temporary file in the same folder, flushed to the disk, then
// renamed.
#include "solvers/reference.h"

#include <fcntl.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include "engine/check.h"
#include "engine/fluid/fluid.h"
#include "solvers/scene_hash.h"
#include "solvers/simulate.h"
#include "solvers/stability.h"

namespace feder {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMagic = "FEDERREF";
// To be raised whenever the judge or this layout changes: old files then miss.
constexpr std::uint32_t kCacheVersion = 2;
constexpr double kLoosening = 100.0;

std::string number(double x) {
  char text[32];
  (void)std::snprintf(text, sizeof text, "%.6g", x);
  return text;
}

std::uint64_t reference_hash(const System& s, const State& initial, double end_time,
                             const ReferenceOptions& o) {
  Fnv1a hash;
  hash.add(kCacheVersion);
  hash_scene(hash, s, initial);
  for (double x :
       {end_time, o.judge.relative_tolerance, o.judge.position_tolerance, o.judge.velocity_tolerance,
        o.judge.multiplier_tolerance, o.explicit_fraction, o.halving_accuracy, o.halving_seconds})
    hash.add(x);
  hash.add(o.judge.form);
  hash.add(o.most_ida_unknowns);
  return hash.value();
}

fs::path default_cache_folder() {
  if (const char* folder = std::getenv("XDG_CACHE_HOME"); folder && *folder)
    return fs::path(folder) / "feder" / "references";
  if (const char* home = std::getenv("HOME"); home && *home)
    return fs::path(home) / ".cache" / "feder" / "references";
  return {};
}

template <class T>
void append(std::string& bytes, const T& x) {
  bytes.append(reinterpret_cast<const char*>(&x), sizeof x);
}
void append(std::string& bytes, const VectorXd& x) {
  bytes.append(reinterpret_cast<const char*>(x.data()), sizeof(double) * static_cast<std::size_t>(x.size()));
}

// Takes values off the front of a byte string; `good` turns false when it runs short.
struct Reader {
  std::string_view bytes;
  bool good = true;

  std::string_view take(std::size_t size) {
    if (size > bytes.size()) good = false;
    const std::string_view head = bytes.substr(0, good ? size : 0);
    bytes.remove_prefix(head.size());
    return head;
  }
  template <class T>
  T value() {
    T x{};
    if (const std::string_view head = take(sizeof x); good) std::memcpy(&x, head.data(), sizeof x);
    return x;
  }
  VectorXd vector(int size) {
    VectorXd x = VectorXd::Zero(size);
    if (const std::string_view head = take(sizeof(double) * static_cast<std::size_t>(size)); good)
      std::memcpy(x.data(), head.data(), head.size());
    return x;
  }
};

std::uint64_t checksum(std::string_view bytes) {
  Fnv1a hash;
  hash.add_bytes(bytes.data(), bytes.size());
  return hash.value();
}

std::string encode(const Reference& r, std::uint64_t hash) {
  std::string bytes(kMagic);
  append(bytes, kCacheVersion);
  append(bytes, hash);
  append(bytes, r.state.t);
  append(bytes, r.error);
  append(bytes, static_cast<std::uint32_t>(r.method.size()));
  bytes += r.method;
  append(bytes, r.state.q);
  append(bytes, r.state.v);
  append(bytes, checksum(bytes));
  return bytes;
}

std::optional<Reference> decode(std::string_view bytes, std::uint64_t hash, int coordinates) {
  if (bytes.size() < sizeof(std::uint64_t)) return std::nullopt;
  Reader tail{bytes.substr(bytes.size() - sizeof(std::uint64_t))},
      in{bytes.substr(0, bytes.size() - sizeof(std::uint64_t))};
  if (tail.value<std::uint64_t>() != checksum(in.bytes)) return std::nullopt;
  if (in.take(kMagic.size()) != kMagic || in.value<std::uint32_t>() != kCacheVersion ||
      in.value<std::uint64_t>() != hash)
    return std::nullopt;
  Reference r;
  r.state.t = in.value<double>();
  r.error = in.value<double>();
  r.method = in.take(in.value<std::uint32_t>());
  r.state.q = in.vector(coordinates);
  r.state.v = in.vector(coordinates);
  r.from_cache = true;
  if (!in.good || !in.bytes.empty()) return std::nullopt;
  return r;
}

bool write_and_sync(const fs::path& file, std::string_view bytes) {
  const int descriptor = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  if (descriptor < 0) return false;
  bool good = true;
  while (good && !bytes.empty()) {
    const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    good = written > 0;
    if (good) bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  good = good && ::fsync(descriptor) == 0;
  return ::close(descriptor) == 0 && good;
}

void store(const fs::path& file, std::string_view bytes) {
  std::error_code ignored;
  fs::create_directories(file.parent_path(), ignored);
  const fs::path temporary = file.string() + ".tmp" + std::to_string(::getpid());
  fs::remove(temporary, ignored);
  if (write_and_sync(temporary, bytes)) fs::rename(temporary, file, ignored);
  fs::remove(temporary, ignored);
}

std::optional<Reference> load(const fs::path& file, std::uint64_t hash, int coordinates) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return std::nullopt;
  const std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  return decode(bytes, hash, coordinates);
}

}  // namespace

double position_error(const System& s, const State& a, const State& b) {
  double sum = 0.0, mass = 0.0;
  for (int i = 0; i < s.places(); ++i) {
    if (s.free[i] == kPinned) continue;
    sum += s.mass[i] * (a.q.segment<3>(3 * i) - b.q.segment<3>(3 * i)).squaredNorm();
    mass += s.mass[i];
  }
  for (const Body& body : s.bodies)
    if (s.free[body.centre] == kPinned && s.free[body.spin] != kPinned) mass += s.mass[body.centre];
  sum += rotation_error(s, a.q, b.q);
  return mass > 0.0 ? std::sqrt(sum / mass) : 0.0;
}

Reference ida_reference(const System& s, const State& initial, double end_time, const ReferenceOptions& o) {
  IdaOptions loose = o.judge.loosened(kLoosening);
  const IdaResult coarse = ida_solve(s, initial, end_time, loose);
  Reference r{coarse.status, coarse.state, 0.0, "ida", false};
  if (!r.status.ok()) return r;
  IdaOptions tight = o.judge;
  tight.form = coarse.form == "ode"   ? IdaForm::kOde
               : coarse.form == "ggl" ? IdaForm::kGgl
                                      : IdaForm::kCompliance;
  const IdaResult fine = ida_solve(s, initial, end_time, tight);
  r.status = fine.status;
  r.state = fine.state;
  r.method = "ida " + fine.form + ", relative tolerance " + number(loose.relative_tolerance) + " and " +
             number(tight.relative_tolerance);
  if (r.status.ok()) r.error = position_error(s, coarse.state, fine.state);
  return r;
}

Reference explicit_reference(const System& s, const State& initial, double end_time,
                             const ReferenceOptions& o) {
  const bool symplectic = !s.has_damping && !s.forces.has_drag && !s.forces.user && s.law_springs.empty() &&
                          !(s.fluid && s.fluid->dissipates());
  const char* name = symplectic ? "leapfrog" : "rk4";
  Reference r{{}, initial, 0.0, name, false};
  const double rate = largest_rate(s, initial);
  if (!std::isfinite(rate)) {
    r.status = Status::failure(StatusCode::kRefused,
                               std::string(name) + ": " + stability_limit_leapfrog(s, initial).why);
    return r;
  }
  // dt below the limit of the linearised system; never longer than a thousandth of the run
  const double limit = (symplectic ? 2.0 : kRk4Radius) / rate;
  const double dt = std::min(o.explicit_fraction * limit, 1e-3 * (end_time - initial.t));
  r.method += ", dt " + number(dt) + " and " + number(0.5 * dt);
  State states[2] = {initial, initial};
  for (int i = 0; i < 2 && r.status.ok(); ++i) {
    Integrator integrator = make_integrator(name, s);
    History history;
    const RunOptions run{
        .dt = i == 0 ? dt : 0.5 * dt, .end_time = end_time, .max_seconds = o.judge.max_seconds};
    r.status = simulate(s, integrator, states[i], history, run).status;
    r.state = states[i];
  }
  if (r.status.ok()) r.error = position_error(s, states[0], states[1]);
  return r;
}

Reference halving_reference(const System& s, const State& initial, double end_time,
                            const ReferenceOptions& o) {
  constexpr std::int64_t kFirst = 64, kMost = std::int64_t{1} << 24;
  const char* name = s.colliders.empty() ? "rk4" : "implicit_euler_notes";
  const double span = end_time - initial.t;
  const double size = std::max(1e-300, initial.q.head(3 * s.places()).lpNorm<Eigen::Infinity>());
  Reference r{Status::failure(StatusCode::kNotConverged, "no two step sizes within the budget"), initial, 0.0,
              name, false};
  double spent = 0.0;
  std::optional<State> coarse;
  for (std::int64_t steps = kFirst; steps <= kMost && spent < o.halving_seconds; steps *= 2) {
    Integrator integrator = make_integrator(name, s);
    State fine = initial;
    History history;
    const double dt = span / static_cast<double>(steps);
    const RunResult run =
        simulate(s, integrator, fine, history,
                 {.dt = dt, .end_time = end_time, .max_seconds = o.halving_seconds - spent});
    spent += run.seconds;
    if (run.status.ok() && coarse) {
      r.status = {};
      r.error = position_error(s, *coarse, fine);
      r.method = std::string(name) + ", dt " + number(2.0 * dt) + " and " + number(dt);
    }
    if (run.status.ok()) coarse = r.state = fine;
    // too long a step fails, and the next is half of it; the first failure explains if none succeeds
    if (!run.status.ok() && run.status.code != StatusCode::kLimitReached && !coarse) r.status = run.status;
    if (run.status.code == StatusCode::kRefused || (r.status.ok() && r.error <= o.halving_accuracy * size))
      break;
  }
  return r;
}

std::optional<fs::path> reference_cache_file(const System& s, const State& initial, double end_time,
                                             const ReferenceOptions& o) {
  FEDER_CHECK(initial.q.size() == s.position_size() && initial.v.size() == 3 * s.nodes,
              "the state does not fit the system");
  const fs::path folder = o.cache_folder.empty() ? default_cache_folder() : o.cache_folder;
  if (!o.use_cache || s.forces.user || s.driven() || !s.law_springs.empty() || s.fluid || !s.bodies.empty() ||
      !s.colliders.empty() || folder.empty())
    return std::nullopt;
  char name[32];
  (void)std::snprintf(name, sizeof name, "%016llx.reference",
                      static_cast<unsigned long long>(reference_hash(s, initial, end_time, o)));
  return folder / name;
}

Reference make_reference(const System& s, const State& initial, double end_time, const ReferenceOptions& o) {
  if (s.fluid && s.fluid->incompressible())
    return {Status::failure(StatusCode::kRefused, "no judge holds the density of an incompressible fluid"),
            initial, 0.0, "", false};
  const std::optional<fs::path> file = reference_cache_file(s, initial, end_time, o);
  const std::uint64_t hash = file ? reference_hash(s, initial, end_time, o) : 0;
  if (file)
    if (std::optional<Reference> known = load(*file, hash, 3 * s.nodes)) return std::move(*known);
  const bool small = 2 * s.free_count <= o.most_ida_unknowns || !(end_time > initial.t);
  if (s.has_hard_rows || !s.bodies.empty() || !s.colliders.empty()) {
    Reference r{Status::failure(StatusCode::kRefused, "too large for IDA"), initial, 0.0, "", false};
    if (small) r = ida_reference(s, initial, end_time, o);
    if (!r.status.ok()) {
      const std::string why = r.status.reason;
      r = halving_reference(s, initial, end_time, o);
      r.method += " (" + why + ")";
    }
    if (file && r.status.ok()) store(*file, encode(r, hash));
    return r;
  }
  Reference r = small ? ida_reference(s, initial, end_time, o) : explicit_reference(s, initial, end_time, o);
  if (small && r.status.code == StatusCode::kLimitReached) {
    const std::string why = r.status.reason;
    r = explicit_reference(s, initial, end_time, o);
    r.method += " (" + why + ")";
  }
  if (file && r.status.ok()) store(*file, encode(r, hash));
  return r;
}

}  // namespace feder
