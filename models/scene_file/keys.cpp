#include "models/scene_file/keys.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace feder {
namespace {

using Type = Value::Type;

void refuse(const KeyInfo& key, const Value& value, const std::string& where, const std::string& expectation,
            Diagnostics& problems) {
  std::string got = value.shown();
  if (value.type == Type::kText && value.text.empty()) got = "''";
  problems.add(value.place, where + ": " + key.name + " = " + got +
                                (key.unit.empty() || !value.items.empty() ? "" : " " + key.unit) +
                                ", expected " + expectation);
}

bool is_number(const Value& value) {
  return value.type == Type::kInteger || value.type == Type::kNumber;
}

// The word for infinity.
const char* infinite(const KeyInfo& key) {
  return key.unit == "kg" ? "fixed" : "rigid";
}

// inf and nan are no values of a scene.
bool number_of(const KeyInfo& key, const Value& value, const Range& range, double& out) {
  if (value.type == Type::kText && range.rigid && value.text == infinite(key)) {
    out = kRigid;
    return true;
  }
  if (!is_number(value) || !std::isfinite(value.number) || !range.contains(value.number)) return false;
  out = value.number;
  return true;
}

bool vector_of(const Value& value, Vector3d& out) {
  if (value.type != Type::kArray || value.items.size() != 3) return false;
  for (int c = 0; c < 3; ++c) {
    const Value& item = value.items[static_cast<std::size_t>(c)];
    if (!is_number(item) || !std::isfinite(item.number)) return false;
  }
  for (int c = 0; c < 3; ++c) out[c] = value.items[static_cast<std::size_t>(c)].number;
  return true;
}

constexpr const char* kVector = "three finite numbers [x, y, z]";

bool anchor_of(const KeyInfo& key, const Value& value, const std::string& where, AnchorText& out,
               Diagnostics& problems) {
  if (value.type == Type::kText) {
    out.name = {value.text, value.place, true};
    return true;
  }
  if (Vector3d place; vector_of(value, place)) {
    out.place = {place, value.place, true};
    return true;
  }
  if (value.type != Type::kTable) {
    refuse(key, value, where, key.expectation, problems);
    return false;
  }
  static const std::vector<KeyInfo> keys = {{"body", "", "", "the name of a body", "", true},
                                            {"point", "m", "", kVector, "", false},
                                            {"place", "m", "", kVector, "", false}};
  const std::size_t before = problems.count();
  check_keys(value, keys, where + ": " + key.name, value.place, problems);
  const std::string inside = where + ": " + key.name;
  if (const Value* name = value.find("body")) read_value(keys[0], *name, inside, out.name, problems);
  if (const Value* point = value.find("point")) read_value(keys[1], *point, inside, out.point, problems);
  if (const Value* place = value.find("place")) read_value(keys[2], *place, inside, out.place, problems);
  if (out.point.given && out.place.given)
    problems.add(out.place.place,
                 where + ": " + key.name +
                     " has both 'point' (in the body's axes) and 'place' (in the world), expected one");
  return problems.count() == before;
}

}  // namespace

std::string expectation_of(const KeyInfo& key, const Range& range) {
  Range finite = range;
  finite.rigid = false;
  return finite.expectation() + (range.rigid ? std::string(", or \"") + infinite(key) + "\"" : "");
}

void check_keys(const Value& table, const std::vector<KeyInfo>& keys, const std::string& where,
                TextPlace place, Diagnostics& problems) {
  for (const Value::Member& member : table.members) {
    const auto is_it = [&](const KeyInfo& key) { return key.name == member.key; };
    if (std::any_of(keys.begin(), keys.end(), is_it)) continue;
    std::vector<std::string> names;
    if (problems.shows(member.place))
      for (const KeyInfo& key : keys) names.push_back(key.name);
    problems.add(member.place, where + ": no key " + quoted(member.key) + ", did you mean '" +
                                   nearest(member.key, names) + "'? It has: " + join(names));
  }
  for (const KeyInfo& key : keys)
    if (key.required && !table.find(key.name))
      problems.add(place, where + ": '" + key.name + "' is missing, expected " + key.expectation +
                              (key.unit.empty() ? "" : " in " + key.unit));
}

void read_value(const KeyInfo& key, const Value& value, const std::string& where, const Range& range,
                PlacedNumber& out, Diagnostics& problems) {
  if (double number = 0.0; number_of(key, value, range, number))
    out = {number, value.place, true};
  else
    refuse(key, value, where, expectation_of(key, range), problems);
}

void read_value(const KeyInfo& key, const Value& value, const std::string& where, const Range& range,
                double& out, Diagnostics& problems) {
  if (!number_of(key, value, range, out)) refuse(key, value, where, expectation_of(key, range), problems);
}

void read_value(const KeyInfo& key, const Value& value, const std::string& where, const Range& range,
                int& out, Diagnostics& problems) {
  if (value.type == Type::kInteger && range.contains(value.number))
    out = static_cast<int>(value.integer);
  else
    refuse(key, value, where, range.expectation(), problems);
}

void read_value(const KeyInfo& key, const Value& value, const std::string& where, const Range& range,
                std::vector<double>& out, Diagnostics& problems) {
  if (value.type != Type::kArray) return refuse(key, value, where, "an array of numbers", problems);
  std::vector<double> numbers(value.items.size());
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (!number_of(key, value.items[i], range, numbers[i]))
      return refuse(key, value.items[i], where, "in the array " + expectation_of(key, range), problems);
  out = numbers;
}

void read_value(const KeyInfo& key, const Value& value, const std::string& where, bool& out,
                Diagnostics& problems) {
  if (value.type != Type::kBoolean) return refuse(key, value, where, "true or false", problems);
  out = value.boolean;
}

void read_value(const KeyInfo& key, const Value& value, const std::string& where, NameText& out,
                Diagnostics& problems) {
  if (value.type != Type::kText || value.text.empty())
    return refuse(key, value, where, key.expectation, problems);
  out = {value.text, value.place, true};
}

void read_value(const KeyInfo& key, const Value& value, const std::string& where, std::string& out,
                Diagnostics& problems) {
  if (value.type != Type::kText) return refuse(key, value, where, key.expectation, problems);
  out = value.text;
}

// The number that is none, or the whole.
const Value& culprit(const Value& vector) {
  const auto wrong = std::find_if(vector.items.begin(), vector.items.end(), [](const Value& item) {
    return !is_number(item) || !std::isfinite(item.number);
  });
  return vector.items.size() != 3 || wrong == vector.items.end() ? vector : *wrong;
}

void read_value(const KeyInfo& key, const Value& value, const std::string& where, Vector3d& out,
                Diagnostics& problems) {
  if (!vector_of(value, out)) refuse(key, culprit(value), where, kVector, problems);
}

void read_value(const KeyInfo& key, const Value& value, const std::string& where, PlacedVector& out,
                Diagnostics& problems) {
  if (Vector3d vector; vector_of(value, vector))
    out = {vector, value.place, true};
  else
    refuse(key, culprit(value), where, kVector, problems);
}

void read_value(const KeyInfo& key, const Value& value, const std::string& where, AnchorText& out,
                Diagnostics& problems) {
  (void)anchor_of(key, value, where, out, problems);
}

void read_value(const KeyInfo& key, const Value& value, const std::string& where,
                std::vector<AnchorText>& out, Diagnostics& problems) {
  if (value.type != Type::kArray || value.items.empty())
    return refuse(key, value, where, key.expectation, problems);
  std::vector<AnchorText> anchors(value.items.size());
  for (std::size_t i = 0; i < anchors.size(); ++i)
    if (!anchor_of(key, value.items[i], where, anchors[i], problems)) return;
  out = anchors;
}

void read_value(const KeyInfo& key, const Value& value, const std::string& where, FunctionText& out,
                Diagnostics& problems) {
  FunctionText function{.place = value.place};
  if (is_number(value) && std::isfinite(value.number)) {
    function.kind = FunctionText::Kind::kNumber, function.number = value.number;
  } else if (value.type == Type::kText) {
    function.kind = FunctionText::Kind::kExpression, function.expression = value.text;
  } else if (value.type == Type::kArray && value.items.size() >= 2) {
    function.kind = FunctionText::Kind::kTable;
    for (const Value& pair : value.items) {
      double x = 0.0, y = 0.0;
      if (pair.items.size() != 2 || !number_of(key, pair.items[0], kAnyNumber, x) ||
          !number_of(key, pair.items[1], kAnyNumber, y))
        return refuse(key, pair, where, "in the table a pair of finite numbers", problems);
      function.pairs.push_back({x, y});
    }
  } else {
    return refuse(key, value, where, key.expectation, problems);
  }
  out = function;
}

void read_value(const KeyInfo& key, const Value& value, const std::string& where,
                std::array<FunctionText, 3>& out, Diagnostics& problems) {
  if (value.type != Type::kArray || value.items.size() != 3)
    return refuse(key, value, where, key.expectation, problems);
  for (std::size_t c = 0; c < 3; ++c) read_value(key, value.items[c], where, out[c], problems);
}

void read_value(const KeyInfo& key, const Value& value, const std::string& where, Orientation& out,
                Diagnostics& problems) {
  if (value.type == Type::kTable) {
    static const std::vector<KeyInfo> keys = {{"axis", "", "", kVector, "", true},
                                              {"angle", "rad", "", "a finite number", "", true}};
    const std::size_t before = problems.count();
    Vector3d axis = Vector3d::UnitZ();
    double angle = 0.0;
    check_keys(value, keys, where + ": " + key.name, value.place, problems);
    const std::string inside = where + ": " + key.name;
    if (const Value* v = value.find("axis")) read_direction(keys[0], *v, inside, axis, problems);
    if (const Value* v = value.find("angle")) read_value(keys[1], *v, inside, kAnyNumber, angle, problems);
    if (problems.count() > before) return;
    out.axes = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
    return;
  }
  constexpr double kUnit = 1e-6;  // a quaternion written with few digits
  std::vector<double> q;
  const std::size_t before = problems.count();
  read_value(key, value, where, kAnyNumber, q, problems);
  if (problems.count() > before) return;
  const double norm = q.size() == 4 ? Eigen::Map<const Eigen::Vector4d>(q.data()).norm() : 0.0;
  if (!(std::abs(norm - 1.0) <= kUnit))
    return refuse(key, value, where, "a unit quaternion [w, x, y, z], or {axis, angle}", problems);
  out.axes = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
}

void read_direction(const KeyInfo& key, const Value& value, const std::string& where, PlacedVector& out,
                    Diagnostics& problems) {
  const std::size_t before = problems.count();
  PlacedVector vector;
  read_value(key, value, where, vector, problems);
  if (problems.count() > before) return;
  const double length = vector.value.stableNorm();
  if (!(length > 0.0) || !std::isfinite(length))
    return problems.add(value.place,
                        where + ": " + key.name + " of length " + to_text(length) + ", expected a direction");
  out = {vector.value.stableNormalized(), value.place, true};
}

void read_direction(const KeyInfo& key, const Value& value, const std::string& where, Vector3d& out,
                    Diagnostics& problems) {
  PlacedVector direction{out, {}, false};
  read_direction(key, value, where, direction, problems);
  out = direction.value;
}

void read_choice(const KeyInfo& key, const Value& value, const std::string& where,
                 const std::vector<std::string>& choices, int& out, Diagnostics& problems) {
  const auto found = std::find(choices.begin(), choices.end(), value.text);
  if (value.type == Type::kText && found != choices.end())
    out = static_cast<int>(found - choices.begin());
  else
    refuse(key, value, where,
           "one of " + join(choices) +
               (value.type == Type::kText ? "; did you mean '" + nearest(value.text, choices) + "'?" : ""),
           problems);
}

void read_words(const KeyInfo& key, const Value& value, const std::string& where,
                const std::vector<std::string>& choices, std::vector<std::string>& out,
                Diagnostics& problems) {
  if (value.type != Type::kArray) return refuse(key, value, where, key.expectation, problems);
  std::vector<std::string> words;
  const std::size_t before = problems.count();
  for (const Value& item : value.items) {
    int index = 0;
    read_choice(key, item, where, choices, index, problems);
    words.push_back(choices[static_cast<std::size_t>(index)]);
  }
  if (problems.count() == before) out = words;
}

void read_mask(const KeyInfo& key, const Value& value, const std::string& where, FreeMask& out,
               Diagnostics& problems) {
  FreeMask mask = 0;
  bool sound = value.type == Type::kText;
  for (char c : value.text) {
    if (c < 'x' || c > 'z') {
      sound = false;
      break;
    }
    const auto bit = static_cast<FreeMask>(1 << (c - 'x'));
    sound = sound && !(mask & bit);
    mask = static_cast<FreeMask>(mask | bit);
  }
  if (sound)
    out = mask;
  else
    refuse(key, value, where, key.expectation, problems);
}

}  // namespace feder
