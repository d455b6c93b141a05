#include "solvers/linear/block_cholesky.h"

#include <algorithm>

namespace feder {

void BlockCholesky::analyze(int block_columns, std::vector<std::pair<int, int>> edges) {
  *this = BlockCholesky();
  kernels_ = &block_kernels();
  set_pattern(block_columns, edges);
  const BlockSymbolic symbolic = block_symbolic(start_, row_);
  flops_ = symbolic.flops;
  factor_blocks_ = symbolic.factor_blocks;
  place_links(symbolic);
  place_panels(symbolic);
  list_updates(symbolic);
}

void BlockCholesky::set_pattern(int block_columns, std::vector<std::pair<int, int>>& edges) {
  for (auto& [i, j] : edges)
    if (i < j) std::swap(i, j);
  for (int j = 0; j < block_columns; ++j) edges.emplace_back(j, j);
  std::sort(edges.begin(), edges.end(), [](const auto& x, const auto& y) {
    return x.second != y.second ? x.second < y.second : x.first < y.first;
  });
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  start_.assign(block_columns + 1, 0);
  for (const auto& [i, j] : edges) {
    row_.push_back(i);
    ++start_[j + 1];
  }
  for (int j = 0; j < block_columns; ++j) start_[j + 1] += start_[j];
  values_.assign(9 * row_.size(), 0.0);
}

int BlockCholesky::slot(int i, int j) const {
  if (j < 0 || i < j || j + 1 >= static_cast<int>(start_.size())) return -1;
  const auto begin = row_.begin() + start_[j], end = row_.begin() + start_[j + 1];
  const auto found = std::lower_bound(begin, end, i);
  return found != end && *found == i ? 9 * static_cast<int>(found - row_.begin()) : -1;
}

void BlockCholesky::place_links(const BlockSymbolic& symbolic) {
  const std::size_t count = symbolic.links.size();
  std::vector<int> number(symbolic.parent.size(), -1), parent(count, -1);
  for (std::size_t k = 0; k < count; ++k) number[symbolic.links[k]] = static_cast<int>(k);
  for (std::size_t k = 0; k < count; ++k)
    if (const int up = symbolic.parent[symbolic.links[k]]; up >= 0) parent[k] = number[up];
  LinkSchedule schedule = schedule_links(parent);
  std::vector<std::vector<int>> children(count);
  std::vector<int> place(count);
  for (std::size_t k = 0; k < count; ++k) place[schedule.order[k]] = static_cast<int>(k);
  for (std::size_t k = 0; k < count; ++k) {
    const int column = symbolic.links[schedule.order[k]], up = parent[schedule.order[k]];
    link_column_.push_back(column);
    link_value_.push_back(9 * start_[column]);
    link_parent_.push_back(symbolic.parent[column]);
    if (up >= 0) children[place[up]].push_back(static_cast<int>(k));
  }
  link_child_start_.push_back(0);
  for (std::size_t k = 0, run = 0; k < count; ++k) {
    while (static_cast<int>(k) >= schedule.runs[run].end) ++run;
    const int just_before = static_cast<int>(k) - (schedule.runs[run].pairs ? 2 : 1);
    for (int child : children[k])
      if (!(schedule.follows[k] && child == just_before)) link_child_.push_back(child);
    link_child_start_.push_back(static_cast<int>(link_child_.size()));
  }
  link_follows_ = std::move(schedule.follows);
  link_run_ = std::move(schedule.runs);
  link_.assign(count, {});
}

// Storage of the panels, and where A's blocks and the links go in them.
void BlockCholesky::place_panels(const BlockSymbolic& symbolic) {
  std::vector<std::vector<int>> links_into(symbolic.parent.size());
  for (std::size_t k = 0; k < link_parent_.size(); ++k)
    if (link_parent_[k] >= 0) links_into[link_parent_[k]].push_back(static_cast<int>(k));
  std::vector<int> position(symbolic.parent.size(), -1);
  std::size_t size = 0, most = 0;
  for (const BlockPanel& from : symbolic.panels) {
    Panel panel{};
    panel.offset = size;
    panel.first = from.first;
    panel.rows = 3 * from.block_rows();
    panel.columns = 3 * from.columns;
    panel.stride = (panel.rows + kPanelAlignment - 1) / kPanelAlignment * kPanelAlignment;
    panel.below = static_cast<int>(below_.size());
    panel.below_count = static_cast<int>(from.below.size());
    below_.insert(below_.end(), from.below.begin(), from.below.end());
    for (std::size_t i = 0; i < from.below.size(); ++i)
      position[from.below[i]] = from.columns + static_cast<int>(i);
    for (int c = 0; c < from.columns; ++c) position[from.first + c] = c;
    for (int c = 0; c < from.columns; ++c) {
      const int column = from.first + c;
      for (int p = start_[column]; p < start_[column + 1]; ++p)
        copy_.push_back({9 * p, 3 * (c * panel.stride + position[row_[p]])});
      for (int k : links_into[column]) link_update_.push_back({k, 3 * (c * panel.stride + c)});
    }
    panel.copy_end = static_cast<int>(copy_.size());
    panel.link_end = static_cast<int>(link_update_.size());
    size += static_cast<std::size_t>(panel.stride) * panel.columns;
    most = std::max<std::size_t>(most, panel.stride);
    panel_.push_back(panel);
  }
  storage_.assign(size + kBlockSlack, 0.0);
  work_.assign(most + kBlockSlack, 0.0);
}

// Every panel's rows fall on the columns of some panels to come: one update for each of these.
void BlockCholesky::list_updates(const BlockSymbolic& symbolic) {
  const int count = static_cast<int>(panel_.size());
  std::vector<int> panel_of(symbolic.parent.size(), -1), position(symbolic.parent.size(), -1);
  for (int s = 0; s < count; ++s)
    for (int c = 0; c < symbolic.panels[s].columns; ++c) panel_of[symbolic.panels[s].first + c] = s;
  std::vector<std::vector<std::pair<int, int>>> incoming(count);  // source and its first row below
  for (int s = 0; s < count; ++s) {
    const std::vector<int>& below = symbolic.panels[s].below;
    for (std::size_t i = 0; i < below.size(); ++i)
      if (i == 0 || panel_of[below[i]] != panel_of[below[i - 1]])
        incoming[panel_of[below[i]]].emplace_back(s, static_cast<int>(i));
  }
  for (int t = 0; t < count; ++t) {
    const BlockPanel& target = symbolic.panels[t];
    for (int c = 0; c < target.columns; ++c) position[target.first + c] = c;
    for (std::size_t i = 0; i < target.below.size(); ++i)
      position[target.below[i]] = target.columns + static_cast<int>(i);
    for (const auto& [s, first] : incoming[t]) {
      const BlockPanel& source = symbolic.panels[s];
      Update update{panel_[s].offset + 3 * (source.columns + first),
                    panel_[s].stride,
                    panel_[s].columns,
                    static_cast<int>(source.below.size()) - first,
                    0,
                    static_cast<int>(relative_.size())};
      for (std::size_t i = first; i < source.below.size(); ++i) {
        update.columns += panel_of[source.below[i]] == t;
        relative_.push_back(position[source.below[i]]);
      }
      update_.push_back(update);
    }
    panel_[t].update_end = static_cast<int>(update_.size());
  }
}

LinkView BlockCholesky::links() const {
  return {static_cast<int>(link_.size()),
          link_run_.data(),
          link_column_.data(),
          link_parent_.data(),
          link_value_.data(),
          link_follows_.data(),
          link_child_start_.data(),
          link_child_.data()};
}

PanelView BlockCholesky::view(const Panel& panel) const {
  return {const_cast<double*>(storage_.data()) + panel.offset, panel.rows, panel.columns, panel.stride};
}

// A's blocks less what links take away; `copy` and `link` are where the panel's lists start.
void BlockCholesky::fill_panel(const Panel& panel, int copy, int link) {
  double* at = storage_.data() + panel.offset;
  std::fill(at, at + static_cast<std::size_t>(panel.stride) * panel.columns, 0.0);
  for (; copy < panel.copy_end; ++copy) {
    const double* from = values_.data() + copy_[copy].value;
    double* to = at + copy_[copy].target;
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r < 3; ++r) to[c * panel.stride + r] = from[3 * c + r];
  }
  for (int c = 0; c < panel.columns; ++c) work_[c] = at[c * (panel.stride + 1)];
  for (; link < panel.link_end; ++link) {
    double p[6];
    passed(link_[link_update_[link].link], p);
    double *to = at + link_update_[link].target, *next = to + panel.stride;
    to[0] -= p[0], to[1] -= p[1], to[2] -= p[2], next[1] -= p[3], next[2] -= p[4];
    next[panel.stride + 2] -= p[5];
  }
}

bool BlockCholesky::factor() {
  watch_ = {};
  if (!factor_links(links(), values_.data(), link_.data(), watch_)) return false;
  int copy = 0, link = 0, update = 0;
  for (const Panel& panel : panel_) {
    fill_panel(panel, copy, link);
    copy = panel.copy_end, link = panel.link_end;
    double* at = storage_.data() + panel.offset;
    for (; update < panel.update_end; ++update) {
      const Update& u = update_[update];
      kernels_->update(storage_.data() + u.source, u.stride, u.depth, u.rows, u.columns,
                       relative_.data() + u.relative, at, panel.stride);
    }
    if (!kernels_->eliminate(view(panel), work_.data(), 3 * panel.first, watch_)) return false;
  }
  return true;
}

double BlockCholesky::smallest_pivot_ratio() const {
  return watch_.column < 0 ? 1.0 : watch_.pivot / watch_.original;
}

void BlockCholesky::solve(double* x) const {
  forward_links(links(), link_.data(), x);
  for (const Panel& panel : panel_) {
    double *own = x + 3 * panel.first, *work = work_.data();
    const int* below = below_.data() + panel.below;
    std::copy(own, own + panel.columns, work);
    std::fill(work + panel.columns, work + panel.stride, 0.0);
    kernels_->forward(view(panel), work);
    std::copy(work, work + panel.columns, own);
    work += panel.columns;
    for (int i = 0; i < panel.below_count; ++i)
      for (int c = 0; c < 3; ++c) x[3 * below[i] + c] += work[3 * i + c];
  }
  for (std::size_t s = panel_.size(); s-- > 0;) {
    const Panel& panel = panel_[s];
    double *own = x + 3 * panel.first, *work = work_.data();
    const int* below = below_.data() + panel.below;
    std::copy(own, own + panel.columns, work);
    for (int i = 0; i < panel.below_count; ++i)
      for (int c = 0; c < 3; ++c) work[panel.columns + 3 * i + c] = x[3 * below[i] + c];
    std::fill(work + panel.rows, work + panel.stride, 0.0);
    kernels_->backward(view(panel), work);
    std::copy(work, work + panel.columns, own);
  }
  backward_links(links(), link_.data(), x);
}

}  // namespace feder
