#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "engine/status.h"
#include "experiments/support/chart.h"
#include "experiments/support/progress.h"
#include "experiments/support/settings.h"
#include "experiments/support/table.h"

namespace feder::experiments {

/// What the body of an experiment works with. run_experiment() writes the files once the body has returned.
class Context {
 public:
  Context(Settings settings_, Table table_, std::uint64_t seed_, int threads_, std::filesystem::path out_,
          bool quiet);

  const Settings settings;
  Table table;  ///< becomes <name>.csv
  const std::uint64_t seed;
  const int threads;
  const std::filesystem::path out;  ///< exists
  Progress progress;

  /// True after Ctrl-C or SIGTERM: leave the loop; what is in the table is still written and the exit code is
  /// 130.
  bool interrupted() const;
  /// A line on stdout, nothing under --quiet.
  void log(const std::string& line);
  /// A conclusion, one sentence: printed at the end and shown on the page.
  void note(std::string sentence);
  /// A chart, drawn after the table has been written.
  void add_chart(Chart chart);
  /// A second table, written as <name>.csv; it is not part of the results hash.
  void add_table(std::string name, Table extra);
  /// The experiment itself failed (for instance: its judge did not converge). The first failure decides the
  /// exit code. A single failed run is not this: it is a row of the table.
  void fail(Status status);

  const std::vector<std::string>& notes() const { return notes_; }
  const std::vector<Chart>& charts() const { return charts_; }
  const std::vector<std::pair<std::string, Table>>& extra_tables() const { return extra_tables_; }
  const Status& status() const { return status_; }

 private:
  bool quiet_;
  std::vector<std::string> notes_;
  std::vector<Chart> charts_;
  std::vector<std::pair<std::string, Table>> extra_tables_;
  Status status_;
};

}  // namespace feder::experiments
