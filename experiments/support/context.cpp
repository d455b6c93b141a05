#include "experiments/support/context.h"

#include <cstdio>

#include "experiments/support/interrupt.h"

namespace feder::experiments {

Context::Context(Settings settings_, Table table_, std::uint64_t seed_, int threads_,
                 std::filesystem::path out_, bool quiet)
    : settings(std::move(settings_)),
      table(std::move(table_)),
      seed(seed_),
      threads(threads_),
      out(std::move(out_)),
      progress(quiet),
      quiet_(quiet) {}

bool Context::interrupted() const {
  return interrupt_requested();
}

void Context::log(const std::string& line) {
  if (quiet_) return;
  progress.clear();
  // A closed pipe is no reason to lose the results: the outcome of this output is ignored.
  std::fputs((line + "\n").c_str(), stdout);
  std::fflush(stdout);
}

void Context::note(std::string sentence) {
  notes_.push_back(std::move(sentence));
}

void Context::add_chart(Chart chart) {
  charts_.push_back(std::move(chart));
}

void Context::add_table(std::string name, Table extra) {
  extra_tables_.emplace_back(std::move(name), std::move(extra));
}

void Context::fail(Status status) {
  if (status_.ok()) status_ = std::move(status);
}

}  // namespace feder::experiments
