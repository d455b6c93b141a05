#include <cmath>

#include "models/scene_file/assembly.h"
#include "models/scene_file/functions.h"

namespace feder {

void Assembly::add_forces() {
  for (const ForceEntry& entry : document_.forces) {
    const Named* named = look_up(entry, entry.on.name, {Kind::kParticle, Kind::kBody, Kind::kGroup},
                                 "a particle, a body or a group");
    if (!named || entry.broken) continue;
    std::vector<int> members = {named->index};
    if (named->kind == Kind::kGroup) members = scene_.groups[static_cast<std::size_t>(named->index)].members;
    Vector3d constant = Vector3d::Zero();
    std::array<std::optional<Expression>, 3> parts;
    bool varies = false, sound = true;
    for (std::size_t c = 0; c < 3; ++c) {
      const FunctionText& text = entry.force[c];
      if (text.kind == FunctionText::Kind::kTable) {
        tell(entry, text.place, "force = a table, expected a number or an expression");
        sound = false;
        continue;
      }
      varies = varies || text.kind == FunctionText::Kind::kExpression;
      constant[static_cast<Eigen::Index>(c)] = text.number;
      parts[c] = expression_of(text, kForceVariables, entry.label + ": force", problems_);
      sound = sound && parts[c];
    }
    if (!sound) continue;
    ForceField field{{*parts[0], *parts[1], *parts[2]}, {}};  // bodies are -1 - body until there is a system
    for (int member : members) {
      const SceneNode& node = scene_.nodes[static_cast<std::size_t>(member)];
      if (!varies)
        attempt(entry, [&] { builder_.add_constant_force({node.node, node.body}, constant); });
      else
        field.nodes.push_back(node.body >= 0 ? -1 - node.body : node.node);
    }
    if (varies) fields_.push_back({&entry, field});
  }
  if (!fields_.empty() && problems_.empty()) set_fields();
}

// Centres of bodies have node numbers only in a built system: built once without these forces to learn them.
void Assembly::set_fields() {
  attempt(document_, [&] {
    bool bodies = false;
    for (const Field& field : fields_)
      for (int node : field.field.nodes) bodies = bodies || node < 0;
    if (bodies) {
      const System without = builder_.build().system;
      for (Field& field : fields_)
        for (int& node : field.field.nodes)
          if (node < 0) node = without.bodies[static_cast<std::size_t>(-1 - node)].centre;
    }
    std::vector<ForceField> fields;
    for (const Field& field : fields_) fields.push_back(field.field);
    builder_.set_user_force(force_from(fields));
  });
}

// What is not finite at the start would end the run at its first step: told here, with its place.
void Assembly::check_start(const Scene& scene) {
  const System& s = scene.model.system;
  const State& start = scene.model.state;
  for (const auto& [entry, field] : fields_)
    for (std::size_t c = 0; c < 3; ++c)
      for (const int node : field.nodes)
        if (const double f = force_component(field, c, 0.0, start.q, start.v, node); !std::isfinite(f)) {
          tell(*entry, entry->force[c].place,
               "force = " + quoted(field.force[c].text()) + " is " + (std::isnan(f) ? "nan" : to_text(f)) +
                   " at the start, expected a finite number");
          break;
        }
  VectorXd force = VectorXd::Zero(start.v.size());
  for (std::size_t i = 0; i < law_springs_.size(); ++i) {
    const LawSpringEntry& entry = *law_springs_[i];
    const LawSpring& spring = s.law_springs[i];
    if (!(spring.length(start.q.data()) > 0.0))
      tell(entry, entry.place, "its ends coincide at the start, expected two places: it needs a direction");
    else if (!spring.add_force(start.q.data(), start.v.data(), force.data()))
      tell(entry, entry.tension.place,
           "tension is not finite at the start, at the length " + to_text(spring.length(start.q.data())) +
               " m");
  }
}

void Assembly::add_torques() {
  for (const TorqueEntry& entry : document_.torques)
    if (const Named* named = look_up(entry, entry.on, {Kind::kBody}, "a body"))
      attempt(entry, [&] { builder_.add_constant_torque(named->anchor, entry.torque); });
}

}  // namespace feder
