#include "models/scene_file/scene_file.h"

namespace feder {
namespace {

constexpr const char* kIntroduction = R"(# Scene files

A scene is one TOML file. All units are SI (m, kg, s, rad, N); y is up where the examples have gravity. Keys of
the top level come first, then tables: `[method]` once, `[[spring]]` as often as needed.

**Names.** Particles, points, bodies and generators need a `name` of their own; others use it to refer to them.
The parts of generators are called `rope[3]`, `cloth[0,4]`, `block[1,2,3]`. A `group`, or a generator's name, stands
for all its members in `[[force]]`.

**Anchors** are what springs hold on to: a name (`"tip"`; of a body: the origin of its axes), a point of a body in
its own axes (`{body = "bar", point = [0.5, 0, 0]}`), the point of a body that lies at a place of the world at the
start (`{body = "bar", place = [1, 2, 0]}`), or a fixed place of the world (`[1, 2, 0]`). Joints, turns and slides lie
between two bodies by name, or a body and `"world"`; their places and axes are given in the world at the start.

**Angles** count turns from the start: `[[turn]]` sees how far the second has turned against the first about the
axis, positive by the right-hand rule.

**Expressions** are texts of the named variables: `+ - * / ^`, comparisons, `&& ||`, `a ? b : c`, `pi`, `sin cos tan
asin acos atan atan2 sinh cosh tanh exp ln log10 sqrt abs sign min max`. Their derivatives are exact. Tables
`[[x, y], ...]` become smooth curves through the points, monotone where the points are.

**Stiffness** may be `"rigid"`: the row is then held exactly. A mass of `"fixed"` never moves.

A key that is unknown, has the wrong type or a value outside its range is an error with line and column, and
nothing is run.
)";

std::string cell(const std::string& text) {
  std::string out;
  for (char c : text) out += c == '|' ? std::string("\\|") : std::string(1, c);
  return out;
}

std::string table_text(const TableInfo& table) {
  std::string text = "\n## ";
  text += table.name.empty() ? "Top level"
          : table.repeated   ? "`[[" + table.name + "]]`"
                             : "`[" + table.name + "]`";
  text += "\n\n" + table.what + "\n\n| key | unit | default | value | meaning |\n|---|---|---|---|---|\n";
  for (const KeyInfo& key : table.keys) {
    text += "| `" + key.name + "` | " + cell(key.unit) + " | ";
    text += (key.required ? "**required**" : cell(key.default_value)) + " | " + cell(key.expectation) + " | ";
    text += cell(key.what) + " |\n";
  }
  return text;
}

}  // namespace

std::string scene_reference(const std::vector<TableInfo>& others) {
  std::string text = kIntroduction;
  for (const TableInfo& table : scene_tables()) text += table_text(table);
  for (const TableInfo& table : others) text += table_text(table);
  return text;
}

}  // namespace feder
