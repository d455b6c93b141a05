#include <cmath>

#include "models/scene_file/assembly.h"
#include "models/scene_file/functions.h"

namespace feder {
namespace {

// "perpendicular 1", "perpendicular 2", ... after what comes first.
std::vector<std::string> numbered(std::vector<std::string> types, const std::string& word, int count) {
  for (int i = 1; i <= count; ++i) types.push_back(count == 1 ? word : word + " " + std::to_string(i));
  return types;
}

// What a viewer connects of a joint at a place: its point on both bodies, on one of them twice beside the
// world.
std::vector<Anchor> ends_at(SystemBuilder& builder, const Anchor& a, const Anchor& b, const Vector3d& place) {
  const Anchor end = builder.anchor_at(a.body >= 0 ? a : b, place);
  return {end, b.body >= 0 ? builder.anchor_at(b, place) : end};
}

// Calls add with the number a row rests at or the function it follows; not at all where the text is wrong.
template <class Add>
void with_target(const FunctionText& text, const std::string& where, Diagnostics& problems, Add&& add) {
  using Kind = FunctionText::Kind;
  if (text.kind == Kind::kNone || text.kind == Kind::kNumber)
    add(text.number);
  else if (const auto target = target_of(text, where, problems))
    add(*target);
}

}  // namespace

// Of the row's keys and its material's; what both leave out is `default_stiffness` (negative: required).
bool Assembly::material_of(const Entry& entry, const MaterialKeys& keys, double default_stiffness,
                           Material& out) {
  const MaterialEntry* material = nullptr;
  if (keys.material.given) {
    const auto found = materials_.find(keys.material.value);
    if (found == materials_.end()) {
      std::vector<std::string> known;
      for (const auto& [name, unused] : materials_) known.push_back(name);
      tell(entry, keys.material.place,
           "material = " + quoted(keys.material.value) + " is no [[material]]" +
               (known.empty() ? "" : "; did you mean '" + nearest(keys.material.value, known) + "'?"));
      return false;
    }
    material = found->second;
  }
  if (entry.broken) return false;
  if (!keys.stiffness.given && !material && default_stiffness < 0.0) {
    tell(entry, entry.place, "'stiffness' is missing, expected it or a material");
    return false;
  }
  out.stiffness = keys.stiffness.given ? keys.stiffness.value
                  : material           ? material->stiffness
                                       : default_stiffness;
  out.damping_time = keys.damping_time.given ? keys.damping_time.value
                     : material              ? material->damping_time
                                             : 0.0;
  out.damping = keys.damping.given ? keys.damping.value : material ? material->damping : 0.0;
  return true;
}

bool Assembly::anchor_of(const Entry& entry, const AnchorText& text, Anchor& out) {
  if (!text.name.given) return attempt(entry, [&] { out = add_point(text.place.value); });
  const bool in_body = text.point.given || text.place.given;
  const Named* named =
      look_up(entry, text.name,
              in_body ? std::vector{Kind::kBody} : std::vector{Kind::kParticle, Kind::kPoint, Kind::kBody},
              in_body ? "a body" : "a particle, point or body");
  if (!named) return false;
  out = named->anchor;
  if (text.point.given) out.point = text.point.value;
  return !text.place.given ||
         attempt(entry, [&] { out = builder_.anchor_at(named->anchor, text.place.value); });
}

bool Assembly::ends_of(const Entry& entry, const std::vector<AnchorText>& between, Anchor& a, Anchor& b) {
  if (between.empty()) return false;  // told by its reader
  if (between.size() != 2) {
    tell(entry, entry.place, "between " + std::to_string(between.size()) + " anchors, expected 2");
    return false;
  }
  const bool first = anchor_of(entry, between[0], a);
  return anchor_of(entry, between[1], b) && first && different(entry, between[1], a, b);
}

bool Assembly::different(const Entry& entry, const AnchorText& second, const Anchor& a, const Anchor& b) {
  if (a.body >= 0 ? a.body != b.body : b.body >= 0 || a.node != b.node) return true;
  tell(entry, second.name.place, "between " + quoted(second.name.value) + " and itself, expected two");
  return false;
}

bool Assembly::bodies_of(const Entry& entry, const std::vector<AnchorText>& between, Anchor& a, Anchor& b) {
  if (between.empty()) return false;
  if (between.size() != 2) {
    tell(entry, entry.place, "between " + std::to_string(between.size()) + " bodies, expected 2");
    return false;
  }
  bool sound = true;
  Anchor* const ends[] = {&a, &b};
  for (std::size_t i = 0; i < 2; ++i) {
    const AnchorText& text = between[i];
    *ends[i] = {};
    if (text.name.given && text.name.value == "world" && !text.point.given && !text.place.given) continue;
    if (!text.name.given || text.point.given || text.place.given) {
      const TextPlace place = text.name.given ? text.name.place : text.place.place;
      tell(entry, place, "between = a place, expected the names of two bodies, or a body and \"world\"");
      sound = false;
    } else if (const Named* named = look_up(entry, text.name, {Kind::kBody}, "a body or \"world\"")) {
      *ends[i] = named->anchor;
    } else {
      sound = false;
    }
  }
  if (sound && a.body < 0 && b.body < 0) {
    tell(entry, between[1].name.place, "between the world and the world, expected at least one body");
    sound = false;
  }
  return sound && different(entry, between[1], a, b);
}

void Assembly::add_springs() {
  for (const SpringEntry& entry : document_.springs) {
    Material m;
    Anchor a, b;
    const bool sound = material_of(entry, entry, -1.0, m);
    if (!ends_of(entry, entry.between, a, b) || !sound) continue;
    const double placed = (place_of(b) - place_of(a)).norm(),
                 rest = entry.length.given ? entry.length.value : placed;
    attempt(entry, [&] {
      const int id =
          a.body < 0 && b.body < 0
              ? builder_.add_distance(a, b, m, rest)
              : builder_.add(AnchorDistanceRow{{a, b, m.stiffness, m.damping_time, m.damping}, rest});
      record(entry, entry.name, {id}, {"distance"}, {a, b});
    });
  }
}

void Assembly::add_law_springs() {
  for (const LawSpringEntry& entry : document_.law_springs) {
    Anchor a, b;
    if (!ends_of(entry, entry.between, a, b) || entry.tension.kind == FunctionText::Kind::kNone) continue;
    const double placed = (place_of(b) - place_of(a)).norm();
    attempt(entry, [&] {
      const auto law = law_of(entry.tension, placed, entry.label + ": tension", problems_);
      if (!law) return;
      builder_.add_law_spring({{a, b}, law->law, law->energy});
      law_springs_.push_back(&entry);
      (void)claim_row(entry, entry.name, "law spring");
    });
  }
}

void Assembly::add_bendings() {
  for (const BendingEntry& entry : document_.bendings) {
    Material m;
    const bool sound = material_of(entry, entry, -1.0, m);
    if (sound && m.damping > 0.0) {
      tell(entry, entry.material.place,
           "material = " + quoted(entry.material.value) +
               " has a damping of its own, expected none: bending has " + "damping_time alone");
      continue;
    }
    if (entry.over.empty()) continue;
    if (entry.over.size() != 3) {
      tell(entry, entry.place, "over " + std::to_string(entry.over.size()) + " names, expected 3");
      continue;
    }
    std::array<int, 3> nodes{};
    std::vector<Anchor> anchors(3);
    bool known = true;
    for (std::size_t i = 0; i < 3; ++i) {
      known = anchor_of(entry, entry.over[i], anchors[i]) && known;
      nodes[i] = anchors[i].node;
      if (known && anchors[i].body >= 0) {
        tell(entry, entry.over[i].name.place,
             quoted(entry.over[i].name.value) + " is a body, expected a particle or point");
        known = false;
      }
    }
    if (!known || !sound) continue;
    attempt(entry, [&] {
      const int id = entry.rest_angle.given
                         ? builder_.add(AngleRow{nodes, m.stiffness, m.damping_time, entry.rest_angle.value})
                         : builder_.add(CurvatureRow{nodes, m.stiffness, m.damping_time});
      record(entry, entry.name, {id}, {entry.rest_angle.given ? "angle" : "curvature"}, anchors);
    });
  }
}

void Assembly::add_joints() {
  using E = JointEntry;
  for (const E& entry : document_.joints) {
    Material linear, angular;
    Anchor a, b;
    const MaterialKeys turned{{}, entry.angular_stiffness, entry.angular_damping_time, entry.angular_damping};
    const bool sound =
        material_of(entry, entry, kRigid, linear) && material_of(entry, turned, kRigid, angular);
    if (!bodies_of(entry, entry.between, a, b) || !sound) continue;
    const bool axis_wanted = entry.type != E::kBall && entry.type != E::kWeld;
    if (axis_wanted != entry.axis.given) {
      tell(entry, axis_wanted ? entry.place : entry.axis.place,
           axis_wanted ? "'axis' is missing for this type" : "'axis' has no meaning for this type");
      continue;
    }
    if ((entry.type == E::kUniversal) != entry.axis_b.given) {
      tell(
          entry, entry.place,
          entry.axis_b.given ? "'axis_b' has no meaning for this type" : "'axis_b' is missing for this type");
      continue;
    }
    if (entry.axis_b.given && std::abs(entry.axis.value.dot(entry.axis_b.value)) > 1e-6) {
      tell(entry, entry.axis_b.place,
           "axis . axis_b = " + to_text(entry.axis.value.dot(entry.axis_b.value)) +
               " of directions, expected 0: perpendicular ones");
      continue;
    }
    const JointMaterial material{linear, angular};
    const Vector3d &at = entry.place_at, &n = entry.axis.value;
    attempt(entry, [&] {
      std::vector<int> ids;
      std::vector<std::string> types;
      switch (entry.type) {
        case E::kBall:
          ids = add_ball(builder_, a, b, at, material), types = {"ball"};
          break;
        case E::kUniversal:
          ids = add_universal(builder_, a, b, at, n, entry.axis_b.value, material);
          types = numbered({"ball"}, "perpendicular", 1);
          break;
        case E::kHinge:
          ids = add_hinge(builder_, a, b, at, n, material), types = numbered({"ball"}, "perpendicular", 2);
          break;
        case E::kCylindrical:
          ids = add_cylindrical(builder_, a, b, at, n, material);
          types = numbered(numbered({}, "along", 2), "perpendicular", 2);
          break;
        case E::kPrismatic:
          ids = add_prismatic(builder_, a, b, at, n, material);
          types = numbered(numbered({}, "along", 2), "perpendicular", 3);
          break;
        default:
          ids = add_weld(builder_, a, b, at, material), types = numbered({"ball"}, "perpendicular", 3);
      }
      record(entry, entry.name, ids, types, ends_at(builder_, a, b, at));
    });
  }
}

void Assembly::add_turns() {
  for (const TurnEntry& entry : document_.turns) {
    Material m;
    Anchor a, b;
    const bool sound = material_of(entry, entry, -1.0, m);
    if (!bodies_of(entry, entry.between, a, b) || !sound) continue;
    attempt(entry, [&] {
      with_target(entry.target, entry.label + ": target", problems_, [&](const auto& target) {
        const int id = add_turn(builder_, a, b, entry.axis, m, target);
        const Anchor& held = a.body >= 0 ? a : b;
        record(entry, entry.name, {id}, {"turn"}, {held, b.body >= 0 ? b : held});
      });
    });
  }
}

void Assembly::add_slides() {
  for (const SlideEntry& entry : document_.slides) {
    Material m;
    Anchor a, b;
    const bool sound = material_of(entry, entry, -1.0, m);
    if (!bodies_of(entry, entry.between, a, b) || !sound) continue;
    attempt(entry, [&] {
      with_target(entry.target, entry.label + ": target", problems_, [&](const auto& target) {
        const int id = add_slide(builder_, a, b, entry.place_at, entry.axis, m, target);
        record(entry, entry.name, {id}, {"along"}, ends_at(builder_, a, b, entry.place_at));
      });
    });
  }
}

void Assembly::add_perpendiculars() {
  for (const PerpendicularEntry& entry : document_.perpendiculars) {
    Material m;
    Anchor a, b;
    const bool sound = material_of(entry, entry, kRigid, m);
    if (!bodies_of(entry, entry.between, a, b) || !sound) continue;
    attempt(entry, [&] {
      const Vector3d n_a = builder_.direction_in(a, entry.direction_a),
                     n_b = builder_.direction_in(b, entry.direction_b);
      if (a.body < 0) a = add_point(Vector3d::Zero());
      if (b.body < 0) b = add_point(Vector3d::Zero());
      const int id = builder_.add(PerpendicularRow{{a, b, m.stiffness, m.damping_time, m.damping}, n_a, n_b});
      record(entry, entry.name, {id}, {"perpendicular"}, {a.body >= 0 ? a : b, b.body >= 0 ? b : a});
    });
  }
}

}  // namespace feder
