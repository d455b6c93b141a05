#include "experiments/support/program.h"

#include <fmt/format.h>

#include <cfenv>
#include <clocale>
#include <cstdio>
#include <locale>

#include "experiments/support/interrupt.h"

namespace feder::experiments {

Ending ending_of(const Status& status) {
  return {exit_code(status.code), to_string(status.code), status.reason};
}

void fix_environment() {
  std::setlocale(LC_ALL, "C");
  std::locale::global(std::locale::classic());
  std::fesetround(FE_TONEAREST);
  watch_interrupts();
}

int report(const std::string& program, const Ending& ending) {
  if (ending.code != 0)
    std::fputs(fmt::format("{}: {}: {}\n", program, ending.status, ending.reason).c_str(), stderr);
  return ending.code;
}

}  // namespace feder::experiments
