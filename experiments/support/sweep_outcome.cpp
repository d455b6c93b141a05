#include "experiments/support/sweep_outcome.h"

#include <fmt/format.h>

#include <csignal>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "engine/status.h"
#include "experiments/support/files.h"

namespace feder::experiments {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kLongestReason = 500;

/// The exit code that belongs to a status word; empty for a word the contract does not know.
std::optional<int> exit_code_of(std::string_view status) {
  if (status == "internal_error") return 1;
  if (status == "bad_input") return 2;
  for (int code = 0; code <= static_cast<int>(StatusCode::kOutOfMemory); ++code) {
    if (status == to_string(static_cast<StatusCode>(code))) return exit_code(static_cast<StatusCode>(code));
  }
  return std::nullopt;
}

std::string status_of_exit_code(int code) {
  switch (code) {
    case 2:
      return "bad_input";
    case 4:
      return "io_error";
    case 5:
      return "limit_reached";
    case 130:
      return "interrupted";
    default:
      return "internal_error";
  }
}

/// Empty if there is no such file.
std::string first_line(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string line(kLongestReason, ' ');
  file.read(line.data(), static_cast<std::streamsize>(line.size()));
  line.resize(std::min(static_cast<std::size_t>(file.gcount()), line.find_first_of("\r\n")));
  for (char& c : line) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  }
  return line;
}

/// Without a manifest the programs of this project still say "<program>: <status>: <reason>" on stderr.
CaseOutcome without_manifest(int code, const std::filesystem::path& folder) {
  const std::string line = first_line(folder / "stderr.txt");
  const std::size_t word = line.find(": ") + 2;
  const std::size_t colon = line.find(": ", word);
  if (word != std::string::npos + 2 && colon != std::string::npos &&
      exit_code_of(line.substr(word, colon - word)) == code && code != 0)
    return {line.substr(word, colon - word), line.substr(colon + 2)};
  return {status_of_exit_code(code),
          line.empty() ? fmt::format("exit code {} without a manifest", code) : line};
}

Cell to_cell(const Json& value) {
  if (value.is_null()) return {};
  if (value.is_number()) return value.get<double>();
  return value.get<std::string>();
}

CaseOutcome from_manifest(const std::string& text, int code) {
  const Json manifest = Json::parse(text);
  const Json reason = manifest.value("reason", Json());
  CaseOutcome outcome{manifest.at("status"), reason.is_null() ? "" : reason.get<std::string>()};
  if (exit_code_of(outcome.status) != code) {
    return {"internal_error", fmt::format("exit code {}, but the manifest says '{}'", code, outcome.status)};
  }
  const Json results = manifest.value("results", Json::object());
  for (const std::string& column : result_columns()) {
    if (column != "status" && column != "reason" && results.contains(column))
      outcome.results[column] = to_cell(results.at(column));
  }
  return outcome;
}

CaseOutcome judge_end(const ChildEnd& end, const std::filesystem::path& folder, double limit) {
  const bool finished = end.signal == 0 && end.exit_code == 0;
  if (end.stopped && !finished) return {"limit_reached", fmt::format("no end after {} s", limit), 0, limit};
  if (end.signal != 0)
    return {"internal_error", fmt::format("killed by signal {} ({})", end.signal, ::strsignal(end.signal))};
  const std::filesystem::path path = folder / "manifest.json";
  if (!std::filesystem::exists(path)) return without_manifest(end.exit_code, folder);
  try {
    return from_manifest(read_file(path), end.exit_code);
  } catch (const Json::exception& error) {
    return {"internal_error", fmt::format("the manifest cannot be read: {}", error.what())};
  }
}

}  // namespace

CaseOutcome judge(const ChildEnd& end, const std::filesystem::path& folder, double limit) {
  CaseOutcome outcome = judge_end(end, folder, limit);
  outcome.seconds = end.seconds;
  return outcome;
}

bool is_final(const CaseOutcome& outcome, double limit) {
  return outcome.status != "interrupted" && outcome.status != "io_error" &&
         (outcome.limit == 0 || outcome.limit >= limit);
}

void write_outcome(const std::filesystem::path& folder, const CaseOutcome& outcome,
                   std::string_view fingerprint) {
  Json results = Json::object();
  for (const auto& [column, cell] : outcome.results) {
    if (cell.empty()) continue;
    results[column] = cell.is_number() ? Json(cell.number()) : Json(cell.text());
  }
  const Json json = {{"fingerprint", fingerprint}, {"status", outcome.status}, {"reason", outcome.reason},
                     {"seconds", outcome.seconds}, {"limit", outcome.limit},   {"results", results}};
  write_file(folder / "outcome.json", json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
}

std::optional<CaseOutcome> read_outcome(const std::filesystem::path& folder, std::string_view fingerprint) {
  const std::filesystem::path path = folder / "outcome.json";
  if (!std::filesystem::exists(path)) return std::nullopt;
  try {
    const Json json = Json::parse(read_file(path));
    if (json.at("fingerprint") != fingerprint) return std::nullopt;
    CaseOutcome outcome{json.at("status"), json.at("reason"), json.at("seconds"), json.at("limit")};
    for (const auto& [column, value] : json.at("results").items()) outcome.results[column] = to_cell(value);
    return outcome;
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

}  // namespace feder::experiments
