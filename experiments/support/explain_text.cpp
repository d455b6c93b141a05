// An Explanation as text for people and as JSON for programs.
#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

#include "experiments/support/explain.h"

namespace feder::experiments {
namespace {

constexpr std::size_t kWidth = 120;
constexpr std::size_t kLabel = 14;

// "label        text", broken between words, further lines indented.
void put(std::string& out, const std::string& label, const std::string& text) {
  std::string line = fmt::format("{:<{}}", label, kLabel);
  bool first = true;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    if (!first && line.size() + 1 + word.size() > kWidth) {
      out += line + "\n";
      line = std::string(kLabel, ' ');
      first = true;
    }
    line += (first ? "" : " ") + word;
    first = false;
    begin = end + 1;
  }
  out += line + "\n";
}

std::string counted(int n, const std::string& one, const std::string& many) {
  return fmt::format("{} {}", n, n == 1 ? one : many);
}

std::string nodes_text(const Explanation& e) {
  std::string text = counted(e.unknowns, "free coordinate", "free coordinates") + " of " +
                     counted(e.particles, "particle", "particles") + " and " +
                     counted(e.bodies, "body", "bodies") + ", " +
                     counted(e.world_points, "world point", "world points");
  return e.driven > 0 ? text + ", " + std::to_string(e.driven) + " driven" : text;
}

std::string rows_text(const Explanation& e) {
  if (e.rows.empty()) return "none";
  std::string text = fmt::format("{}: {} finite, {} hard, {} inactive, {} damped;", e.all_rows.total(),
                                 e.all_rows.finite, e.all_rows.hard, e.all_rows.inactive, e.all_rows.damped);
  for (const RowCount& count : e.rows) text += fmt::format(" {} {},", count.total(), count.type);
  text.back() = ';';
  return text + fmt::format(" {:.0f} nonzeros in the matrix", e.matrix_nonzeros);
}

std::string hard_rows_text(const Explanation& e) {
  const std::string gaps =
      fmt::format("at the start |phi| <= {:.1e} m or 1, |J v| <= {:.1e} m/s or 1/s", e.gap, e.velocity_gap);
  if (e.rank < 0) return "rank " + e.rank_note + "; " + gaps;
  std::string text = fmt::format("rank {} of {}, {} dependent", e.rank, e.all_rows.hard, e.dependent);
  for (std::size_t i = 0; i < e.dependent_rows.size(); ++i)
    text += (i == 0 ? ": " : ", ") + e.dependent_rows[i];
  if (e.dependent > kNamedRows) text += ", ...";
  return text + "; " + gaps;
}

std::string frequency_text(const Explanation& e) {
  if (std::isnan(e.largest_frequency))
    return "not known" + (e.spectrum_left_out.empty() ? "" : ": " + e.spectrum_left_out);
  if (e.largest_frequency == 0.0 && e.spectrum_left_out.empty()) return "0: no stiffness";
  if (e.largest_frequency == 0.0) return "no finite stiffness; " + e.spectrum_left_out;
  std::string text =
      fmt::format("largest {}{:.5g} rad/s (period {:.3g} s", e.spectrum_left_out.empty() ? "" : "at most ",
                  e.largest_frequency, 2.0 * std::numbers::pi / e.largest_frequency);
  if (e.frequency_accuracy > 1e-5) text += fmt::format(", to {:.0e}", e.frequency_accuracy);
  text += ")";
  if (std::isfinite(e.smallest_frequency))
    text += fmt::format(", smallest {:.4g} rad/s, ratio {:.3g}", e.smallest_frequency, e.stiffness_ratio);
  text += fmt::format("; {:.3g} of the fastest periods in the run", e.fastest_periods);
  if (!e.spectrum_left_out.empty()) text += "; " + e.spectrum_left_out;
  return text;
}

std::string rates_text(const Explanation& e) {
  std::string text = fmt::format("damping {:.3g} 1/s, turning at the start {:.3g} rad/s",
                                 e.largest_damping_rate, e.turning_rate);
  if (e.excited_frequency > 1e-6 * e.largest_frequency)
    text += fmt::format(", springs at the start {:.3g} rad/s", e.excited_frequency);
  return e.swing_rate > 0.0 ? text + fmt::format(", free swing {:.3g} rad/s", e.swing_rate) : text;
}

// One line of the table of integrators.
std::string method_text(const MethodOutlook& m) {
  std::string limit, steps;
  if (std::isinf(m.limit))
    limit = "every dt";
  else if (m.limit == 0.0)
    limit = "none";
  else if (!std::isnan(m.limit))
    limit = fmt::format("{:.4g} s", m.limit), steps = fmt::format("{:.0f}", m.steps);
  else
    limit = "not predicted";
  if (!m.refusal.empty()) return fmt::format("{:<26}{:<7}refused: {}", m.name, m.order, m.refusal);
  std::string line = fmt::format("{:<26}{:<7}{:<15}{:<10}", m.name, m.order, limit, steps);
  if (!m.dt_asked.empty()) line += fmt::format("{:<10}", m.dt_asked);
  return line + m.why;
}

// One line of a table: cut where it is too long, without blanks at its end.
void put_line(std::string& out, std::string line) {
  line.erase(line.find_last_not_of(' ') + 1);
  if (line.size() > kWidth) line = line.substr(0, kWidth - 3) + "...";
  out += line + "\n";
}

void put_methods(std::string& out, const Explanation& e) {
  out += fmt::format("\n{:<26}{:<7}{:<15}{:<10}", "integrator", "order", "stable below", "steps");
  if (e.dt_asked > 0.0) out += fmt::format("{:<10}", fmt::format("{:.3g} s", e.dt_asked));
  out += "why\n";
  for (const MethodOutlook& m : e.methods) put_line(out, method_text(m));
}

std::string flops_text(double flops, const std::string& refusal) {
  return std::isnan(flops) ? (refusal.empty() ? "-" : "refused") : fmt::format("{:.2g}", flops);
}

void put_routes(std::string& out, const Explanation& e) {
  out += fmt::format("\n{:<16}{:<10}{:<10}{}\n", "route", "flops", "with Kg", "refused because");
  for (const RouteOutlook& r : e.routes)
    put_line(out, fmt::format("{:<16}{:<10}{:<10}{}", r.name, flops_text(r.flops, r.refusal),
                              flops_text(r.flops_geometric, r.refusal_geometric),
                              !r.refusal.empty() ? r.refusal : r.refusal_geometric));
  if (!e.route_note.empty()) put(out, "routes", e.route_note);
  put(out, "auto takes", e.auto_reason);
  put(out, "  with Kg", e.auto_reason_geometric);
}

void put_recommendation(std::string& out, const Explanation& e) {
  const Recommendation& r = e.recommended;
  if (r.integrator.empty()) {
    put(out, "recommended", r.why);
    return;
  }
  put(out, "recommended",
      fmt::format("{} at dt = {:.3g} s ({:.0f} steps). {}", r.integrator, r.dt, r.steps, r.why));
  put(out, "", r.not_known);
}

// JSON has neither.
nlohmann::ordered_json number(double x) {
  if (std::isnan(x)) return "nan";
  if (std::isinf(x)) return x > 0.0 ? "inf" : "-inf";
  return x;
}

nlohmann::ordered_json row_json(const RowCount& r) {
  return {{"type", r.type}, {"rows", r.total()},      {"finite", r.finite},
          {"hard", r.hard}, {"inactive", r.inactive}, {"damped", r.damped}};
}

nlohmann::ordered_json method_json(const MethodOutlook& m) {
  return {{"name", m.name},        {"order", m.order},
          {"refusal", m.refusal},  {"stable_below_s", number(m.limit)},
          {"why", m.why},          {"steps", number(m.steps)},
          {"dt_asked", m.dt_asked}};
}

nlohmann::ordered_json route_json(const RouteOutlook& r) {
  return {{"name", r.name},
          {"refusal", r.refusal},
          {"refusal_geometric", r.refusal_geometric},
          {"flops", number(r.flops)},
          {"flops_geometric", number(r.flops_geometric)}};
}

template <class Item, class Convert>
nlohmann::ordered_json list(const std::vector<Item>& items, Convert&& convert) {
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  for (const Item& item : items) out.push_back(convert(item));
  return out;
}

}  // namespace

std::string to_text(const Explanation& e) {
  std::string out;
  put(out, "scene", fmt::format("{}: {:.4g} s of a scene of {:.4g} m", e.scene, e.end_time, e.scene_length));
  put(out, "unknowns", nodes_text(e));
  put(out, "rows", rows_text(e));
  if (!e.not_linearised.empty()) put(out, "start", "cannot be linearised: " + e.not_linearised);
  if (e.all_rows.hard > 0) put(out, "hard rows", hard_rows_text(e));
  put(out, "freedom",
      e.degrees_of_freedom < 0 ? "not known: rank " + e.rank_note
                               : counted(e.degrees_of_freedom, "degree", "degrees") + " of freedom");
  put(out, "index", e.index);
  put(out, "frequencies", frequency_text(e));
  put(out, "rates", rates_text(e));
  put_methods(out, e);
  put_routes(out, e);
  out += "\n";
  put(out, "judge", e.judge);
  put_recommendation(out, e);
  return out;
}

std::string to_json(const Explanation& e) {
  const Recommendation& r = e.recommended;
  nlohmann::ordered_json j;
  j["scene"] = e.scene;
  j["end_time_s"] = number(e.end_time);
  j["scene_length_m"] = number(e.scene_length);
  j["dt_asked_s"] = number(e.dt_asked);
  j["nodes"] = {{"free_coordinates", e.unknowns},
                {"particles", e.particles},
                {"world_points", e.world_points},
                {"bodies", e.bodies},
                {"driven", e.driven}};
  j["rows"] = list(e.rows, row_json);
  j["matrix_nonzeros"] = number(e.matrix_nonzeros);
  j["hard_rows"] = {{"rows", e.all_rows.hard},
                    {"rank", e.rank},
                    {"dependent", e.dependent},
                    {"named", e.dependent_rows},
                    {"note", e.rank_note},
                    {"gap", number(e.gap)},
                    {"velocity_gap", number(e.velocity_gap)}};
  j["not_linearised"] = e.not_linearised;
  j["degrees_of_freedom"] = e.degrees_of_freedom;
  j["index"] = e.index;
  j["spectrum"] = {{"largest_frequency_rad_s", number(e.largest_frequency)},
                   {"smallest_frequency_rad_s", number(e.smallest_frequency)},
                   {"excited_frequency_rad_s", number(e.excited_frequency)},
                   {"accuracy", number(e.frequency_accuracy)},
                   {"largest_damping_rate_1_s", number(e.largest_damping_rate)},
                   {"stiffness_ratio", number(e.stiffness_ratio)},
                   {"fastest_periods", number(e.fastest_periods)},
                   {"turning_rate_rad_s", number(e.turning_rate)},
                   {"swing_rate_rad_s", number(e.swing_rate)},
                   {"left_out", e.spectrum_left_out}};
  j["integrators"] = list(e.methods, method_json);
  j["routes"] = list(e.routes, route_json);
  j["route_note"] = e.route_note;
  j["auto"] = e.auto_reason;
  j["auto_geometric"] = e.auto_reason_geometric;
  j["judge"] = e.judge;
  j["recommended"] = {{"integrator", r.integrator},
                      {"dt_s", number(r.dt)},
                      {"steps", number(r.steps)},
                      {"why", r.why},
                      {"not_known", r.not_known}};
  return j.dump(2) + "\n";
}

}  // namespace feder::experiments
