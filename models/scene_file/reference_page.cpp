#include "models/catalog.h"
#include "models/scene_file/scene_file.h"

namespace feder {
namespace {

constexpr const char* kIntroduction =
    R"page(# Scene files

A scene is one TOML file, and `simulate scene.toml --out results` runs it. A mass on a damped spring, whole:

```toml
end_time = 5
gravity = [0, -9.81, 0]

[[particle]]
name = "mass"
mass = 2
position = [0, -1, 0]

[[spring]]
name = "spring"
between = [[0, 0, 0], "mass"]
stiffness = 500
damping = 4

[method]
integrator = "leapfrog"
dt = 1e-3
```

A bar on a hinge, moved to and fro by a motor, with a rope at its end:

```toml
end_time = 4
quick_end_time = 0.5
gravity = [0, -9.81, 0]

[[body]]
name = "bar"
shape = "box"
mass = 1
edges = [0.6, 0.05, 0.05]
position = [0.3, 0, 0]

[[joint]]
type = "hinge"
between = ["world", "bar"]
place = [0, 0, 0]
axis = [0, 0, 1]

[[turn]]
name = "motor"
between = ["world", "bar"]
axis = [0, 0, 1]
target = "0.5*(1 - cos(2*t))"
stiffness = "rigid"

[[chain]]
name = "rope"
from = [0.6, -0.05, 0]
to = [0.6, -0.5, 0]
count = 10
mass = 0.2
stiffness = "rigid"

[[spring]]
name = "knot"
between = [{body = "bar", point = [0.3, 0, 0]}, "rope[0]"]
stiffness = "rigid"

[method]
integrator = "implicit_euler_newton"
dt = 2e-3

[output]
interval = 0.02
files = ["states", "energy", "rows"]
```

All units are SI (m, kg, s, rad, N), angles are radians. No axis is up by itself: the examples let gravity act along
-y. Keys of the top level come first, then tables in any order: `[method]` and `[output]` at most once, `[[spring]]`
and the like once for every spring. Keys without a default may be left out unless they say **required**.

**Names.** Particles, points, bodies and generators (chain, cloth, lattice, net) need a `name` that no other of them
has, materials one that no other material has; others use it to refer to them, in any order. The parts of generators
are called `rope[3]`, `cloth[0,4]`, `block[1,2,3]`, counted from 0. A `group`, or a generator's name, stands for all
its members in `[[force]]`.

**Anchors** are what springs hold on to: a name (`"tip"`; of a body: the origin of its axes), a point of a body in
its own axes (`{body = "bar", point = [0.5, 0, 0]}`), the point of a body that lies at a place of the world at the
start (`{body = "bar", place = [1, 2, 0]}`), or a fixed place of the world (`[1, 2, 0]`). Joints, turns, slides and
perpendiculars lie between two bodies by name, or a body and `"world"`; their places and axes are given in the world
at the start. What hangs on a particle is tied by springs, rigid ones where it is to hold.

**Angles** count turns from the start: `[[turn]]` sees how far the second of `between` has turned against the first
about the axis, positive by the right-hand rule. `[[slide]]` sees how far the second has moved along the axis.

**Expressions** are texts in the named variables: `+ - * / ^`, comparisons, `&& ||`, `a ? b : c`, `pi`, `sin cos tan
asin acos atan atan2 sinh cosh tanh exp ln log10 sqrt abs sign min max`. Their derivatives are exact. Tables
`[[x, y], ...]` become smooth curves through the points, monotone where the points are, straight beyond them.

**Stiffness** may be `"rigid"`: the row is then held exactly, and must be closed at the start. Velocities must fit the
rigid rows, too, also the `velocity` of a body that turns about a pin; what does not fit is told as a note, and the
first step takes it away. A mass of `"fixed"` never moves.

**Results** are CSV files in the folder of `--out`, one block of lines per frame; `files` of `[output]` says which.

* `states`, states.csv: place `x y z` and velocity `vx vy vz` by name, of a body those of its centre of mass, with
  the quaternion `qw qx qy qz` that turns its axes into the world, and its angular velocity `wx wy wz` in world axes.
* `energy`, energy.csv: `kinetic`, `rows` (held in springs), `external` (weight, and law springs whose law does not
  depend on the rate), `total`, momentum `px py pz`, angular momentum `lx ly lz` about the origin of the world.
* `rows`, rows.csv: of every spring, bending, joint, turn and slide its `phi`, how far it is from rest (m or rad; of
  rows that hold directions the cosine between them, of bending straight at rest 2 tan of half the angle), and its
  force or moment `lambda` = -stiffness * phi - damping * rate, negative where a spring pulls: the force on the
  second of `between` along growing `phi` (of a ball the components in world axes). Of implicit integrators it is that
  of the last step, first order in dt; of the others, and at the start, that of the state itself. Law springs have no
  row.
* `trajectory`, `npy`: trajectory.csv and trajectory.npy, one line per frame: all places, quaternions, velocities.
* `vtu`: frames/*.vtu and a .pvd that ParaView plays.

**Changes** for one run need no new file: `simulate scene.toml --set spring.knot.stiffness=1e5 --set method.dt=1e-3`.
`--preset quick` ends at `quick_end_time`, `--validate` only checks the file, `--explain` says which methods suit it.

A key that is unknown, has the wrong type or a value outside its range is an error with line and column, and
nothing is run. There are no contacts and no friction.
)page";

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

std::string catalog_text() {
  std::string text =
      "\n## Catalogue\n\nWhat `model` may name, with the parameters and their defaults. Where a parameter "
      "may be "
      "infinite, it is written \"rigid\".\n\n| model | what it is | parameters |\n|---|---|---|\n";
  for (const ModelInfo& model : catalog()) {
    std::string parameters;
    for (const Parameter& parameter : model.parameters)
      parameters += (parameters.empty() ? "`" : ", `") + parameter.name + "` " +
                    (parameter.default_value == "inf" ? "rigid" : parameter.default_value) +
                    (parameter.unit.empty() || parameter.default_value == "inf" ? "" : " " + parameter.unit);
    text += "| `" + model.name + "` | " + cell(model.description) + " | " + cell(parameters) + " |\n";
  }
  return text;
}

}  // namespace

std::string scene_reference(const std::vector<TableInfo>& others) {
  std::string text = kIntroduction;
  for (const TableInfo& table : scene_tables()) text += table_text(table);
  for (const TableInfo& table : others) text += table_text(table);
  return text + catalog_text();
}

}  // namespace feder
