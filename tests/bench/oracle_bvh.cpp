// Hierarchies over meshes beside FCL: build, and all pairs of triangles that meet. Same vertices and
// triangles, one thread, alternating in one run; medians and quartiles of processor time. Two questions:
// second mesh placed by a pose, and the same mesh with its vertices moved beforehand (then FCL's boxes along
// the axes need no motion). Each FCL model with its three ways to split; the fastest one counts.
#include <fcl/geometry/bvh/BVH_model.h>
#include <fcl/narrowphase/collision.h>
#include <malloc.h>
#include <time.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "engine/geometry/bvh_queries.h"

namespace feder {
namespace {

using fcl::detail::SplitMethodType;

// A torus with `waves` bumps along it, 2 around * across triangles.
TriangleMesh bumpy_torus(int around, int across, double bump, int waves) {
  TriangleMesh mesh;
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const double u = 2.0 * std::numbers::pi * i / around, v = 2.0 * std::numbers::pi * j / across;
      const double tube = 0.4 * (1.0 + bump * std::sin(waves * u) * std::cos(5 * v)),
                   r = 1.0 + tube * std::cos(v);
      mesh.vertices.emplace_back(r * std::cos(u), r * std::sin(u), tube * std::sin(v));
    }
  for (int i = 0; i < around; ++i)
    for (int j = 0; j < across; ++j) {
      const int next_i = (i + 1) % around, next_j = (j + 1) % across;
      const int a = i * across + j, b = next_i * across + j, c = next_i * across + next_j,
                d = i * across + next_j;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
  return mesh;
}

struct Times {
  std::vector<double> ms;
  double at(double fraction) {
    std::sort(ms.begin(), ms.end());
    return ms[static_cast<std::size_t>(fraction * static_cast<double>(ms.size() - 1) + 0.5)];
  }
};

// Of this thread: less disturbed by what else runs than time on the wall.
double processor_ms() {
  timespec t;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

template <class Work>
void measure(Times& times, Work&& work) {
  const double start = processor_ms();
  work();
  times.ms.push_back(processor_ms() - start);
}

// One way to answer: `build` both hierarchies, `count` the pairs.
struct Rival {
  std::string name;
  std::function<void()> clear, build;
  std::function<std::size_t()> count;
  Times build_times{}, count_times{};
  std::size_t pairs = 0;
};

struct FclData {
  std::vector<fcl::Vector3d> vertices;
  std::vector<fcl::Triangle> triangles;
};
FclData fcl_data(const TriangleMesh& mesh) {
  FclData out{mesh.vertices, {}};
  for (const auto& [i, j, k] : mesh.triangles)
    out.triangles.emplace_back(static_cast<std::size_t>(i), static_cast<std::size_t>(j),
                               static_cast<std::size_t>(k));
  return out;
}

template <class Volume>
std::shared_ptr<fcl::BVHModel<Volume>> fcl_model(const FclData& data, SplitMethodType split) {
  auto model = std::make_shared<fcl::BVHModel<Volume>>();
  model->bv_splitter = std::make_shared<fcl::detail::BVSplitter<Volume>>(split);
  model->beginModel(static_cast<int>(data.triangles.size()), static_cast<int>(data.vertices.size()));
  model->addSubModel(data.vertices, data.triangles);
  model->endModel();
  return model;
}

template <class Volume>
Rival fcl_rival(const std::string& name, const FclData& a, const FclData& b, const fcl::Transform3d& pose_b,
                SplitMethodType split) {
  struct Models {
    std::shared_ptr<fcl::BVHModel<Volume>> a, b;
  };
  const auto models = std::make_shared<Models>();
  return {name, [=] { *models = {}; },
          [=, &a, &b] {
            *models = {fcl_model<Volume>(a, split), fcl_model<Volume>(b, split)};
          },
          [=] {
            fcl::CollisionRequestd request(std::size_t{1} << 40, false);
            fcl::CollisionResultd result;
            return fcl::collide(models->a.get(), fcl::Transform3d::Identity(), models->b.get(), pose_b,
                                request, result);
          }};
}

template <class Volume>
Rival our_rival(const std::string& name, const TriangleMesh& a, const TriangleMesh& b, const Pose& pose_b) {
  struct Models {
    Bvh<Volume> a, b;
  };
  const auto models = std::make_shared<Models>();
  return {name, [=] { *models = {}; },
          [=, &a, &b] {
            *models = {Bvh<Volume>(a), Bvh<Volume>(b)};
          },
          [=] { return all_overlaps(models->a, Pose{}, models->b, pose_b).size(); }};
}

void compare(const char* what, int around, int across, bool turned, int repetitions) {
  const TriangleMesh mesh = bumpy_torus(around, across, 0.1, 7);
  Pose pose;
  pose.position = {0.5, 0.3, 0.2};
  if (turned) pose.rotation = Eigen::AngleAxisd(0.9, Vector3d(1, 2, 3).normalized()).matrix();
  fcl::Transform3d fcl_pose = fcl::Transform3d::Identity();
  fcl_pose.linear() = pose.rotation;
  fcl_pose.translation() = pose.position;
  TriangleMesh moved = mesh;
  for (Vector3d& x : moved.vertices) x = pose.rotation * x + pose.position;
  const FclData fcl_a = fcl_data(mesh), fcl_moved = fcl_data(moved);
  const fcl::Transform3d at_rest = fcl::Transform3d::Identity();

  std::vector<Rival> rivals;
  rivals.push_back(our_rival<Aabb>("feder Aabb, pose", mesh, mesh, pose));
  rivals.push_back(our_rival<Obb>("feder Obb, pose", mesh, mesh, pose));
  rivals.push_back(our_rival<Sphere>("feder Sphere, pose", mesh, mesh, pose));
  rivals.push_back(our_rival<Aabb>("feder Aabb, moved", mesh, moved, Pose{}));
  const std::pair<const char*, SplitMethodType> splits[] = {{"mean", fcl::detail::SPLIT_METHOD_MEAN},
                                                            {"median", fcl::detail::SPLIT_METHOD_MEDIAN},
                                                            {"centre", fcl::detail::SPLIT_METHOD_BV_CENTER}};
  for (const auto& [name, split] : splits) {
    const std::string suffix = std::string(", ") + name;
    rivals.push_back(fcl_rival<fcl::AABBd>("FCL AABB, pose" + suffix, fcl_a, fcl_a, fcl_pose, split));
    rivals.push_back(fcl_rival<fcl::OBBRSSd>("FCL OBBRSS, pose" + suffix, fcl_a, fcl_a, fcl_pose, split));
    rivals.push_back(fcl_rival<fcl::AABBd>("FCL AABB, moved" + suffix, fcl_a, fcl_moved, at_rest, split));
  }
  for (int k = 0; k < repetitions; ++k)
    for (Rival& rival : rivals) {
      measure(rival.build_times, rival.build);
      for (int again = 0; again < 3; ++again)
        measure(rival.count_times, [&] { rival.pairs = rival.count(); });
      rival.clear();
    }

  std::printf("\n%s, 2 x %zu triangles, %d repetitions\n%-32s %28s %28s %9s\n", what, mesh.triangles.size(),
              repetitions, "ms: median (quartiles)", "build of both", "all pairs", "pairs");
  for (Rival& rival : rivals)
    std::printf("%-32s %10.3f (%7.3f, %7.3f) %10.4f (%7.4f, %7.4f) %9zu\n", rival.name.c_str(),
                rival.build_times.at(0.5), rival.build_times.at(0.25), rival.build_times.at(0.75),
                rival.count_times.at(0.5), rival.count_times.at(0.25), rival.count_times.at(0.75),
                rival.pairs);
  const auto least = [&](const char* who, const char* how, Times Rival::*times) {
    double least_median = std::numeric_limits<double>::infinity();
    for (Rival& rival : rivals)
      if (rival.name.starts_with(who) && rival.name.find(how) != std::string::npos)
        least_median = std::min(least_median, (rival.*times).at(0.5));
    return least_median;
  };
  std::printf("FCL's fastest over feder Aabb: build %.2f, all pairs with a pose %.2f, moved %.2f\n",
              least("FCL", "", &Rival::build_times) / least("feder Aabb", "", &Rival::build_times),
              least("FCL", "pose", &Rival::count_times) / least("feder Aabb", "pose", &Rival::count_times),
              least("FCL", "moved", &Rival::count_times) / least("feder Aabb", "moved", &Rival::count_times));
  std::fflush(stdout);
}

}  // namespace
}  // namespace feder

int main(int argc, char** argv) {
  // freed memory stays with the process: no rival pays for pages another has used before
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  mallopt(M_TRIM_THRESHOLD, 2147483647);
  const int repetitions = argc > 1 ? std::atoi(argv[1]) : 9, largest = argc > 2 ? std::atoi(argv[2]) : 3;
  const int sizes[3][2] = {{100, 50}, {316, 158}, {1000, 500}};
  for (const auto& [around, across] : std::span(sizes).first(static_cast<std::size_t>(largest)))
    for (bool turned : {false, true})
      feder::compare(turned ? "bumpy tori, turned" : "bumpy tori, displaced", around, across, turned,
                     repetitions);
}
