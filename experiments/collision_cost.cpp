// What does a collision query cost, by mesh size and bounding volume, and what does the smallest ball? A
// bumpy sphere and a bumpy torus of T triangles each: a hierarchy is built and refitted, then asked for the
// first hit, for all pairs (a curve: about sqrt T of them) and for the distance (notes A18). Welzl's
// algorithm needs inside tests; the expected number per point of n points in R^d stays below (notes A17)
//   (d + 1)! sum_{j = 1 .. d + 1} 1/j! = 3, 10, 41 for d = 1, 2, 3.
#include <fmt/format.h>
#include <time.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <random>

#include "engine/check.h"
#include "engine/geometry/bvh_queries.h"
#include "engine/geometry/bvh_traversal.h"
#include "engine/geometry/mesh_generators.h"
#include "engine/geometry/welzl_ball.h"
#include "engine/status.h"
#include "experiments/support/experiment.h"
#include "experiments/support/measure.h"
#include "experiments/support/timing.h"

namespace feder::experiments {
namespace {

constexpr const char* kMeshes = "bumpy sphere and torus";
constexpr const char* kPoints = "points in a cube";

// In [-1, 1), the same with every standard library.
double uniform(std::mt19937_64& random) {
  return static_cast<double>(random() >> 11) * 0x1p-52 - 1.0;
}

// ---- Time of one call

// Of this thread on the processor: what else runs on the machine disturbs it less than time on the wall.
class ThreadStopwatch {
 public:
  double seconds() const { return now() - begin_; }

 private:
  static double now() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  }
  double begin_ = now();
};

struct Limits {
  std::int64_t repeats;
  double max_seconds;
};

// Smallest of several; measure() returns the seconds of one call.
template <class Measure>
double best_within(const Limits& limits, Measure&& measure) {
  const ThreadStopwatch all;
  double best = measure();
  for (std::int64_t i = 1; i < limits.repeats && all.seconds() < limits.max_seconds; ++i)
    best = std::min(best, measure());
  return best;
}

// Short calls are timed many at once, for a millisecond at least. The first warms up, and has to do where it
// is longer than the budget.
template <class Call>
double best_of_batches(const Limits& limits, Call&& call) {
  constexpr double kLeast = 1e-3;
  const ThreadStopwatch watch;
  call();
  const double first = watch.seconds(), count = std::clamp(std::ceil(kLeast / (first + 1e-9)), 1.0, 1e6);
  if (first > limits.max_seconds) return first;
  return best_within(limits, [&] {
    const ThreadStopwatch batch;
    for (double i = 0.0; i < count; ++i) call();
    return batch.seconds() / count;
  });
}

// ---- Two meshes near each other

// Where sphere and torus meet, and where they do not.
struct Placement {
  Pose torus, meeting, apart;
};
struct Scene {
  TriangleMesh sphere, torus;  // as many triangles each
  std::vector<Placement> placements;
};

// 1 within a tenth, waves along every axis.
double bump(const Vector3d& p) {
  return 1.0 + 0.1 * std::sin(6.0 * p[0] + 1.0) * std::sin(7.0 * p[1] + 2.0) * std::sin(5.0 * p[2] + 3.0);
}

TriangleMesh bumpy_sphere(int n) {
  TriangleMesh mesh = sphere_mesh("bumpy sphere", 1.0, n);
  for (Vector3d& p : mesh.vertices) p *= bump(p);
  return mesh;
}

TriangleMesh bumpy_torus(int n) {
  TriangleMesh mesh = torus_mesh("bumpy torus", 1.0, 0.3, 4 * n, n);
  for (Vector3d& p : mesh.vertices) {
    const Vector3d circle = Vector3d(p[0], p[1], 0.0).normalized();
    p = circle + bump(p) * (p - circle);
  }
  return mesh;
}

Matrix3d any_rotation(std::mt19937_64& random) {
  Eigen::Vector4d q;
  for (double& x : q) x = uniform(random);
  return Eigen::Quaterniond(q.normalized()).toRotationMatrix();
}

// The sphere comes along x; no step is longer than the distance, so that it stops where they first touch.
Scene make_scene(int n, const Settings& settings, std::uint64_t seed) {
  Scene scene{bumpy_sphere(n), bumpy_torus(n), {}};
  const Bvh<Obb> sphere(scene.sphere), torus(scene.torus);
  std::mt19937_64 random(seed);
  for (std::int64_t i = 0; i < settings.integer("placements"); ++i) {
    Placement place;
    place.torus.rotation = any_rotation(random);
    place.meeting = place.apart = {any_rotation(random), 4.0 * Vector3d::UnitX()};
    double& x = place.meeting.position[0];
    for (double distance = 1.0; distance > 1e-6; x -= distance)
      distance = closest_points(sphere, place.meeting, torus, place.torus)->distance;
    place.apart.position[0] = x + settings.number("gap");
    x -= settings.number("depth");
    scene.placements.push_back(place);
  }
  return scene;
}

// ---- What a hierarchy costs and answers

struct Answers {  // of each placement
  std::vector<bool> hits;
  std::vector<std::vector<TrianglePair>> pairs;
  std::vector<double> distances;                           // [m]
  double volume_tests = 0.0, leaf_pairs = 0.0, sum = 0.0;  // for all pairs, and how many these are
};

// The walk of all_overlaps, counted.
template <class Volume>
void count_tests(const Bvh<Volume>& a, const Pose& pose_a, const Bvh<Volume>& b, const Pose& pose_b,
                 Answers& out) {
  const Relative frame =
      relative(pose_a, pose_b, reach_of(a.nodes()[0].volume) + reach_of(b.nodes()[0].volume));
  visit_leaf_pairs(
      a.nodes(), 0, b.nodes(), 0,
      [&](const Volume& x, const Volume& y) {
        out.volume_tests += 1.0;
        return apart(x, y, frame);
      },
      [&](const BvhNode<Volume>&, const BvhNode<Volume>&) {
        out.leaf_pairs += 1.0;
        return false;
      });
}

template <class Volume>
Answers find_answers(const Scene& scene, const Bvh<Volume>& sphere, const Bvh<Volume>& torus) {
  Answers out;
  for (const Placement& at : scene.placements) {
    out.hits.push_back(any_overlap(sphere, at.meeting, torus, at.torus).has_value());
    out.pairs.push_back(all_overlaps(sphere, at.meeting, torus, at.torus));
    out.distances.push_back(closest_points(sphere, at.apart, torus, at.torus)->distance);
    out.sum += static_cast<double>(out.pairs.back().size());
    count_tests(sphere, at.meeting, torus, at.torus, out);
  }
  return out;
}

// Every volume has to find the same, the first hit among all pairs.
Status compare(const Answers& first, const Answers& other) {
  for (std::size_t i = 0; i < first.pairs.size(); ++i)
    if (other.hits[i] == other.pairs[i].empty() || first.pairs[i] != other.pairs[i] ||
        !(std::abs(first.distances[i] - other.distances[i]) <= 1e-12))
      return Status::failure(
          StatusCode::kInconsistent,
          fmt::format("placement {}: {} pairs, {} m; the first volume found {}, {} m", i,
                      other.pairs[i].size(), other.distances[i], first.pairs[i].size(), first.distances[i]));
  return {};
}

template <class Volume>
void measure_hierarchy(Context& context, const std::string& name, const Scene& scene,
                       std::optional<Answers>& agreed) {
  const Limits limits{context.settings.integer("repeats"), context.settings.number("max_seconds")};
  const double triangles = static_cast<double>(scene.sphere.triangles.size()),
               placements = static_cast<double>(scene.placements.size());
  const Bvh<Volume> sphere(scene.sphere), torus(scene.torus);
  const Answers answers = find_answers(scene, sphere, torus);
  if (!agreed) agreed = answers;
  const Status status = compare(*agreed, answers);

  const auto add = [&](const char* quantity, double seconds, Table::Row more) {
    more.insert(more.end(), {{"scene", kMeshes},
                             {"volume", name},
                             {"triangles", scene.sphere.triangles.size()},
                             {"quantity", quantity},
                             {"status", to_string(status.code)},
                             {"reason", status.reason},
                             {"seconds", seconds}});
    context.table.add(more);
    context.progress.advance(fmt::format("{} {} {}", quantity, name, triangles));
  };

  // build and refit, the sphere alone
  Bvh<Volume> tree;
  const double build = best_within(limits, [&] {
    const ThreadStopwatch watch;
    Bvh<Volume> built(scene.sphere);
    const double seconds = watch.seconds();
    tree = std::move(built);
    return seconds;
  });
  add("build", build, {{"seconds_per_triangle", build / triangles}});
  std::vector<Vector3d> moved = scene.sphere.vertices;
  for (Vector3d& p : moved) p[0] += 0.1 * p[1];
  const double refit = best_of_batches(limits, [&] { tree.refit(moved); });
  add("refit", refit, {{"seconds_per_triangle", refit / triangles}});

  // queries, mean of the placements
  const auto seconds_of = [&](auto&& query) {
    return best_of_batches(limits, [&] { std::ranges::for_each(scene.placements, query); }) / placements;
  };
  using At = const Placement&;
  add("first_hit", seconds_of([&](At at) { any_overlap(sphere, at.meeting, torus, at.torus); }), {});
  add("all_pairs", seconds_of([&](At at) { all_overlaps(sphere, at.meeting, torus, at.torus); }),
      {{"pairs", answers.sum / placements},
       {"volume_tests", answers.volume_tests / placements},
       {"leaf_pairs", answers.leaf_pairs / placements}});
  add("distance", seconds_of([&](At at) { closest_points(sphere, at.apart, torus, at.torus); }), {});
}

void measure_meshes(Context& context) {
  const std::vector<std::string> volumes = context.settings.texts("volumes");
  for (const double triangles : context.settings.numbers("triangles")) {
    const int n = std::max(3, static_cast<int>(std::lround(std::sqrt(triangles / 8.0))));
    const Scene scene = make_scene(n, context.settings, context.seed);
    std::optional<Answers> agreed;
    for (const std::string& volume : volumes) {
      if (context.interrupted()) return;
      if (volume == "sphere") measure_hierarchy<Sphere>(context, volume, scene, agreed);
      if (volume == "aabb") measure_hierarchy<Aabb>(context, volume, scene, agreed);
      if (volume == "obb") measure_hierarchy<Obb>(context, volume, scene, agreed);
    }
  }
}

// ---- The smallest ball

double bound_of_tests(int d) {
  double bound = 0.0, term = 1.0;
  for (int j = d + 1; j >= 1; --j) bound += term, term *= j;
  return bound;
}

// Of one dimension and number of points, over the seeds.
struct Balls {
  std::vector<double> tests, welzl_seconds, seconds;  // tests per point; seconds of a call
  double mean = 0.0, deviation = 0.0;                 // of the tests per point
  Status status;
};

// Fresh points and a fresh order for every seed.
Balls find_balls(const Context& context, int d, Eigen::Index n) {
  const std::int64_t seeds = context.settings.integer("seeds");
  const double share = context.settings.number("max_seconds") / static_cast<double>(seeds);
  Balls out;
  for (std::int64_t seed = 0; seed < seeds; ++seed) {
    std::mt19937_64 random(context.seed + static_cast<std::uint64_t>(seed));
    Eigen::MatrixXd points(d, n);
    for (double& x : points.reshaped()) x = uniform(random);
    const std::uint64_t order = random();
    WelzlBall welzl;
    Ball smallest;
    const auto time = [&](auto&& call) {
      return best_within({context.settings.integer("repeats"), share}, [&] {
        const ThreadStopwatch watch;
        call();
        return watch.seconds();
      });
    };
    out.welzl_seconds.push_back(time([&] { welzl = welzl_ball(points, order); }));
    out.seconds.push_back(time([&] { smallest = smallest_ball(points); }));
    out.tests.push_back(static_cast<double>(welzl.inside_tests) / static_cast<double>(n));
    const double difference = std::abs(welzl.ball.radius - smallest.radius);
    if (!(difference <= 1e-12))
      out.status = Status::failure(StatusCode::kInconsistent,
                                   fmt::format("radii of the two algorithms differ by {} m", difference));
  }
  for (const double x : out.tests) out.mean += x / static_cast<double>(seeds);
  for (const double x : out.tests)
    out.deviation += std::pow(x - out.mean, 2) / static_cast<double>(seeds - 1);
  out.deviation = std::sqrt(out.deviation);
  return out;
}

void add_balls(Context& context, int d, Eigen::Index n, const Balls& balls) {
  const auto add = [&](const char* quantity, const std::vector<double>& seconds, Table::Row more) {
    more.insert(more.end(), {{"scene", kPoints},
                             {"quantity", quantity},
                             {"dimension", d},
                             {"points", n},
                             {"status", to_string(balls.status.code)},
                             {"reason", balls.status.reason},
                             {"seconds", median(seconds)},
                             {"seconds_per_point", median(seconds) / static_cast<double>(n)}});
    context.table.add(more);
    context.progress.advance(fmt::format("{} {}", quantity, n));
  };
  add("welzl_ball", balls.welzl_seconds,
      {{"tests_per_point", balls.mean},
       {"tests_deviation", balls.deviation},
       {"tests_bound", bound_of_tests(d)}});
  add("smallest_ball", balls.seconds, {});
}

void measure_balls(Context& context) {
  const std::vector<double> sizes = context.settings.numbers("points");
  const double root = std::sqrt(context.settings.integer("seeds"));
  std::string tests, times;
  for (const int d : {1, 2, 3}) {
    Balls balls;
    for (const double size : sizes) {
      if (context.interrupted()) return;
      balls = find_balls(context, d, std::llround(size));
      add_balls(context, d, std::llround(size), balls);
    }
    const double seconds = median(balls.seconds), welzl = median(balls.welzl_seconds);
    tests += fmt::format("{}d = {}: {:.2f} +- {:.2f} (bound {})", d == 1 ? "" : ", ", d, balls.mean,
                         balls.deviation / root, bound_of_tests(d));
    times += fmt::format("{}d = {}: {:.2g} ns, Welzl {:.1f} times as long", d == 1 ? "" : ", ", d,
                         1e9 * seconds / sizes.back(), welzl / seconds);
  }
  context.note(fmt::format("Welzl's inside tests per point at n = {:g}, mean and its standard error: {}.",
                           sizes.back(), tests));
  context.note(fmt::format("smallest_ball takes per point at n = {:g}: {}.", sizes.back(), times));
}

// ---- Charts

bool is(const Table& table, std::size_t row, const char* column, const std::string& text) {
  return table.at(row, column).text() == text;
}

std::vector<Series> by_volume(const Table& table, const char* quantity, const char* y) {
  return series_by(table, "volume", "triangles", y,
                   [&](std::size_t row) { return is(table, row, "quantity", quantity); });
}

std::vector<Series> by_dimension(const Table& table, const char* quantity, const char* y) {
  std::vector<Series> all = series_by(table, "dimension", "points", y,
                                      [&](std::size_t row) { return is(table, row, "quantity", quantity); });
  for (Series& series : all) series.label = "d = " + series.label;
  return all;
}

// Log-log, the limits of y at powers of ten.
Panel panel(const char* title, const char* x, const char* y, std::vector<Series> series) {
  Panel out;
  out.title = title;
  out.x.label = x, out.y.label = y;
  out.x.log = out.y.log = true;
  for (const Series& one : series)
    for (const double value : one.y) {
      out.y.min = std::min(out.y.min.value_or(value), std::pow(10.0, std::floor(std::log10(value))));
      out.y.max = std::max(out.y.max.value_or(value), std::pow(10.0, std::ceil(std::log10(value))));
    }
  out.series = std::move(series);
  return out;
}

Chart mesh_chart(const Table& table) {
  const auto part = [&](const char* title, const char* y, const char* quantity, const char* column) {
    return panel(title, "triangles T", y, by_volume(table, quantity, column));
  };
  Chart chart{.name = "collision_cost",
              .title = "A bumpy sphere and a bumpy torus: what their hierarchies cost",
              .caption =
                  "Best of several times of one thread on the processor; T triangles in each mesh, the "
                  "queries' mean over "
                  "generic poses.",
              .panels = {part("Build", "per triangle [s]", "build", "seconds_per_triangle"),
                         part("Refit", "per triangle [s]", "refit", "seconds_per_triangle"),
                         part("First hit", "per query [s]", "first_hit", "seconds"),
                         part("All pairs", "per query [s]", "all_pairs", "seconds"),
                         part("Volume tests for all pairs", "tests per query", "all_pairs", "volume_tests"),
                         part("Distance", "per query [s]", "distance", "seconds")},
              .grid_columns = 3};
  for (const std::size_t curve : {3, 4})  // the pairs lie along a curve
    chart.panels[curve].slopes = {{.order = 0.5, .label = "slope 1/2"}};
  return chart;
}

Chart ball_chart(const Table& table) {
  const auto part = [&](const char* title, const char* y, const char* quantity, const char* column) {
    return panel(title, "points n", y, by_dimension(table, quantity, column));
  };
  Chart chart{
      .name = "smallest_ball",
      .title = "The smallest ball around points in a cube",
      .caption = "The expected number of tests stays below the bound of each dimension.",
      .panels = {part("Welzl: inside tests per point, mean", "tests / n", "welzl_ball", "tests_per_point"),
                 part("Welzl: spread of the tests over the seeds", "standard deviation of tests / n",
                      "welzl_ball", "tests_deviation"),
                 part("welzl_ball: median time", "per point [s]", "welzl_ball", "seconds_per_point"),
                 part("smallest_ball: median time", "per point [s]", "smallest_ball", "seconds_per_point")}};
  for (const std::size_t count : {0, 1}) chart.panels[count].y = {chart.panels[count].y.label, false, 0.0};
  chart.panels[0].y.max = 45.0;
  for (const int d : {1, 2, 3})
    chart.panels[0].marks.push_back({.at = bound_of_tests(d),
                                     .label = fmt::format("bound d = {}: {}", d, bound_of_tests(d)),
                                     .vertical = false});
  Axis &welzl = chart.panels[2].y, &smallest = chart.panels[3].y;
  welzl.min = smallest.min = std::min(welzl.min, smallest.min);
  welzl.max = smallest.max = std::max(welzl.max, smallest.max);
  return chart;
}

// ---- Conclusions

std::string duration(double seconds) {
  if (seconds < 1e-6) return fmt::format("{:.3g} ns", 1e9 * seconds);
  if (seconds < 1e-3) return fmt::format("{:.3g} us", 1e6 * seconds);
  return seconds < 1.0 ? fmt::format("{:.3g} ms", 1e3 * seconds) : fmt::format("{:.3g} s", seconds);
}

// What each volume takes for the largest mesh, and how that grows.
std::string at_last(const Table& table, const char* quantity, const char* column) {
  std::string text;
  for (const Series& series : by_volume(table, quantity, column)) {
    if (series.y.empty()) continue;
    const double last = series.y.back();
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", series.label,
                        last < 1.0 ? duration(last) : fmt::format("{:.0f}", last));
    if (series.y.size() > 1) text += fmt::format(" (T^{:.2f})", fit_power(series.x, series.y).slope);
  }
  return text;
}

void conclude_meshes(Context& context) {
  const Table& table = context.table;
  context.note(fmt::format("A build takes per triangle, for the largest mesh: {}; a refit: {}.",
                           at_last(table, "build", "seconds_per_triangle"),
                           at_last(table, "refit", "seconds_per_triangle")));
  context.note(
      fmt::format("The largest two meshes take for the first hit: {}; for all pairs: {}; for the "
                  "distance: {}.",
                  at_last(table, "first_hit", "seconds"), at_last(table, "all_pairs", "seconds"),
                  at_last(table, "distance", "seconds")));
  context.note(fmt::format("All pairs need tests of two volumes: {}; pairs of leaves: {}.",
                           at_last(table, "all_pairs", "volume_tests"),
                           at_last(table, "all_pairs", "leaf_pairs")));
  // what the tighter boxes cost more, counted in queries
  const auto dearer = [&](const char* quantity) {
    double seconds[2] = {};  // aabb, obb
    for (std::size_t row = 0; row < table.rows(); ++row)
      if (is(table, row, "quantity", quantity) && !is(table, row, "volume", "sphere"))
        seconds[is(table, row, "volume", "obb")] = table.at(row, "seconds").number();
    return seconds[0] > 0.0 && seconds[1] > 0.0 ? seconds[1] - seconds[0] : 0.0;
  };
  const double pairs = -dearer("all_pairs"), distance = -dearer("distance");
  if (pairs > 0.0 && distance > 0.0)
    context.note(
        fmt::format("The largest two meshes under obb instead of aabb cost {} more to build, repaid by "
                    "{:.0f} queries for all pairs or {:.0f} for the distance; a refit, {} more, by "
                    "{:.0f} or {:.0f}.",
                    duration(2.0 * dearer("build")), std::ceil(2.0 * dearer("build") / pairs),
                    std::ceil(2.0 * dearer("build") / distance), duration(2.0 * dearer("refit")),
                    std::ceil(2.0 * dearer("refit") / pairs), std::ceil(2.0 * dearer("refit") / distance)));
}

void check(const Context& context) {
  const auto require = [](const char* key, double value, double low, double high) {
    if (!(value >= low && value <= high))
      fail_input(fmt::format("setting '{}'", key), "value", value, "",
                 fmt::format("{:g} to {:g}", low, high));
  };
  for (const double x : context.settings.numbers("triangles")) require("triangles", x, 8.0, 1e8);
  for (const double x : context.settings.numbers("points")) require("points", x, 2.0, 1e8);
  require("placements", static_cast<double>(context.settings.integer("placements")), 1.0, 1e4);
  require("seeds", static_cast<double>(context.settings.integer("seeds")), 2.0, 1e6);
  require("depth", context.settings.number("depth"), 0.0, 0.5);
  require("gap", context.settings.number("gap"), 0.0, 10.0);
}

void body(Context& context) {
  check(context);
  context.progress.start(static_cast<long>(5 * context.settings.numbers("triangles").size() *
                                               context.settings.texts("volumes").size() +
                                           6 * context.settings.numbers("points").size()));
  measure_meshes(context);
  measure_balls(context);
  if (context.interrupted()) return;
  context.add_chart(mesh_chart(context.table));
  context.add_chart(ball_chart(context.table));
  conclude_meshes(context);
}

ExperimentInfo about() {
  return {
      .name = "collision_cost",
      .question =
          "What does a collision query cost, by mesh size and bounding volume, and what does the smallest "
          "ball?",
      .not_modelled =
          "One pair of smooth closed surfaces and one thread: no triangle soups, no self "
          "contact, no reuse of the last step's answer.",
      .settings = {{"triangles", Kind::kNumbers, "1e3:1e5:5", "1e3:1e6:10", "of each mesh, about"},
                   {"volumes",
                    Kind::kTexts,
                    "sphere,aabb,obb",
                    "sphere,aabb,obb",
                    "bounding volumes of the hierarchy",
                    {"sphere", "aabb", "obb"}},
                   {"placements", Kind::kInteger, "8", "16", "generic poses, the queries' mean is taken"},
                   {"depth", Kind::kNumber, "0.02", "0.02", "how far the sphere is pushed in, m"},
                   {"gap", Kind::kNumber, "0.02", "0.02", "how far it is drawn back, m"},
                   {"points", Kind::kNumbers, "1e2:1e5:4", "1e2:1e6:9", "in the smallest ball"},
                   {"seeds", Kind::kInteger, "100", "400", "point sets and orders of each size"},
                   {"repeats", Kind::kInteger, "7", "25", "of each timing, at most"},
                   {"max_seconds", Kind::kNumber, "0.1", "5",
                    "budget of the repeats of a timing, processor s"}},
      .columns = {"scene", "volume", "triangles", "quantity", "dimension", "points", "status", "reason",
                  "pairs", "volume_tests", "leaf_pairs", "tests_per_point", "tests_deviation", "tests_bound",
                  "seconds", "seconds_per_triangle", "seconds_per_point"},
      .cases = {"bumpy sphere and torus: build, refit, first_hit, all_pairs, distance",
                "points in a cube: welzl_ball, smallest_ball"}};
}

}  // namespace
}  // namespace feder::experiments

int main(int argc, char** argv) {
  return feder::experiments::run_experiment(feder::experiments::about(), argc, argv,
                                            feder::experiments::body);
}
