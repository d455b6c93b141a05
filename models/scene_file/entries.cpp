#include "models/scene_file/entries.h"

#include <algorithm>

namespace feder {
namespace {

constexpr const char* kName = "a text that is not empty";
constexpr const char* kAnchors =
    "two anchors: a name, {body, point} in its axes, {body, place} in the world, or a place [x, y, z]";
constexpr const char* kBodies = "the names of two bodies, or of one and \"world\"";
constexpr const char* kRotation = "a unit quaternion [w, x, y, z], or {axis = [x, y, z], angle = radians}";
const Range kStiffness{0.0, kRigid, false, true};
constexpr const char* kTriple = "three numbers [x, y, z]";
constexpr const char* kScalar = "a number, an expression in t, or a table [[t, value], ...]";

template <class E>
void append(Keys<E>& list, const Keys<E>& more) {
  list.insert(list.end(), more.begin(), more.end());
}

template <class E>
Key<E> name_key() {
  return key<E>("name", &E::name, kRequired, "", "how other entries and the results call it", kName);
}
template <class E>
Key<E> row_name_key() {
  return key<E>("name", &E::name, "", "", "how the results and --set call it", kName);
}
template <class E>
Key<E> group_key() {
  return key<E>("group", &E::group, "", "", "a name that several entries share, for [[force]]", kName);
}

// A list of numbers, with how many they are.
template <class E>
Key<E> list_key(Key<E> key, const char* expectation) {
  key.info.expectation = expectation;
  return key;
}

// The row's own stiffness and damping, or those of a material; without damping beside that of the stiffness.
template <class E>
Keys<E> elastic_keys(const char* unit, const char* default_stiffness) {
  return {key<E>("material", &E::material, "", "", "takes from a [[material]] what is not given here",
                 "the name of a material"),
          key<E>("stiffness", &E::stiffness, default_stiffness, unit,
                 "of each row; \"rigid\" holds it exactly", kStiffness),
          key<E>("damping_time", &E::damping_time, "0", "s", "the damping is stiffness times this time",
                 kNonNegative)};
}

template <class E>
Keys<E> material_keys(const char* unit, const char* damping_unit, const char* default_stiffness) {
  Keys<E> keys = elastic_keys<E>(unit, default_stiffness);
  append(keys, {key<E>("damping", &E::damping, "0", damping_unit,
                       "more damping, whatever the stiffness; none on rigid rows", kNonNegative)});
  return keys;
}

const Keys<Document>& top_keys() {
  using E = Document;
  static const Keys<Document> list = {
      key<E>("title", &Document::title, "", "", "one line about the scene", "a text"),
      key<E>(
          "model", &Document::model, "", "",
          "a scene of the catalogue (below); then beside it only title, the times, scene_length, [method], "
          "[output]",
          "\"name\" or \"name:parameter=value,...\""),
      key<E>("end_time", &Document::end_time, "the model's; required without one", "s", "how long to run",
             kPositive),
      key<E>("quick_end_time", &Document::quick_end_time, "end_time", "s",
             "how long to run with --preset quick", kPositive),
      key<E>("scene_length", &Document::scene_length, "diagonal of all places at the start", "m",
             "what errors are compared with; required where that diagonal is 0, as with one body alone",
             kPositive),
      key<E>("gravity", &Document::gravity, "[0, 0, 0]", "m/s^2", "acts on all masses; none unless given",
             kTriple),
      key<E>("drag", &Document::drag, "0", "kg/s", "force -drag v on every particle; bodies feel none",
             kNonNegative),
  };
  return list;
}

const Keys<MaterialEntry>& keys_of(const MaterialEntry*) {
  using E = MaterialEntry;
  static const Keys<E> list = {
      name_key<E>(),
      key<E>("stiffness", &E::stiffness, kRequired, "N/m or N m", "\"rigid\" holds the row exactly",
             kStiffness),
      key<E>("damping_time", &E::damping_time, "0", "s", "the damping is stiffness times this time",
             kNonNegative),
      key<E>("damping", &E::damping, "0", "kg/s or kg m^2/s",
             "more damping, whatever the stiffness; none on rigid rows", kNonNegative)};
  return list;
}

const Keys<PointEntry>& keys_of(const PointEntry*) {
  using E = PointEntry;
  static const Keys<E> list = {
      name_key<E>(), group_key<E>(),
      key<E>("position", &E::position, "or motion", "m", "where it stays", kTriple),
      key<E>("motion", &E::motion, "or position", "m", "how it moves: x, y, z as functions of t",
             "three components, each a number, an expression in t, or a table [[t, value], ...]")};
  return list;
}

const Keys<ParticleEntry>& keys_of(const ParticleEntry*) {
  using E = ParticleEntry;
  static const Keys<E> list = {
      name_key<E>(),
      group_key<E>(),
      key<E>("mass", &E::mass, kRequired, "kg", "\"fixed\" is a particle that never moves", kPositiveOrRigid),
      key<E>("position", &E::position, kRequired, "m", "at the start", kTriple),
      key<E>("velocity", &E::velocity, "[0, 0, 0]", "m/s", "at the start", kTriple),
      mask_key("free", &E::free, "the coordinates that may move")};
  return list;
}

const std::vector<std::string> kShapes = {"box", "sphere", "hollow_sphere", "cylinder",
                                          "rod", "mesh",   "given",         "parts"};

template <class E>
Keys<E> shape_keys() {
  Key<E> shape{{"shape", "",
                "what its mass is spread over, centred at the origin of its axes; cylinder and rod lie along "
                "z; a rod, "
                "without inertia about itself, can only be a part",
                "one of " + join(kShapes), "", true},
               {}};
  shape.read = [info = shape.info](E& e, const Value& v, const std::string& where, Diagnostics& problems) {
    e.shape.place = v.place;
    const std::size_t before = problems.count();
    read_choice(info, v, where, kShapes, e.shape.value, problems);
    e.shape.given = problems.count() == before;
  };
  Key<E> inertia{
      {"inertia", "kg m^2",
       "about the centre of mass, in its axes: Ixx, Iyy, Izz, and Ixy, Ixz, Iyz unless these are 0",
       "three or six numbers", "for given", false},
      {}};
  inertia.read = [info = inertia.info](E& e, const Value& v, const std::string& where,
                                       Diagnostics& problems) {
    const std::size_t before = problems.count();
    read_value(info, v, where, kAnyNumber, e.inertia.value, problems);
    const std::size_t size = e.inertia.value.size();
    if (problems.count() == before && size != 3 && size != 6)
      problems.add(v.place, where + ": inertia = an array of " + std::to_string(size) + ", expected " +
                                info.expectation);
    e.inertia.place = v.place, e.inertia.given = problems.count() == before;
  };
  return {shape,
          key<E>("mass", &E::mass, "or density", "kg",
                 "not of shape \"parts\"; \"fixed\" pins a body, not a part", kPositiveOrRigid),
          key<E>("density", &E::density, "or mass", "kg/m^3", "of box, sphere, cylinder and mesh", kPositive),
          key<E>("edges", &E::edges, "for box", "m", "along its axes", kTriple),
          key<E>("radius", &E::radius, "for spheres, cylinder", "m", "around the centre, or z", kPositive),
          key<E>("height", &E::height, "for cylinder", "m", "along z", kPositive),
          key<E>("length", &E::length, "for rod", "m", "along z", kPositive),
          key<E>("mesh", &E::mesh, "for mesh", "",
                 "an .obj or .stl file: closed, its faces counter-clockwise seen from outside",
                 "a path inside the scene's folder"),
          key<E>("scale", &E::scale, "1", "", "metres per unit of the mesh file", kPositive),
          inertia,
          key<E>("centre", &E::centre, "[0, 0, 0]", "m", "of shape \"given\": its centre of mass in its axes",
                 kTriple)};
}

const Keys<PartEntry>& keys_of(const PartEntry*) {
  using E = PartEntry;
  static const Keys<E> list = [] {
    Keys<E> keys = shape_keys<E>();
    keys.front().info.expectation = "one of " + join({kShapes.begin(), kShapes.end() - 1});  // no parts
    append(keys, {key<E>("position", &E::position, "[0, 0, 0]", "m",
                         "of the part's origin in the body's axes", kTriple),
                  key<E>("orientation", &E::orientation, "[1, 0, 0, 0]", "", "of the part in the body's axes",
                         kRotation)});
    return keys;
  }();
  return list;
}

template <class E>
void read_list(const Value& value, const char* table, std::vector<E>& out, Diagnostics& problems);

const Keys<BodyEntry>& keys_of(const BodyEntry*) {
  using E = BodyEntry;
  static const Keys<E> list = [] {
    Keys<E> keys = {name_key<E>(), group_key<E>()};
    append(keys, shape_keys<E>());
    Key<E> parts{
        {"parts", "", "tables with the keys of [[body.parts]]; they may also follow the body as such",
         "an array of tables", "for parts", false},
        {}};
    parts.read = [](E& e, const Value& v, const std::string&, Diagnostics& problems) {
      read_list(v, "part", e.parts, problems);
    };
    append(keys,
           {parts,
            key<E>("position", &E::position, "[0, 0, 0]", "m", "of the origin of its axes at the start",
                   kTriple),
            key<E>("orientation", &E::orientation, "[1, 0, 0, 0]", "", "of its axes at the start", kRotation),
            key<E>("velocity", &E::velocity, "[0, 0, 0]", "m/s", "of its centre of mass", kTriple),
            key<E>("angular_velocity", &E::angular_velocity, "[0, 0, 0]", "rad/s", "in world axes", kTriple),
            mask_key("free", &E::free, "directions of the world its centre of mass may move in"),
            mask_key("free_spin", &E::free_spin,
                     "axes it may turn about: its own where they are principal, else principal ones, moments "
                     "ascending")});
    return keys;
  }();
  return list;
}

template <class E>
Keys<E> between_keys(const char* expectation) {
  return {row_name_key<E>(),
          key<E>("between", &E::between, kRequired, "", "what it holds on to", expectation)};
}

const Keys<SpringEntry>& keys_of(const SpringEntry*) {
  using E = SpringEntry;
  static const Keys<E> list = [] {
    Keys<E> keys = between_keys<E>(kAnchors);
    append(keys, material_keys<E>("N/m", "kg/s", "required, or a material"));
    append(keys, {key<E>("length", &E::length, "as placed", "m", "at rest", kNonNegative)});
    return keys;
  }();
  return list;
}

const Keys<LawSpringEntry>& keys_of(const LawSpringEntry*) {
  using E = LawSpringEntry;
  static const Keys<E> list = [] {
    Keys<E> keys = between_keys<E>(kAnchors);
    append(keys, {key<E>("tension", &E::tension, kRequired, "N", "pulls the ends together where positive",
                         "an expression in length [m] and rate [m/s], or a table [[length, tension], ...]")});
    return keys;
  }();
  return list;
}

const Keys<BendingEntry>& keys_of(const BendingEntry*) {
  using E = BendingEntry;
  static const Keys<E> list = [] {
    Keys<E> keys = {row_name_key<E>(),
                    key<E>("over", &E::over, kRequired, "", "particles or points in order", "three names")};
    append(keys, elastic_keys<E>("N m", "required, or a material"));
    append(
        keys,
        {key<E>(
            "rest_angle", &E::rest_angle, "", "rad",
            "by which the second edge is turned from the first at rest; left out: straight at rest, and then "
            "not rigid",
            Range{0.0, 3.141592653589793, true})});
    return keys;
  }();
  return list;
}

const std::vector<std::string> kJoints = {"ball", "universal", "hinge", "cylindrical", "prismatic", "weld"};

const Keys<JointEntry>& keys_of(const JointEntry*) {
  using E = JointEntry;
  static const Keys<E> list = [] {
    Keys<E> keys = {
        choice_key("type", &E::type, kRequired,
                   "leaves 3 turns (ball), 2 turns (universal), 1 turn (hinge), a turn and a slide "
                   "(cylindrical), 1 slide (prismatic), nothing (weld)",
                   kJoints)};
    append(keys, between_keys<E>(kBodies));
    append(keys, {key<E>("place", &E::place_at, kRequired, "m", "in the world at the start", kTriple),
                  direction_key("axis", &E::axis, "", "in the world at the start; not for ball and weld"),
                  direction_key("axis_b", &E::axis_b, "",
                                "second axis of a universal joint, perpendicular to the first")});
    append(keys, material_keys<E>("N/m", "kg/s", "rigid"));
    append(keys,
           {key<E>("angular_stiffness", &E::angular_stiffness, "rigid", "N m",
                   "of the rows that hold directions", kStiffness),
            key<E>("angular_damping_time", &E::angular_damping_time, "0", "s", "of these rows", kNonNegative),
            key<E>("angular_damping", &E::angular_damping, "0", "kg m^2/s", "of these rows", kNonNegative)});
    return keys;
  }();
  return list;
}

const Keys<TurnEntry>& keys_of(const TurnEntry*) {
  using E = TurnEntry;
  static const Keys<E> list = [] {
    Keys<E> keys = between_keys<E>(kBodies);
    append(keys,
           {direction_key("axis", &E::axis, kRequired,
                          "of the turn, fixed in the first, in the world at the start"),
            key<E>("target", &E::target, "0", "rad",
                   "angle it is at rest at, counted from the start over turns; of t: a motor", kScalar)});
    append(keys, material_keys<E>("N m", "kg m^2/s", "required, or a material"));
    return keys;
  }();
  return list;
}

const Keys<SlideEntry>& keys_of(const SlideEntry*) {
  using E = SlideEntry;
  static const Keys<E> list = [] {
    Keys<E> keys = between_keys<E>(kBodies);
    append(keys, {key<E>("place", &E::place_at, kRequired, "m", "in the world at the start", kTriple),
                  direction_key("axis", &E::axis, kRequired, "fixed in the first, in the world at the start"),
                  key<E>("target", &E::target, "0", "m",
                         "way it is at rest at, from the start; of t: a linear motor", kScalar)});
    append(keys, material_keys<E>("N/m", "kg/s", "required, or a material"));
    return keys;
  }();
  return list;
}

const Keys<PerpendicularEntry>& keys_of(const PerpendicularEntry*) {
  using E = PerpendicularEntry;
  static const Keys<E> list = [] {
    Keys<E> keys = between_keys<E>(kBodies);
    append(keys, {direction_key("direction_a", &E::direction_a, kRequired,
                                "fixed in the first, in the world at the start"),
                  direction_key("direction_b", &E::direction_b, kRequired,
                                "fixed in the second, in the world at the start")});
    append(keys, material_keys<E>("N m", "kg m^2/s", "rigid"));
    return keys;
  }();
  return list;
}

const Keys<ForceEntry>& keys_of(const ForceEntry*) {
  using E = ForceEntry;
  static const Keys<E> list = {
      key<E>("on", &E::on, kRequired, "", "on each member of a group the whole force",
             "a particle, a body (its centre of mass), or a group"),
      key<E>("force", &E::force, kRequired, "N",
             "in world axes; x ... vz are place and velocity of what it acts on",
             "three components, each a number or an expression in t, x, y, z, vx, vy, vz")};
  return list;
}

const Keys<TorqueEntry>& keys_of(const TorqueEntry*) {
  using E = TorqueEntry;
  static const Keys<E> list = {
      key<E>("on", &E::on, kRequired, "", "the body it acts on", "the name of a body"),
      key<E>("torque", &E::torque, kRequired, "N m", "constant in world axes", kTriple)};
  return list;
}

const Keys<ChainEntry>& keys_of(const ChainEntry*) {
  using E = ChainEntry;
  static const Keys<E> list = [] {
    Keys<E> keys = {
        name_key<E>(), key<E>("from", &E::from, kRequired, "m", "place of the first particle", kTriple),
        key<E>("to", &E::to, kRequired, "m", "place of the last", kTriple),
        key<E>("count", &E::count, kRequired, "", "particles name[0], name[1], ...", count_from(2)),
        key<E>("mass", &E::mass, kRequired, "kg", "of the whole chain, in equal parts", kPositive)};
    append(keys, material_keys<E>("N/m", "kg/s", "required, or a material"));
    append(keys,
           {key<E>("bending_stiffness", &E::bending_stiffness, "0", "N m",
                   "at each inner particle, straight at rest: EI / length of a link; damped by damping_time",
                   kNonNegative),
            words_key("fixed", &E::fixed, "[]", "ends that never move", {"first", "last"})});
    return keys;
  }();
  return list;
}

const Keys<ClothEntry>& keys_of(const ClothEntry*) {
  using E = ClothEntry;
  static const Keys<E> list = [] {
    Keys<E> keys = {
        name_key<E>(),
        key<E>("corner", &E::corner, "[0, 0, 0]", "m", "place of particle name[0,0]", kTriple),
        key<E>("edge_u", &E::edge_u, kRequired, "m", "from there to name[count_u - 1,0]", kTriple),
        key<E>("edge_v", &E::edge_v, kRequired, "m", "from there to name[0,count_v - 1]", kTriple),
        list_key(key<E>("count", &E::count, kRequired, "", "particles along u and v",
                        Range{2.0, kMaxNodes, false, false, true}),
                 "two integers >= 2"),
        key<E>("mass", &E::mass, kRequired, "kg", "of the whole cloth, in equal parts", kPositive)};
    append(keys, material_keys<E>("N/m", "kg/s", "required, or a material"));
    append(keys, {key<E>("shear_stiffness", &E::shear_stiffness, "as stiffness", "N/m", "of both diagonals",
                         kNonNegative),
                  key<E>("bend_stiffness", &E::bend_stiffness, "0", "N/m", "of springs to second neighbours",
                         kNonNegative),
                  words_key("fixed", &E::fixed, "[]",
                            "corners (c00 is name[0,0], c10 the one along u) and sides (u0 has the corners "
                            "c00 and c01) that "
                            "never move",
                            {"c00", "c10", "c01", "c11", "u0", "u1", "v0", "v1"})});
    return keys;
  }();
  return list;
}

const Keys<LatticeEntry>& keys_of(const LatticeEntry*) {
  using E = LatticeEntry;
  static const Keys<E> list = [] {
    Keys<E> keys = {
        name_key<E>(),
        key<E>("corner", &E::corner, "[0, 0, 0]", "m", "place of particle name[0,0,0]", kTriple),
        key<E>("size", &E::size, kRequired, "m", "of the block along x, y, z", kTriple),
        list_key(key<E>("count", &E::count, kRequired, "", "particles along x, y, z",
                        Range{2.0, kMaxNodes, false, false, true}),
                 "three integers >= 2"),
        key<E>("mass", &E::mass, kRequired, "kg", "of the whole block, in equal parts", kPositive)};
    append(keys, material_keys<E>("N/m", "kg/s", "required, or a material"));
    append(keys, {words_key("fixed", &E::fixed, "[]", "faces that never move",
                            {"x0", "x1", "y0", "y1", "z0", "z1"})});
    return keys;
  }();
  return list;
}

const Keys<NetEntry>& keys_of(const NetEntry*) {
  using E = NetEntry;
  static const Keys<E> list = [] {
    Keys<E> keys = {name_key<E>(),
                    key<E>("corner", &E::corner, "[0, 0, 0]", "m",
                           "corner of plate name[0,0], which spans x and z", kTriple),
                    list_key(key<E>("count", &E::count, kRequired, "", "plates along x and z",
                                    Range{1.0, kMaxNodes, false, false, true}),
                             "two integers >= 1"),
                    key<E>("edge", &E::edge, kRequired, "m", "of each square plate", kPositive),
                    key<E>("thickness", &E::thickness, kRequired, "m", "of each plate", kPositive),
                    key<E>("mass", &E::mass, kRequired, "kg", "of each plate", kPositive)};
    append(keys, material_keys<E>("N/m", "kg/s", "rigid"));
    append(keys, {words_key("fixed", &E::fixed, "[]", "sides joined to the world, by the same joints",
                            {"x0", "x1", "z0", "z1"})});
    return keys;
  }();
  return list;
}

template <class E>
void read_list(const Value& value, const char* table, std::vector<E>& out, Diagnostics& problems) {
  const std::string key = std::is_same_v<E, PartEntry> ? "parts" : table,
                    header = std::is_same_v<E, PartEntry> ? "body.parts" : table;
  if (value.type != Value::Type::kArray ||
      std::any_of(value.items.begin(), value.items.end(),
                  [](const Value& v) { return v.type != Value::Type::kTable; })) {
    problems.add(value.place, key + " = " + value.shown() + ", expected tables [[" + header + "]]");
    return;
  }
  static const std::vector<KeyInfo> known = infos(keys_of(static_cast<const E*>(nullptr)));
  out.resize(value.items.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    const Value& item = value.items[i];
    const Value* name = item.find("name");
    out[i].place = item.place;
    out[i].label = std::string(table) + " " +
                   (name && name->type == Value::Type::kText ? quoted(name->text) : std::to_string(i));
    const std::size_t before = problems.count();
    read_entry(item, keys_of(static_cast<const E*>(nullptr)), known, out[i].label, out[i], problems);
    out[i].broken = problems.count() > before;
  }
}

// THE LIST of tables.
template <class Visit>
void for_each_table(Visit&& visit) {
  using D = Document;
  visit("material", &D::materials,
        "Stiffness and damping under a name. What an entry gives itself goes before its material.");
  visit("point", &D::points, "A place of the world with a name, at rest or in prescribed motion.");
  visit("particle", &D::particles, "A point mass.");
  visit("body", &D::bodies, "A rigid body. Give its shape, what the shape needs, and a mass or a density.");
  visit("spring", &D::springs,
        "A spring, or a rod where its stiffness is \"rigid\"; with stiffness 0 and a damping, a damper.");
  visit("law_spring", &D::law_springs, "A spring with a law of its own, tension as a function of length.");
  visit("bending", &D::bendings, "Resists bending at the middle one of three particles or points.");
  visit("joint", &D::joints, "A joint between two bodies, or a body and the \"world\".");
  visit("turn", &D::turns,
        "Acts on the angle between two bodies about an axis: torsion spring, damper, motor. It holds nothing "
        "else: a hinge about the same axis stands beside it.");
  visit("slide", &D::slides,
        "Acts on the way along an axis: spring, damper, linear motor. It holds nothing else: a prismatic or "
        "cylindrical joint about the same axis stands beside it.");
  visit("perpendicular", &D::perpendiculars,
        "Keeps two directions perpendicular: one freedom less, for joints of one's own.");
  visit("force", &D::forces, "An external force. Weight needs none, that is gravity at the top level.");
  visit("torque", &D::torques, "An external torque.");
  visit("chain", &D::chains, "A line of particles on springs. Its particles form the group of its name.");
  visit("cloth", &D::cloths,
        "A sheet of particles on structural, shear and bend springs. Its particles form the group of its "
        "name.");
  visit("lattice", &D::lattices,
        "A block of particles, each tied to its 26 neighbours. Its particles form the group of its name.");
  visit("net", &D::nets,
        "Square plates side by side, joined by ball joints in the middle of shared edges. Its plates are "
        "bodies name[0,0], ... and form the group of its name.");
}

}  // namespace

std::vector<TableInfo> scene_tables() {
  std::vector<TableInfo> tables = {{"", "Top level, before the first table.", false, infos(top_keys())}};
  for_each_table([&](const char* name, auto member, const char* what) {
    using E = typename std::decay_t<decltype(std::declval<Document>().*member)>::value_type;
    tables.push_back({name, what, true, infos(keys_of(static_cast<const E*>(nullptr)))});
    if (tables.back().name == "body")
      tables.push_back({"body.parts", "A part of a body of shape \"parts\".", true,
                        infos(keys_of(static_cast<const PartEntry*>(nullptr)))});
  });
  return tables;
}

Document read_document(const Value& root, const std::vector<std::string>& others, Diagnostics& problems) {
  Document document;
  document.label = "scene";
  std::vector<KeyInfo> known = infos(top_keys());
  for_each_table([&](const char* name, auto, const char*) {
    known.push_back({name, "", "", "", "", false});
  });
  for (const std::string& name : others) known.push_back({name, "", "", "", "", false});
  check_keys(root, known, "scene", root.place, problems);
  for (const Key<Document>& key : top_keys())
    if (const Value* value = root.find(key.info.name)) key.read(document, *value, "scene", problems);
  for_each_table([&](const char* name, auto member, const char*) {
    if (const Value* value = root.find(name)) read_list(*value, name, document.*member, problems);
  });
  return document;
}

}  // namespace feder
