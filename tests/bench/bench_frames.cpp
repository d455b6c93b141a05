// Time per frame of each file a run writes, on the 100 x 100 cloth with numbers of full length: mean and
// median of add(), then positions() and finish() of the whole run, and a vtu frame with the wait for the
// disk.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numeric>
#include <vector>

#include "experiments/support/files.h"
#include "experiments/support/frame_files.h"
#include "models/catalog.h"
#include "models/scene_file/scene_of.h"
#include "tests/experiments/temporary_folder.h"

namespace feder::experiments {
namespace {

constexpr std::int64_t kFrames = 100;

double milliseconds(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

void measure(const char* what, const Scene& scene, const FrameOptions& options) {
  const TemporaryFolder folder;
  FrameFiles files(scene, kFrames, folder.path(), options);
  State state = scene.model.state;
  History history;
  history.lambda.setLinSpaced(scene.model.system.rows, -1.0 / 3.0, 1.0 / 7.0);
  std::vector<double> frames;
  for (std::int64_t i = 0; i < kFrames; ++i) {
    state.t = 0.1 * static_cast<double>(i);
    for (Eigen::Index k = 0; k < state.v.size(); ++k) {
      state.v[k] = std::cos(static_cast<double>(k) + state.t);
      state.q[k] += 1e-4 * state.v[k];
    }
    frames.push_back(milliseconds([&] { files.add(i, state, history); }));
  }
  const double positions = milliseconds([&] { (void)files.positions(); });
  const double finish = milliseconds([&] { files.finish(); });
  const double mean = std::accumulate(frames.begin(), frames.end(), 0.0) / static_cast<double>(kFrames);
  std::nth_element(frames.begin(), frames.begin() + kFrames / 2, frames.end());
  std::printf("%-24s %8.2f %8.2f %10.0f %8.0f\n", what, mean, frames[kFrames / 2], positions, finish);
}

void run() {
  const Scene scene = scene_of(make_model("S2(100)"));
  const FrameOptions none{.states = false, .energy = false};
  const auto only = [&](bool FrameOptions::*file) {
    FrameOptions options = none;
    options.*file = true;
    return options;
  };
  std::printf("%-24s %8s %8s %10s %8s\n", "ms", "mean", "median", "positions", "finish");
  measure("states.csv", scene, only(&FrameOptions::states));
  measure("trajectory.csv", scene, only(&FrameOptions::trajectory_csv));
  measure("trajectory.npy", scene, only(&FrameOptions::trajectory_npy));
  measure("rows.csv", scene, only(&FrameOptions::rows));
  measure("energy.csv", scene, only(&FrameOptions::energy));
  measure("vtu, pvd", scene, only(&FrameOptions::vtu));
  measure("states, npy, energy", scene, {.trajectory_npy = true});
  measure("states, npy, energy, vtu", scene, {.trajectory_npy = true, .vtu = true});

  const TemporaryFolder folder;
  const std::string text(4'000'000, 'A');
  const double synced = milliseconds([&] { write_file(folder.path() / "a", text); });
  std::printf("%-24s %8.2f\n", "4 MB with fsync", synced);
}

}  // namespace
}  // namespace feder::experiments

int main() {
  feder::experiments::run();
}
