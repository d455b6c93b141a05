#include "experiments/support/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "experiments/support/files.h"
#include "experiments/support/html.h"
#include "experiments/support/page_style.h"
#include "experiments/support/table.h"

namespace feder::experiments {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// A text member; empty when missing or of another type.
std::string text_of(const Json& object, const char* key) {
  const auto member = object.find(key);
  return member != object.end() && member->is_string() ? member->get<std::string>() : "";
}

/// A file named by a manifest, which must lie in the manifest's own folder.
std::string read_sibling(const fs::path& folder, const std::string& name) {
  if (name.empty() || fs::path(name).filename() != name)
    throw IoError("the manifest names a strange file: " + name);
  return read_file(folder / name);
}

std::string warning(const std::string& text) {
  return "<p class=\"bad\">" + html_escape(text) + "</p>\n";
}

void replace_all(std::string& text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
}

/// The SVG element alone (XML declarations are not allowed inside HTML), its ids made unique by `prefix`.
std::string inline_svg(const std::string& file, const std::string& prefix) {
  const std::size_t begin = file.find("<svg");
  if (begin == std::string::npos) throw IoError("not an SVG picture");
  std::string svg = file.substr(begin);
  replace_all(svg, "id='", "id='" + prefix + "-");
  replace_all(svg, "id=\"", "id=\"" + prefix + "-");
  replace_all(svg, "'#gp", "'#" + prefix + "-gp");
  return svg;
}

std::string charts_html(const fs::path& folder, const Json& manifest) {
  std::string html;
  for (const Json& chart : manifest.value("charts", Json::array())) {
    const std::string name = text_of(chart, "name");
    html += fmt::format(
        "<figure>\n{}\n<figcaption>{} (<a href=\"{}/{}.gp\">gnuplot script</a>)</figcaption>\n</figure>\n",
        inline_svg(read_sibling(folder, name + ".svg"), html_escape(folder.filename().string() + "-" + name)),
        html_escape(text_of(chart, "caption")), html_escape(folder.filename().string()), html_escape(name));
  }
  return html;
}

std::string notes_html(const Json& manifest) {
  std::string html;
  for (const Json& note : manifest.value("notes", Json::array())) {
    html += "<li>" + html_escape(note.get<std::string>()) + "</li>\n";
  }
  return html.empty() ? "" : "<h3>What came out</h3>\n<ul>\n" + html + "</ul>\n";
}

std::string table_html(const fs::path& folder, const std::string& file, const std::string& expected_hash) {
  const Table table = from_csv(read_sibling(folder, file), file);
  std::string html;
  if (!expected_hash.empty() && results_hash(table) != expected_hash) {
    html +=
        warning("This table is not the one the manifest describes: the run that wrote it did not finish.");
  }
  return html +
         fmt::format(
             "<details open><summary>{} rows, rounded; every digit in <a href=\"{}/{}\">{}</a></summary>\n"
             "<div class=\"scroll\">\n{}</div></details>\n",
             table.rows(), html_escape(folder.filename().string()), html_escape(file), html_escape(file),
             to_html(table));
}

std::string section_body(const fs::path& folder, const Json& manifest) {
  std::string html =
      fmt::format("<p class=\"question\">{}</p>\n", html_escape(text_of(manifest, "question")));
  if (const std::string status = text_of(manifest, "status"); status != "ok") {
    html += warning(fmt::format("This run ended as {}: {}", status, text_of(manifest, "reason")));
  }
  html += charts_html(folder, manifest) + notes_html(manifest);
  html += table_html(folder, text_of(manifest, "table"), text_of(manifest, "results_hash"));
  for (const Json& name : manifest.value("extra_tables", Json::array())) {
    html += table_html(folder, name.get<std::string>() + ".csv", "");
  }
  html += fmt::format("<p class=\"limits\"><b>Does not model:</b> {}</p>\n",
                      html_escape(text_of(manifest, "does_not_model")));
  return html + fmt::format(
                    "<details><summary>Manifest: commit, compiler, machine, "
                    "options</summary>\n<pre>{}</pre></details>\n",
                    html_escape(manifest.dump(2)));
}

/// One experiment. Unreadable files become a message on the page instead of a missing section.
std::string section(const fs::path& folder) {
  const std::string name = html_escape(folder.filename().string());
  std::string html = fmt::format("<section id=\"{0}\">\n<h2>{0}</h2>\n", name);
  try {
    html += section_body(folder, Json::parse(read_file(folder / "manifest.json")));
  } catch (const std::exception& error) {
    html += warning(std::string("These results cannot be shown: ") + error.what());
  }
  return html + "</section>\n";
}

/// Runs of single scenes have neither question, table nor chart to show.
bool is_scene_run(const fs::path& folder) {
  std::ifstream file(folder / "manifest.json");
  const Json manifest = Json::parse(file, nullptr, false);
  return manifest.is_object() && text_of(manifest, "program") == "simulate";
}

std::vector<fs::path> experiment_folders(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> found;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (fs::exists(entry.path() / "manifest.json") && !is_scene_run(entry.path()))
      found.push_back(entry.path());
  }
  if (error) throw IoError("cannot read the folder '" + folder.string() + "': " + error.message());
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace

int write_page(const fs::path& folder) {
  const std::vector<fs::path> folders = experiment_folders(folder);
  std::string links;
  std::string sections;
  for (const fs::path& experiment : folders) {
    links += fmt::format("<a href=\"#{0}\">{0}</a>\n", html_escape(experiment.filename().string()));
    sections += section(experiment);
  }
  write_file(
      folder / "index.html",
      fmt::format(
          "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
          "<meta name=\"viewport\" content=\"width=device-width\">\n<title>Feder: results</title>\n"
          "<style>{}</style>\n</head>\n<body>\n<h1>Feder: results</h1>\n"
          "<p>Every number comes from the tables below; points that lie below the judge's own error are "
          "hollow.</p>\n<nav>\n{}</nav>\n{}</body>\n</html>\n",
          kPageStyle, links, sections));
  return static_cast<int>(folders.size());
}

}  // namespace feder::experiments
