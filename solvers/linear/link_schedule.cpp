// One link waits for its child, so two independent links at a time cost little more than one: both ends of a
// chain eliminated towards the middle, branches of a tree.
#include <queue>

#include "solvers/linear/block_links.h"

namespace feder {

LinkSchedule schedule_links(const std::vector<int>& parent) {
  const int count = static_cast<int>(parent.size());
  std::vector<int> pending(count, 0);
  for (int p : parent)
    if (p >= 0) ++pending[p];
  std::queue<int> ready;
  for (int k = 0; k < count; ++k)
    if (pending[k] == 0) ready.push(k);
  LinkSchedule out;
  int next[2] = {-1, -1};  // continues the lane
  while (true) {
    const bool continued[2] = {next[0] >= 0, next[1] >= 0};
    for (int& lane : next)
      if (lane < 0 && !ready.empty()) {
        lane = ready.front();
        ready.pop();
      }
    if (next[0] < 0 && next[1] < 0) return out;
    const bool pair = next[0] >= 0 && next[1] >= 0;
    const bool same_run = !out.runs.empty() && out.runs.back().pairs == pair;
    if (!same_run) out.runs.push_back({0, pair});
    for (int lane = 0; lane < 2; ++lane) {
      const int link = next[lane];
      if (link < 0) continue;
      out.order.push_back(link);
      out.follows.push_back(same_run && continued[lane]);
      const int up = parent[link];
      next[lane] = up >= 0 && --pending[up] == 0 ? up : -1;
    }
    out.runs.back().end = static_cast<int>(out.order.size());
  }
}

}  // namespace feder
